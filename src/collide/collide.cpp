#include "collide/collide.hpp"

#include <cmath>
#include <limits>

#include "core/room.hpp"

namespace unibody {

namespace {

// Both sides of the margin rule: the reaches of two bodies add up to at least the margin of the pair (narrowphase.hpp).
Bounds swept_bounds_of(const Proxy& p, const CollideSettings& settings) {
  if (p.kind == ShapeKind::plane) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {Vec3::Constant(-infinity), Vec3::Constant(infinity)};
  }
  Vec3 extent = Vec3::Constant(p.half.x());
  if (p.kind == ShapeKind::box) extent = p.rotation.cwiseAbs() * p.half;
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
    : proxies_(memory), bounds_(memory), roles_(memory), planes_(memory), pairs_(memory), broad_phase_(memory) {}

void Collider::collide(const World& world, const CollideSettings& settings, Contacts& contacts) {
  contacts.clear();
  pairs_.clear();
  gather(world, settings);
  pair_with_planes(settings);
  broad_phase_.find(bounds_, roles_, pairs_);

  PairManifold found;
  for (const IndexPair& pair : broad_phase_.sort(pairs_, proxies_.size())) {
    const Proxy &a = proxies_[pair.first], &b = proxies_[pair.second];
    if (a.group >= 0 && a.group == b.group) continue;
    collide_pair(a, b, settings, found);
    if (found.count == 0) continue;
    make_room(contacts.manifolds, contacts.manifolds.size() + 1);
    make_room(contacts.points, contacts.points.size() + static_cast<std::size_t>(found.count));
    const double friction = settings.friction[a.material * settings.material_count + b.material];
    contacts.manifolds.push_back({a.id, b.id, a.slot, b.slot, found.normal, friction,
                                  static_cast<std::uint32_t>(contacts.points.size()), static_cast<std::uint32_t>(found.count)});
    contacts.points.insert(contacts.points.end(), found.points, found.points + found.count);
  }
}

// Merges homes, guests and statics, each in ascending id, into one order by id: pairs sorted by index are then sorted by id.
void Collider::gather(const World& world, const CollideSettings& settings) {
  proxies_.clear(), bounds_.clear(), roles_.clear(), planes_.clear();
  proxies_.reserve(world.size()), bounds_.reserve(world.size()), roles_.reserve(world.size());
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
      if (!a.home || a.kind == ShapeKind::plane) continue;
      if (up.dot(a.position - b.position) - a.radius > pair_margin(a, b, settings)) continue;
      pairs_.push_back({std::min(i, plane), std::max(i, plane)});
    }
  }
}

void collide(const World& world, const CollideSettings& settings, Contacts& contacts) {
  Collider().collide(world, settings, contacts);
}

}  // namespace unibody
