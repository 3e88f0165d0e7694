// Triangles of surfaces on which something pushes besides contacts.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/types.hpp"
#include "world/world.hpp"

namespace unibody {

// Sorts triangles, which have `nodes`, three slots, by the ids of these: what a node sums over its triangles has then the same
// bits on any number of ranks.
template <class Triangle>
void sort_by_ids(const World& world, std::vector<Triangle>& triangles) {
  const auto key = [&](const Triangle& t) {
    std::array<Id, 3> ids;
    for (std::size_t i = 0; i < 3; ++i) ids[i] = world.id[static_cast<std::size_t>(t.nodes[i])];
    return ids;
  };
  std::sort(triangles.begin(), triangles.end(), [&](const Triangle& a, const Triangle& b) { return key(a) < key(b); });
}

// m^2, along the normal of a triangle, twice its area long; where its nodes are after a time (s) at their velocities.
template <class Triangle>
Vec3 doubled_area(const World& world, const Triangle& t, double after = 0) {
  const auto place = [&](std::size_t i) -> Vec3 {
    const auto slot = static_cast<std::size_t>(t.nodes[i]);
    return after == 0 ? world.position[slot] : Vec3(world.position[slot] + after * world.velocity[slot]);
  };
  return (place(1) - place(0)).cross(place(2) - place(0));
}

}  // namespace unibody
