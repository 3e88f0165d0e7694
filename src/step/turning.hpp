// What constraints between centres miss in the incremental form because their directions turn within the step.
//
// That form leaves each change of a multiplier along the direction that it was made in. Where the rows are solved, the momenta
// are those of implicit Euler only if no direction has turned since: v = v~ + W (sum of all impulses along the directions at the
// end of the step). A step counts as converged where what is missing is within the tolerance too; and where iterations are left,
// the solve goes on in the total form, which misses nothing. So most of it goes at the cost of the one form, and it ends at the
// solution of the other.
#pragma once

#include <functional>
#include <memory_resource>
#include <span>
#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

// The velocity of each body (m/s; x, y, z, and 1/m), before anything has acted on it in the solve.
std::pmr::vector<Vec4d> velocities_of(std::span<const SolverBody> bodies, std::pmr::memory_resource* memory);

class Turning {
 public:
  // Of the bodies as the solve has left them; `predicted`: their velocities before it. Collective.
  Turning(RankState& state, const System& system, std::span<const Vec4d> predicted);

  double distance() const { return distance_; }  // m, h |v~ + W (sum of impulses) - v|, the largest of particles over all ranks

  // Lets all go on in the total form: applies what is missing. Collective.
  void apply(RankState& state, System& system) const;

 private:
  std::pmr::vector<Vec4d> missing_;  // m/s, of each home particle that moves; else 0
  double distance_ = 0;
};

// Where a position stage has iterations left, since its rows are solved or for what they hide (StopRule::hidden), and more is
// missing than the tolerance (m) and than the rows have left, ends it in the total form. `run(n)` runs at most n iterations of
// it. Where that does not take most of it away, all is as it was. Returns what is missing in the end. Collective.
struct TurningLeft {
  double distance = 0;  // m
  int iterations = 0;   // that it took
};
TurningLeft take_out_turning(RankState& state, System& system, std::span<const Vec4d> predicted, double tolerance, int iterations,
                             const std::function<int(int)>& run);

}  // namespace unibody
