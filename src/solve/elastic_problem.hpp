// The reference step where every row has compliance E > 0: the impulses are eliminated,
//   lambda_k = -h (c_k(x) + rho D_k^T v) / E_k,    x = x_l + h v,
// and the unknowns are the velocities v (m/s) of the bodies that move alone:
//   (M (v - v~) - D lambda(v)) / m = 0             (m/s; m the mean mass, which keeps the Jacobian symmetric)
// Its Jacobian, times m: M + D (h (h + rho) / E) D^T - h sum lambda_k d2c_k/dx2, and D_k (h^2 rho / E_k) (d2c_k/dx2 v)^T, which
// is not symmetric, where the damped direction turns. One symmetric block of 3 x 3 a pair of neighbours, for which fast direct
// and multigrid solvers are made. A step much longer than any period gives the static equilibrium.
#pragma once

#include "solve/implicit_step.hpp"
#include "solve/newton.hpp"

namespace unibody {

// World and constraints must outlive it; all bodies are home or static here.
class ElasticProblem : public NewtonProblem {
 public:
  ElasticProblem(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted, double step);

  std::size_t size() const override { return step_.velocities(); }
  // Predicted velocities or none, whichever leave less: in a long step the prediction is far away.
  Eigen::VectorXd start() const override;
  Eigen::VectorXd residual(const Eigen::VectorXd& velocities) const override;
  void pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const override;
  void jacobian(const Eigen::VectorXd& velocities, std::vector<double>& values) const override;
  bool is_symmetric() const override { return !damped_; }
  std::vector<Vec3> points() const override { return points_; }
  double scale() const override;  // momenta, and the elastic impulses of a displacement as long as the places

  std::size_t velocities() const { return step_.velocities(); }
  std::vector<Vec3> velocity(const Eigen::VectorXd& velocities) const { return step_.velocities(velocities); }  // of each slot
  ConstraintMultipliers multipliers(const Eigen::VectorXd& velocities) const;

 private:
  void find_neighbours();
  std::size_t block(std::ptrdiff_t a, std::ptrdiff_t b) const;  // of the Jacobian, number of the points a and b's

  const ImplicitStep step_;
  std::vector<Vec3> points_;                // m, of each body that moves, at the start of the step
  std::vector<double> mass_;                // kg, of each of them
  double mean_mass_ = 1;                    // kg
  std::vector<std::size_t> first_block_;    // of each of them; the Jacobian's blocks by rows
  std::vector<std::ptrdiff_t> neighbours_;  // ascending in a row: the point of each block's column
  bool damped_ = false;
};

}  // namespace unibody
