#include "collide/collide.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collide/crowds.hpp"
#include "collide/merge_supports.hpp"
#include "collide/restitution.hpp"
#include "core/capacity.hpp"

namespace unibody {

namespace {

// Both sides of the margin rule: the reaches of two bodies add up to at least the margin of the pair (narrowphase.hpp).
Bounds swept_bounds_of(const Proxy& p, const CollideSettings& settings) {
  if (p.kind == ShapeKind::plane) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {Vec3::Constant(-infinity), Vec3::Constant(infinity)};
  }
  Vec3 extent = Vec3::Constant(p.half.x());
  if (p.kind == ShapeKind::box)
    extent = p.rotation.cwiseAbs() * p.half;
  else if (!is_round(p.shape()))
    extent = bounding_half_extents(p.shape(), p.rotation);
  const double reach = settings.margin / 2 + settings.step * p.speed + p.spin_reach + p.fall;
  extent.array() += reach;
  Bounds bounds{p.position - extent, p.position + extent};
  if (settings.planar) bounds.lower.y() = bounds.upper.y() = 0;
  return bounds;
}

}  // namespace

Bounds swept_bounds(const World& world, std::size_t slot, const CollideSettings& settings) {
  return swept_bounds_of(make_proxy(world, slot, settings), settings);
}

Collider::Collider(std::pmr::memory_resource* memory)
    : proxies_(memory),
      bounds_(memory),
      roles_(memory),
      filters_(memory),
      edges_(memory),
      planes_(memory),
      pairs_(memory),
      broad_phase_(memory) {}

void Collider::collide(const World& world, const CollideSettings& settings, Contacts& contacts, const Surfaces* surfaces,
                       std::span<const std::int32_t> crowd_ranks) {
  const std::size_t manifolds = contacts.manifolds.size(), points = contacts.points.size();  // of the last step
  contacts.clear();
  renew_room(contacts.manifolds, manifolds + manifolds / 32), renew_room(contacts.points, points + points / 32);
  pairs_.clear();
  gather(world, settings);
  if (surfaces)
    for (std::size_t i = 0; i < proxies_.size(); ++i)
      if (surfaces->is_interior(proxies_[i].slot)) roles_[i] = Role::absent;
  if (surfaces) add_surfaces(world, *surfaces, settings);
  find_pairs(world, crowd_ranks);
  pair_with_planes(settings);
  const std::size_t others = bounds_.size();
  edges_.clear();
  if (surfaces) pair_edges(world, *surfaces, settings);

  const auto bodies = static_cast<std::int32_t>(proxies_.size());
  const auto pairs = broad_phase_.sort(pairs_, others + edges_.size());
  for (const IndexPair& pair : pairs)
    if (pair.second < bodies) collide_bodies(proxies_[pair.first], proxies_[pair.second], settings, contacts);
  if (surfaces) {
    SurfaceCollider collider(world, *surfaces, settings, contacts.surface);
    for (const IndexPair& pair : pairs)
      if (pair.second >= bodies) collide_surface(pair, *surfaces, collider);
    collider.finish();
  }
  if (!settings.restitution.empty()) set_bounces(world, settings, contacts);
}

void Collider::find_pairs(const World& world, std::span<const std::int32_t> crowd_ranks) {
  if (crowd_ranks.empty()) return broad_phase_.find(bounds_, roles_, pairs_, filters_);
  std::vector<Crowds::Member> members;
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    const auto slot = static_cast<std::size_t>(proxies_[i].slot);
    if (crowd_ranks[slot] >= 0)
      members.push_back(
          {crowd_cell(world.properties[slot], world.position[slot]), crowd_ranks[slot], static_cast<std::int32_t>(i)});
  }
  const Crowds crowds(std::move(members));
  const std::vector<Bounds> bounds(bounds_.begin(), bounds_.end());
  const std::vector<Role> roles(roles_.begin(), roles_.end());
  const std::vector<Filter> filters(filters_.begin(), filters_.end());
  crowds.stand_for(bounds_, roles_, filters_);
  broad_phase_.find(bounds_, roles_, pairs_, filters_);
  crowds.expand(pairs_, bounds, roles, filters);
  std::copy(roles.begin(), roles.end(), roles_.begin());  // planes look at them, too
}

void Collider::collide_bodies(const Proxy& a, const Proxy& b, const CollideSettings& settings, Contacts& contacts) {
  const double friction = settings.friction[a.material * settings.material_count + b.material];
  const auto add = [&](const PairManifold& found) {
    make_room(contacts.manifolds, contacts.manifolds.size() + 1);
    make_room(contacts.points, contacts.points.size() + static_cast<std::size_t>(found.count));
    contacts.manifolds.push_back({a.id, b.id, a.slot, b.slot, found.normal, friction,
                                  static_cast<std::uint32_t>(contacts.points.size()), static_cast<std::uint32_t>(found.count),
                                  found.time});
    contacts.points.insert(contacts.points.end(), found.points, found.points + found.count);
  };
  if (!settings.merge_supports || (!is_composite(a.kind) && !is_composite(b.kind))) return collide_parts(a, b, settings, add);
  std::vector<PairManifold> manifolds;
  collide_parts(a, b, settings, [&](const PairManifold& found) { manifolds.push_back(found); });
  merge_supports(manifolds, settings.margin);
  for (const PairManifold& m : manifolds) add(m);
}

