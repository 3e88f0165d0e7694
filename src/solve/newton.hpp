// Newton's method to round-off on a sparse system, serial: PETSc's SNES.
//
// Elastic bodies first try full steps: a step that bends a slender body stretches it, so that the residual grows before it falls,
// and a line search on its norm crawls. Where that does not converge, and for all else, the line search backtracks.
#pragma once

#include <petscsystypes.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// A system residual(unknowns) = 0, all in m/s.
class NewtonProblem {
 public:
  virtual ~NewtonProblem() = default;
  virtual std::size_t size() const = 0;
  virtual Eigen::VectorXd start() const = 0;
  virtual Eigen::VectorXd residual(const Eigen::VectorXd& unknowns) const = 0;

  // The Jacobian as entries (row, column, value) that add up; an entry with an index of -1 is none. Rows and columns are the same
  // at all states.
  virtual void pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const = 0;
  virtual void jacobian(const Eigen::VectorXd& unknowns, std::vector<double>& values) const = 0;
  virtual bool is_symmetric() const { return false; }

  // m; where the unknowns are those of points in space, three of each: the Jacobian then is that of an elastic body.
  virtual std::vector<Vec3> points() const { return {}; }

  // The size (m/s) of what cancels in a residual, to judge it by.
  virtual double scale() const = 0;
};

// direct: MUMPS. cg: conjugate gradients with algebraic multigrid, for large problems that have points(); GMRES where the
// Jacobian is not symmetric. automatic: cg for more than 60,000 unknowns of points.
enum class LinearSolver { automatic, direct, cg };

struct NewtonSettings {
  int iterations = 50;       // of each try
  double tolerance = 1e-13;  // of the residual, over the problem's scale()
  LinearSolver linear = LinearSolver::automatic;
};

struct NewtonResult {
  Eigen::VectorXd unknowns;
  Eigen::VectorXd correction;  // what one more iteration would take off them, by the last Jacobian
  int iterations = 0;
  double residual = 0;     // m/s, largest entry
  bool converged = false;  // the residual is within the tolerance
  std::string reason;      // why SNES stopped
};

// Needs an initialised PETSc. A failure of PETSc ends the program (core/checked.hpp); to not converge is no error.
NewtonResult newton(const NewtonProblem& problem, const NewtonSettings& settings = {});

}  // namespace unibody
