// Momentum for Gauss-Seidel: after every two sweeps the velocities and all multipliers go on, by Nesterov's share, in the
// direction in which the two sweeps took them.
//
// A sweep forwards and one backwards over the contacts are together one step of a gradient method whose metric is symmetric, so
// momentum makes of it what it makes of a Jacobi sweep: the error falls as 1/k^2 rather than 1/k. Links and joints are swept
// forwards alone, which no such bound is known of, and gain as much (scripts/bench acceleration). Velocities are linear in the
// multipliers, as long as the rows are, and go along with them: nothing has to be summed anew.
#pragma once

#include <memory_resource>
#include <vector>

#include "constraints/sweep.hpp"
#include "core/simd.hpp"
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
  // A body's velocities (m/s, rad/s). The fourth components are its inverse mass and inertia, as in SolverBody: extrapolation
  // leaves alone what does not change.
  struct alignas(64) Motion {
    Vec4d linear, angular;
  };
  static_assert(sizeof(Motion) == sizeof(SolverBody));

  // Nesterov's share grows with the sweeps, however fast they converge by themselves, and momentum b lets no mode shrink faster
  // than by the root of b times what two plain sweeps leave of it. Where the last two left the share r of the step before, r^2 is
  // the bound: near 1 the fastest there is, (1 - s) / (1 + s) with s = 1 - r, and nothing where sweeps are fast. (progress: J,
  // which goes by the square of the steps.)
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
