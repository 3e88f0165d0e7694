// Pairs of bounds in a periodic scene (world/period.hpp): two bodies are a pair where any images of them overlap.
#pragma once

#include "collide/broadphase.hpp"
#include "world/period.hpp"

namespace unibody {

// Bounds as seen in the cell: one copy for each image of them that reaches into it. Where bounds overlap in any images, some of
// their copies do.
struct Copies {
  std::vector<Bounds> bounds;
  std::vector<std::int32_t> of;  // whose copy each is

  Copies(std::span<const Bounds> whole, const Period& period);  // without a period each has one, itself
};

// As BroadPhase::find; each pair is appended once.
void find_periodic(BroadPhase& broad_phase, const Period& period, std::span<const Bounds> bounds, std::span<const Role> roles,
                   Pairs& pairs, std::span<const Filter> filters = {});

// Whether bounds overlap, the second moved to where its middle is nearest to that of the first.
bool overlap_in_images(const Bounds& a, const Bounds& b, const Period& period);

}  // namespace unibody
