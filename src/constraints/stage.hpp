// The stages of a solve.
#pragma once

#include <algorithm>

#include "core/simd.hpp"

namespace unibody {

// The islands that a stage solves (step/islands.hpp): all of them, those without constraints beside contacts, or the others.
enum class Islands { all, free, constrained };

// The two stages' right-hand sides: what gap a contact may close within the step.
struct Stage {
  enum class Kind { velocity, position } kind = Kind::position;
  double step = 0.016;                // s
  double recovery_time = 0.016;       // s; position stage only
  double recovery_speed = 0.25;       // m/s, 0: unbounded; position stage only
  double surface_recovery_time = -1;  // s, that of contacts of surfaces; negative: as that of others
  bool reevaluates = false;           // gaps are taken anew before each iteration
  Islands islands = Islands::all;     // all others stay as they are

  // The stage of the velocity level: open gaps may close, and penetration falls by the share gamma a step, at any speed.
  static Stage stabilised(double step, double gamma) { return {Kind::position, step, step * (1 / gamma - 1), 0}; }

  // Bias (m/s) of the normal row at a gap (m): what the approach speed is measured against. Open gaps may close within the step;
  // a velocity stage leaves penetration alone; a position stage takes it out at a bounded speed.
  Vec4d bias(Vec4d gap) const {
    const Vec4d zero = broadcast(0), open = gap / broadcast(step);
    if (kind == Kind::velocity) return max(zero, open);
    const Vec4d outward = gap / broadcast(step + recovery_time);
    return select(gap >= zero, open, recovery_speed > 0 ? max(outward, broadcast(-recovery_speed)) : outward);
  }
  double bias(double gap) const { return bias(broadcast(gap))[0]; }
};

}  // namespace unibody
