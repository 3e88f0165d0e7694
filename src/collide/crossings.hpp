// Crossings: edges of cloths and threads that go through faces of cloths. A valid state has none, whatever a thickness or a gap
// may be; from one that has, contacts can't tell which side of a cloth is the right one.
#pragma once

#include <array>
#include <memory_resource>
#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

using Face = std::array<Slot, 3>;  // places of nodes in an array of positions
using Edge = std::array<Slot, 2>;

// Places in the lists of edges and faces.
struct Crossing {
  std::int32_t edge, face;
  bool operator==(const Crossing&) const = default;
};

// All pairs of an edge and a face that have a point in common (`edge_crosses_face`: exact, touching included) and no node,
// ascending by edge, then face. Two nodes at the same position are two nodes.
// `counted`, an entry per edge: 0 leaves the edge out, at no cost; none: all count. Where each edge counts on one rank alone, and
// that rank holds all faces that can reach it, the sizes of the results add up to the number of crossings of the scene.
// Edges and faces with a node whose position is not finite cross nothing.
std::vector<Crossing> find_crossings(std::span<const Vec3> positions, std::span<const Face> faces, std::span<const Edge> edges,
                                     std::span<const std::uint8_t> counted = {},
                                     std::pmr::memory_resource* memory = std::pmr::get_default_resource());

// The sides of the faces, each once, the smaller slot first, ascending.
std::vector<Edge> unique_edges(std::span<const Face> faces);

}  // namespace unibody