// Nodes meet the faces of others, and those of their own surface if it collides with itself.
void Collider::add_surfaces(const World& world, const Surfaces& surfaces, const CollideSettings& settings) {
  constexpr std::uint8_t body = 1, node = 2, face = 4;
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    const Slot s = proxies_[i].slot;
    const bool is_node = surfaces.is_node(s);
    filters_[i].kind = is_node ? node : body;
    filters_[i].accepts = is_node ? body | face : body | node | face;
    if (!is_node) continue;
    filters_[i].group = surfaces.contact_group(world, s);
    bounds_[i] = swept_bounds(world, std::span(&s, 1), settings);
  }
  for (const SurfaceFace& f : surfaces.faces) {
    bounds_.push_back(swept_bounds(world, f.nodes, settings));
    roles_.push_back(f.home ? Role::home : Role::other);
    filters_.push_back({surfaces.contact_group(world, f.nodes[0]), face, body | node});
  }
}

// Sharp edges meet each other; in the pairs they are numbered on from bodies and faces.
void Collider::pair_edges(const World& world, const Surfaces& surfaces, const CollideSettings& settings) {
  if (!surfaces.edges_may_meet()) return;
  const auto before = static_cast<std::int32_t>(bounds_.size());
  bounds_.clear(), roles_.clear(), filters_.clear();
  for (std::size_t k = 0; k < surfaces.edges.size(); ++k) {
    const SurfaceEdge& e = surfaces.edges[k];
    if (!is_sharp(world, e)) continue;
    edges_.push_back(static_cast<std::int32_t>(k));
    bounds_.push_back(swept_bounds(world, e.nodes, settings));
    roles_.push_back(e.home ? Role::home : Role::other);
    filters_.push_back({surfaces.contact_group(world, e.nodes[0])});
  }
  broad_phase_.find(bounds_, roles_, pairs_, filters_, before);
}

void Collider::collide_surface(const IndexPair& pair, const Surfaces& surfaces, SurfaceCollider& collider) {
  const auto bodies = static_cast<std::int32_t>(proxies_.size());
  const auto edges = bodies + static_cast<std::int32_t>(surfaces.faces.size());
  if (pair.first >= edges) return collider.edge_edge(edges_[pair.first - edges], edges_[pair.second - edges]);
  const Proxy& body = proxies_[pair.first];
  surfaces.is_node(body.slot) ? collider.node_face(body.slot, pair.second - bodies)
                              : collider.body_face(body, pair.second - bodies);
}

// Merges homes, guests and statics, each in ascending id, into one order by id: pairs sorted by index are then sorted by id.
void Collider::gather(const World& world, const CollideSettings& settings) {
  proxies_.clear(), bounds_.clear(), roles_.clear(), filters_.clear(), planes_.clear();
  proxies_.reserve(world.size()), bounds_.reserve(world.size()), roles_.reserve(world.size());
  filters_.reserve(world.size());
  const std::size_t ends[3] = {world.homes, world.first_static(), world.size()};
  std::size_t next[3] = {0, world.homes, world.first_static()};
  for (std::size_t k = 0; k < world.size(); ++k) {
    int from = -1;
    for (int r = 0; r < 3; ++r)
      if (next[r] < ends[r] && (from < 0 || world.id[next[r]] < world.id[next[from]])) from = r;
    const Proxy& p = proxies_.emplace_back(make_proxy(world, next[from]++, settings));
    bounds_.push_back(swept_bounds_of(p, settings));
    const bool plane = p.kind == ShapeKind::plane;
    roles_.push_back(plane ? Role::absent : p.home ? Role::home : Role::other);
    filters_.push_back({p.group});
    if (plane) planes_.push_back(static_cast<std::int32_t>(k));
  }
}

// Planes have no bounds: each is tried with every home body, by its bounding sphere.
void Collider::pair_with_planes(const CollideSettings& settings) {
  for (const std::int32_t plane : planes_) {
    const Proxy& b = proxies_[plane];
    const Vec3 up = b.rotation.col(2);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(proxies_.size()); ++i) {
      const Proxy& a = proxies_[i];
      if (!a.home || roles_[i] == Role::absent) continue;
      if (up.dot(a.position - b.position) - a.radius > pair_margin(a, b, settings)) continue;
      pairs_.push_back({std::min(i, plane), std::max(i, plane)});
    }
  }
}

void collide(const World& world, const CollideSettings& settings, Contacts& contacts) {
  Collider().collide(world, settings, contacts);
}

}  // namespace unibody
