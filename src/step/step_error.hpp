// How far a step is from the one that its solver would converge to.
#pragma once

#include <limits>
#include <vector>

#include "constraints/contact_batch.hpp"
#include "constraints/solver_body.hpp"
#include "core/types.hpp"

namespace unibody {

// The converged step starts from the same state, with the same contacts and the same prediction. With h the step, m and I a
// body's mass and inertia, and dv, dw what its velocities differ by, the distance of two steps is that of the positions that they
// lead to, to first order in h: h sqrt(sum (m dv.dv + dw.I dw) / sum m) over the bodies that move.
struct StepError {
  double distance = 0;            // m, of the step as taken to the converged one
  double relative = 0;            // the same over the distance of the unconstrained prediction to the converged step
  double reference_residual = 0;  // m, natural residual of the converged step: the distance is known no better than this allows
  int iterations = 0;             // spent on it
};

// A step solved until it converges, or as far as it gets.
struct ConvergedStep {
  std::vector<SolverBody> moving;                             // of each home body, with the velocities that it moves with
  double residual = std::numeric_limits<double>::infinity();  // m, natural residual
  int iterations = 0;                                         // spent on it
};

// What a step has come to when its solve ends, before the guard of surfaces, friction after the solve and the motion of the
// bodies. The bodies are numbered as in System.
struct SolvedStep {
  std::vector<SolverBody> predicted, solved;
  std::vector<Vec3> velocity_before;            // m/s, the World's, when the step began
  std::vector<ContactBatch::Impulse> impulses;  // N s, of both stages together: index = that of Contacts::points
};

}  // namespace unibody
