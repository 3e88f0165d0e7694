// Momentum for Gauss-Seidel: after every two sweeps the velocities and all multipliers go on, by Nesterov's share, in the
// direction in which the two sweeps took them.
//
// A sweep forwards and one backwards are together one step of a gradient method whose metric is symmetric, so momentum makes
// of it what it makes of a Jacobi sweep: the error falls as 1/k^2 rather than 1/k. Velocities are linear in the multipliers, as
// long as the rows are, and go along with them: nothing has to be summed anew.
#pragma once

#include <array>
#include <memory_resource>
#include <vector>

#include "constraints/sweep.hpp"
#include "solve/momentum.hpp"
#include "solve/solver.hpp"

namespace unibody {

class SweepMomentum {
 public:
  // At the start of a stage.
  explicit SweepMomentum(System& system);

  // After the sweeps: of the home bodies, the terms of the restart tests, which are weighed by the bodies' masses. The change of
  // `sums` is left alone.
  void measure(SweepSums& sums) const;

  // Takes the factor from the measured sums of all ranks and extrapolates. Guests must be up to date, and stay so.
  void extrapolate(const SweepSums& sums);

  int restarts() const { return momentum_.restarts(); }

 private:
  using Motion = std::array<double, 6>;  // m/s, rad/s
  static Motion motion_of(const SolverBody& body) { return {body.v[0], body.v[1], body.v[2], body.w[0], body.w[1], body.w[2]}; }

  // Nesterov's share grows with the sweeps, however fast they converge by themselves. Where two sweeps leave the share r of the
  // error, the fastest momentum is r / (2 - r): (1 - s) / (1 + s) with s = 1 - r the root of the smallest eigenvalue.
  double largest_share(double progress);

  System& system_;
  Momentum momentum_{Acceleration::nesterov};
  double unit_ = 1;
  double progress_ = 0;  // J, of the last two sweeps; 0: none are measured yet
  bool is_first_ = true;
  std::pmr::vector<Motion> before_, start_;  // of each body: after the last two sweeps, and where these two started
  std::pmr::vector<double> unknowns_;        // of all batches, after the last two sweeps
};

}  // namespace unibody
