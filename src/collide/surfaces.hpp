// The surfaces of flexible bodies that this rank knows: faces of cloths and segments of threads, their edges, and what lies next
// to what; by slot. Made anew whenever slots move.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "collide/broadphase.hpp"
#include "collide/collide_settings.hpp"
#include "world/surface.hpp"
#include "world/world.hpp"

namespace unibody {

struct SurfaceFace {
  std::array<Slot, 3> nodes;   // of a thread's segment the last two are equal
  std::array<Slot, 3> across;  // of edge i, from node i to i + 1: the third node of the neighbour; -1: none here
  std::int32_t surface;        // index into the scene's
  bool home;                   // one of its nodes is home

  bool is_segment() const { return nodes[1] == nodes[2]; }
};

struct SurfaceEdge {
  std::array<Slot, 2> nodes;  // ascending ids
  std::array<Slot, 2> wings;  // the third nodes of its faces; -1: none here
  std::int32_t surface;
  bool home;
};

class Surfaces {
 public:
  explicit Surfaces(const std::vector<Surface>& surfaces) : surfaces_(surfaces) {}

  // All faces whose three nodes are here. They are complete around whatever a home body can touch, if the guests are those that
  // widen() and partners() ask for.
  void build(const World& world);
  void clear();

  // Nodes within two faces of home nodes, which are not home themselves; ascending ids. Mutual between ranks.
  std::vector<Id> partners(const World& world) const;

  // Grows the bounds of home nodes to those of their faces, so that whoever touches a face meets all of its nodes, and whoever
  // touches a face those of its neighbours.
  void widen(const World& world, const CollideSettings& settings, std::span<Bounds> bounds) const;

  bool empty() const { return faces.empty(); }
  bool is_node(Slot s) const { return static_cast<std::size_t>(s) < surface_of_.size() && surface_of_[s] >= 0; }
  bool is_interior(Slot s) const {  // a node of no face, inside a solid: nothing can touch it
    return static_cast<std::size_t>(s) < interior_.size() && interior_[static_cast<std::size_t>(s)] != 0;
  }
  bool edges_may_meet() const;  // of two surfaces, or of one that collides with itself
  bool all_closed() const;
  bool is_closed(std::int32_t surface) const { return surfaces_[static_cast<std::size_t>(surface)].closed; }
  std::int32_t surface_of(Slot node) const { return surface_of_[static_cast<std::size_t>(node)]; }
  // The group within which a surface's features do not touch; -1 where it collides with itself.
  std::int32_t contact_group(const World& world, Slot node) const {
    const bool itself = surfaces_[static_cast<std::size_t>(surface_of(node))].self_collision;
    return itself ? -1 : world.properties[static_cast<std::size_t>(node)].group;
  }
  std::span<const Slot> ring(Slot node) const {  // the nodes that share an edge with it
    const auto i = static_cast<std::size_t>(node);
    return {rings_.entries.data() + rings_.start[i], rings_.start[i + 1] - rings_.start[i]};
  }
  std::size_t bytes() const;

  std::vector<SurfaceFace> faces;
  std::vector<SurfaceEdge> edges;  // each once

 private:
  void find_faces(const World& world);
  void find_edges(const World& world);

  const std::vector<Surface>& surfaces_;
  std::vector<std::int32_t> surface_of_;  // by slot; -1: no node of a surface
  std::vector<std::uint8_t> interior_;    // by slot
  struct {
    std::vector<std::uint32_t> start;  // by slot
    std::vector<Slot> entries;
  } rings_;
};

// Bounds of a node, edge or face where it is, where its velocities lead, with what its weight adds in the step, and where they
// led from: who has passed it is to be found still.
Bounds swept_bounds(const World& world, std::span<const Slot> nodes, const CollideSettings& settings);

// m: the halo brings what an edge or face meets on its straight way through the step, and on ways that a solve takes it off that
// one by up to this much, half of its extent.
double surface_slack(const World& world, std::span<const Slot> nodes);

// Whether an edge stands out from its surface by more than a tenth of the radius: only then can it meet another edge before the
// nodes meet faces, but for less than that tenth.
bool is_sharp(const World& world, const SurfaceEdge& edge);

}  // namespace unibody
