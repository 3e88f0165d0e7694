// Nesterov's momentum with two restarts (O'Donoghue & Candes 2015), driven by sums that are one iteration old, so that their
// reduction over the ranks hides behind a sweep.
#pragma once

#include <cmath>
#include <limits>

#include "constraints/system.hpp"

namespace unibody {

class Momentum {
 public:
  // The extrapolation factor of the next sweep, from the sums of the last one. 0 at a restart: where the last step went uphill
  // (gradient test), or where it was more than twice the smallest so far (residual test: stiff chains need it).
  double next(const SweepSums& last, bool sums_are_valid) {
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
      return 0;
    }
    const double theta2 = theta_ * theta_;
    const double next = 0.5 * (theta_ * std::sqrt(theta2 + 4) - theta2);
    const double beta = theta_ * (1 - theta_) / (theta2 + next);
    theta_ = next;
    return beta;
  }

  int restarts() const { return restarts_; }

 private:
  static constexpr double growth_ = 2;
  double theta_ = 1;
  double best_ = std::numeric_limits<double>::infinity();
  int restarts_ = 0;
};

}  // namespace unibody
