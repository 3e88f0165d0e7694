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
#pragma once

#include <petscsystypes.h>

#include <span>
#include <string>

#include "constraints/constraint_types.hpp"
#include "world/world.hpp"

namespace unibody {

// The residual of a step and its derivative. World and constraints must outlive it; all bodies are home or static here.
class ReferenceProblem {
 public:
  ReferenceProblem(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step);

  std::size_t size() const { return velocities_ + rows_; }
  Eigen::VectorXd start() const;  // predicted velocities, no impulses
  Eigen::VectorXd residual(const Eigen::VectorXd& unknowns) const;

  // The Jacobian as entries (row, column, value) that add up; an entry of a body that does not move has an index of -1. Rows and
  // columns are the same at all states. `softening` (m/N): least compliance of a row in the Jacobian alone.
  void pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const;
  void jacobian(const Eigen::VectorXd& unknowns, double softening, std::vector<double>& values) const;

  std::vector<Vec3> velocity(const Eigen::VectorXd& unknowns) const;  // of each slot
  ConstraintMultipliers multipliers(const Eigen::VectorXd& unknowns) const;

  // The size (m/s) of what cancels in a residual, to judge it by: positions over the step, and velocities.
  double scale() const;

 private:
  template <class C>
  using SlotList = std::vector<std::array<Slot, C::stencil>>;

  template <typename F>
  void for_each_constraint(F&& f) const;  // f(constraint, its slots, its first row)
  Vec3 velocity_of(Slot slot, const Eigen::VectorXd& unknowns) const;

  const World& world_;
  const ConstraintSet& constraints_;
  const double step_;
  std::vector<Vec3> predicted_;           // m/s, of each slot
  std::vector<double> inverse_mass_;      // 1/kg, of each slot
  std::vector<std::ptrdiff_t> first_of_;  // first unknown of each slot, -1 where it does not move
  ConstraintTypes::Tuple<SlotList> slots_;
  std::size_t velocities_ = 0, rows_ = 0;
};

struct ReferenceSettings {
  int iterations = 50;
  double tolerance = 1e-13;  // of the residual, over the problem's scale()
  // m/N. Redundant stiff rows make the system singular. A least compliance in the Jacobian alone makes it regular and leaves the
  // solution as it is; the more of it, the more iterations.
  double softening = 0;
};

struct ReferenceStep {
  std::vector<Vec3> velocity;         // m/s, of each slot, at the end of the step
  ConstraintMultipliers multipliers;  // N s
  int iterations = 0;                 // of Newton's method
  double residual = 0;                // m/s, largest entry
  bool converged = false;             // the residual is within the tolerance
  std::string reason;                 // why PETSc's SNES stopped
};

// Needs an initialised PETSc. Throws RunError where PETSc fails; a step that does not converge is no error.
ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step,
                             const ReferenceSettings& settings = {});

}  // namespace unibody
