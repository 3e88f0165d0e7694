// An inlet: bodies of a scene that come in while it runs.
#pragma once

#include <functional>
#include <limits>
#include <memory>

#include "core/time_value.hpp"
#include "world/body.hpp"

namespace unibody {

// The bodies of one entry of `bodies`, numbered from 0. Body k is of the same shape and size whenever it comes in; where it comes
// in is drawn in each try by its number and the try's, so that it is the same on any number of ranks and through a restart.
struct Inlet {
  TimeValue rate;                                          // bodies/s, or kg/s
  bool by_mass = false;                                    // kg/s
  double from = 0;                                         // s: nothing comes in before
  double until = std::numeric_limits<double>::infinity();  // s: nor becomes due after
  std::function<Body(Id k, std::uint64_t draw)> place;     // a pure function; k below the entry's count
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();            // m, bounds of all places of centres
  double largest_radius = 0;                               // m, of the largest bounding sphere

  // Bodies, or kg, that are due by then.
  double due(double time) const {
    const double end = std::min(time, until);
    return end > from ? rate.mean(from, end) * (end - from) : 0;
  }
};

}  // namespace unibody
