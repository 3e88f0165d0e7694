// Momentum for gradient steps, Nesterov's or the optimized one, with two restarts (O'Donoghue & Candes 2015), driven by sums that
// are of the last sweep: their reduction over the ranks hides behind that sweep's messages, not behind the next sweep.
//
// The optimized gradient method (Kim & Fessler, Optimized first-order methods for smooth convex minimization, 2016) has
// Nesterov's sequence, and goes beyond the step itself by theta_{k+1} / theta_k as well. Its bound on the error is half of his: a
// soft mode gets as far in k iterations as with his in sqrt(2) k, for one more product a row. Here a share s of that: the whole
// of it would let the stiffest modes, on the bound of the scaling, swing on, and grow where they pass the bound. With s they may
// pass it by (1 - s) / (3 + s), with Nesterov's momentum by a third. Rows that are linear in a stage never do. Links, which turn
// within a step, do not either as a rule, where they share masses by directions and start no tighter than
// most_geometric_stiffness; under loads where they turn far within it, they do (tight_links).
#pragma once

#include <cmath>
#include <limits>

#include "constraints/solver_settings.hpp"
#include "constraints/sweep.hpp"

namespace unibody {

inline constexpr double overshoot_share = 0.9;

class Momentum {
 public:
  explicit Momentum(Acceleration acceleration) : acceleration_(acceleration) {}

  // The factors of the next sweep, from the sums of the last one. None at a restart: where the last step went uphill (gradient
  // test), or where it was more than twice the smallest so far (residual test: stiff chains need it).
  Extrapolation next(const SweepSums& last, bool sums_are_valid) {
    bool restart = false;
    if (sums_are_valid) {
      const double progress = static_cast<double>(last.progress) * last.unit;
      const bool grown = progress > growth_ * growth_ * best_;
      restart = last.gradient > 0 || grown;
      best_ = grown ? progress : std::min(best_, progress);
    }
    if (restart) {
      ++restarts_;
      theta_ = 1;
      return {};
    }
    const double theta2 = theta_ * theta_;
    const double next = 0.5 * (theta_ * std::sqrt(theta2 + 4) - theta2);
    const double overshoot = acceleration_ == Acceleration::optimized ? overshoot_share * next / theta_ : 0;
    const double momentum = theta_ * (1 - theta_) / (theta2 + next);
    theta_ = next;
    return {momentum, overshoot};
  }

  int restarts() const { return restarts_; }

 private:
  static constexpr double growth_ = 2;
  Acceleration acceleration_;
  double theta_ = 1;
  double best_ = std::numeric_limits<double>::infinity();
  int restarts_ = 0;
};

}  // namespace unibody
