// On some surfaces friction depends on the direction, as on a ribbed belt or on planed wood. Such a body has one coefficient of
// friction along an axis of its own, and another across this axis.
#pragma once

#include <algorithm>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// Of the bodies of one entry.
struct FrictionAxis {
  Id first = 0, count = 0;
  Vec3 axis = Vec3::UnitX();  // unit, in the body's axes
  double across = 1;          // the coefficient of friction across the axis, over that along it
};

// In order of their ids. Empty in most scenes.
using FrictionAxes = std::vector<FrictionAxis>;

inline const FrictionAxis* find_axis(const FrictionAxes& axes, Id id) {
  const auto after = std::ranges::upper_bound(axes, id, {}, &FrictionAxis::first);
  if (after == axes.begin()) return nullptr;
  const FrictionAxis& axis = *(after - 1);
  return id < axis.first + axis.count ? &axis : nullptr;
}

}  // namespace unibody
