// Collision detection: bodies in, contacts out. Stateless; the result depends on the pair alone, never on rank or history.
#pragma once

#include "collide/broadphase.hpp"
#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "collide/narrowphase.hpp"
#include "collide/surface_contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// A body's axis-aligned bounds (m), grown by all that it can travel or reach in a step. Two bodies whose swept bounds are
// disjoint have no contact; this is also what decides which ranks a body visits as a guest. In planar scenes y is [0, 0].
Bounds swept_bounds(const World& world, std::size_t slot, const CollideSettings& settings);

// Finds all contacts of pairs with at least one home body (dynamic); pairs of two guests, of two statics, or of a guest and a
// static are left out. An object keeps its buffers, and nothing else, from call to call.
class Collider {
 public:
  explicit Collider(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  // `contacts` is overwritten: manifolds in ascending (id_a, id_b), points in ascending feature. With surfaces, nodes of flexible
  // bodies touch each other's faces and edges; without, they are particles. crowd_ranks: by slot, each body's rank in its crowd
  // (crowds.hpp), or -1; empty: there are no crowds.
  void collide(const World& world, const CollideSettings& settings, Contacts& contacts, const Surfaces* surfaces = nullptr,
               std::span<const std::int32_t> crowd_ranks = {});

 private:
  void gather(const World& world, const CollideSettings& settings);
  void pair_with_planes(const CollideSettings& settings);
  void find_pairs(const World& world, std::span<const std::int32_t> crowd_ranks);
  void add_surfaces(const World& world, const Surfaces& surfaces, const CollideSettings& settings);
  void pair_edges(const World& world, const Surfaces& surfaces, const CollideSettings& settings);
  void collide_bodies(const IndexPair& pair, const CollideSettings& settings, Contacts& contacts);
  void mend_seams(const CollideSettings& settings, const Surfaces* surfaces, Contacts& contacts);
  void collide_surface(const IndexPair& pair, const World& world, const CollideSettings& settings, const Surfaces& surfaces,
                       SurfaceCollider& collider);

  Period period_;
  std::pmr::vector<Proxy> proxies_;  // in ascending id, in the cell of a periodic scene
  std::pmr::vector<Bounds> bounds_;  // of bodies, then of faces; then of edges
  std::pmr::vector<Role> roles_;
  std::pmr::vector<Filter> filters_;
  std::pmr::vector<std::int32_t> edges_;  // those that may meet others
  std::pmr::vector<std::int32_t> planes_;
  Pairs pairs_;

  // A pair with a manifold that may be at a seam: found again when all other pairs have been.
  struct AtSeam {
    IndexPair pair;
    std::size_t manifolds, points;  // of the pairs before it
  };
  std::pmr::vector<AtSeam> at_seams_;
  BroadPhase broad_phase_;
};

// The same with buffers of its own: for tests and single calls.
void collide(const World& world, const CollideSettings& settings, Contacts& contacts);

// Whether this rank is the one that counts a contact: its first body that is not static is home here.
inline bool counts_here(const World& world, const Manifold& m) {
  return world.is_home(world.is_static(m.slot_a) ? m.slot_b : m.slot_a);
}
inline bool counts_here(const World& world, const SurfaceContact& c) {
  return world.is_home(world.is_static(c.slots[0]) ? c.slots[1] : c.slots[0]);
}

}  // namespace unibody
