// The reference solver: one implicit Euler step of the constraints between bodies' centres, to round-off, by Newton's method on
// the sparse Karush-Kuhn-Tucker system with a direct factorisation. Slow and serial: what the iterative solvers are checked
// against.
//
// Unknowns: the velocity v (m/s, world frame) of each body that moves, and the impulse lambda (N s) of each row. With
// x = x_l + h v, D the gradients at that x, compliance E, damping rho and the predicted velocity v~ = v_l + h (g + f / m):
//   v - v~ - W D lambda = 0                                      (m/s)
//   (c(x) + E lambda / h + rho D^T v) / (h + rho) = 0            (m/s)
// D is that of the end of the step, so the geometric stiffness, sum lambda d2c/dx2, is in the Jacobian. Contacts and rotations
// are left out: the step is that of a world without contacts. Bodies that are fixed, kinematic or pinned keep their velocity.
// Where every row has compliance, ElasticProblem is the same step in fewer unknowns.
#pragma once

#include "solve/implicit_step.hpp"
#include "solve/newton.hpp"

namespace unibody {

// The residual of a step and its derivative. World and constraints must outlive it; all bodies are home or static here.
class ReferenceProblem : public NewtonProblem {
 public:
  // `softening` (m/N): least compliance of a row in the Jacobian alone.
  ReferenceProblem(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted, double step,
                   double softening = 0);
  ReferenceProblem(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step)
      : ReferenceProblem(world, constraints, predict_bodies(world, gravity, step), step) {}

  std::size_t size() const override { return step_.velocities() + step_.rows(); }
  Eigen::VectorXd start() const override;  // predicted velocities, no impulses
  Eigen::VectorXd residual(const Eigen::VectorXd& unknowns) const override;
  void pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const override;
  void jacobian(const Eigen::VectorXd& unknowns, std::vector<double>& values) const override;
  double scale() const override;  // positions over the step, and velocities

  std::size_t velocities() const { return step_.velocities(); }  // unknowns that are velocities, the first
  std::vector<Vec3> velocity(const Eigen::VectorXd& unknowns) const { return step_.velocities(unknowns); }  // of each slot
  ConstraintMultipliers multipliers(const Eigen::VectorXd& unknowns) const;

 private:
  const ImplicitStep step_;
  const double softening_;
};

struct ReferenceSettings : NewtonSettings {
  // m/N. Redundant stiff rows make the system singular. A least compliance in the Jacobian alone makes it regular and leaves the
  // solution as it is; the more of it, the more iterations.
  double softening = 0;
};

struct ReferenceStep {
  std::vector<Vec3> velocity;         // m/s, of each slot, at the end of the step
  ConstraintMultipliers multipliers;  // N s
  int iterations = 0;                 // of Newton's method
  double residual = 0;                // m/s, largest entry
  double correction = 0;              // m/s, what one more iteration would change at most
  bool converged = false;             // the residual is within the tolerance
  std::string reason;                 // why PETSc's SNES stopped
};

// By ElasticProblem where every row has compliance, else by ReferenceProblem. Needs an initialised PETSc. Throws RunError where
// PETSc fails, and for unilateral constraints; a step that does not converge is no error.
ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted,
                             double step, const ReferenceSettings& settings = {});
ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step,
                             const ReferenceSettings& settings = {});

}  // namespace unibody
