#include "collide/collide.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>

#include "collide/crowds.hpp"
#include "collide/face_patch.hpp"
#include "collide/known_contacts.hpp"
#include "collide/merge_supports.hpp"
#include "collide/nodes_ahead.hpp"
#include "collide/periodic_pairs.hpp"
#include "collide/restitution.hpp"
#include "collide/seams.hpp"
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
  const double reach = settings.margin / 2 + settings.step * p.speed + p.turn_reach() + p.fall;
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
      at_seams_(memory),
      broad_phase_(memory) {}

void Collider::collide(const World& world, const CollideSettings& settings, Contacts& contacts, const Surfaces* surfaces,
                       std::span<const std::int32_t> crowd_ranks) {
  const std::size_t manifolds = contacts.manifolds.size(), points = contacts.points.size();  // of the last step
  contacts.clear();
  period_ = world.period;
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
  at_seams_.clear();
  for (const IndexPair& pair : pairs)
    if (pair.second < bodies && settings.may_touch(proxies_[pair.first].id, proxies_[pair.second].id))
      collide_bodies(pair, settings, contacts);
  if (surfaces) {
    SurfaceCollider collider(world, *surfaces, settings, contacts.surface);
    for (const IndexPair& pair : pairs)
      if (pair.second >= bodies) collide_surface(pair, world, settings, *surfaces, collider);
    collider.finish();
  }
  if (!at_seams_.empty()) mend_seams(settings, surfaces, contacts);
  if (surfaces) leave_out_nodes_ahead(world, *surfaces, settings, contacts);
  leave_out_rings_in_piles(world, contacts);
  if (!settings.restitution.empty()) set_bounces(world, settings, contacts);
}

void Collider::find_pairs(const World& world, std::span<const std::int32_t> crowd_ranks) {
  const auto find = [&] {
    period_.any() ? find_periodic(broad_phase_, period_, bounds_, roles_, pairs_, filters_)
                  : broad_phase_.find(bounds_, roles_, pairs_, filters_);
  };
  if (crowd_ranks.empty()) return find();
  std::vector<Crowds::Member> members;
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    const auto slot = static_cast<std::size_t>(proxies_[i].slot);
    if (crowd_ranks[slot] >= 0)
      members.push_back({crowd_cell(world.properties[slot], world.period.wrapped(world.position[slot])), crowd_ranks[slot],
                         static_cast<std::int32_t>(i)});
  }
  const Crowds crowds(std::move(members));
  const std::vector<Bounds> bounds(bounds_.begin(), bounds_.end());
  const std::vector<Role> roles(roles_.begin(), roles_.end());
  const std::vector<Filter> filters(filters_.begin(), filters_.end());
  crowds.stand_for(bounds_, roles_, filters_);
  find();
  crowds.expand(pairs_, bounds, roles, filters, period_);
  std::copy(roles.begin(), roles.end(), roles_.begin());  // planes look at them, too
}

namespace {

// In a periodic scene takes a proxy into the cell.
void put_into_cell(Proxy& p, const Period& period) {
  if (!period.any() || p.kind == ShapeKind::plane) return;
  p.image = period.image_of(p.position);
  p.position -= period.shift(p.image);
}

// The proxy of a body as the one that it may touch sees it: its nearest image. Of a plane all images are the same.
Proxy seen_from(const Proxy& from, const Proxy& p, const Period& period) {
  Proxy seen = p;
  if (from.kind == ShapeKind::plane || p.kind == ShapeKind::plane) return seen;
  const Image image = period.nearest(from.position, p.position);
  seen.position += period.shift(image);
  for (std::size_t k = 0; k < 3; ++k) seen.image[k] -= image[k];  // from the body's own place to the one here
  return seen;
}

// Hands the manifolds of a pair to contacts, those that share a normal made one where that is asked for. b is where a sees it.
template <class Each>
void add_pair(const Proxy& a, const Proxy& b, const Period& period, const CollideSettings& settings, Contacts& contacts,
              Each&& for_each_manifold) {
  const double friction = settings.friction[a.material * settings.material_count + b.material];
  const auto add = [&](const PairManifold& found) {
    make_room(contacts.manifolds, contacts.manifolds.size() + 1);
    make_room(contacts.points, contacts.points.size() + static_cast<std::size_t>(found.count));
    Manifold& m = contacts.manifolds.emplace_back(
        Manifold{a.id, b.id, a.slot, b.slot, found.normal, friction, static_cast<std::uint32_t>(contacts.points.size()),
                 static_cast<std::uint32_t>(found.count), found.time, 0, found.is_inner_ring});
    contacts.points.insert(contacts.points.end(), found.points, found.points + found.count);
    if (!period.any()) return;
    for (std::size_t k = 0; k < 3; ++k) m.image[k] = a.image[k] - b.image[k];
    for (std::size_t p = m.first; p < contacts.points.size(); ++p) contacts.points[p].position += period.shift(a.image);
  };
  if (!settings.merge_supports || (!is_composite(a.kind) && !is_composite(b.kind))) return for_each_manifold(add);
  std::vector<PairManifold> manifolds;
  for_each_manifold([&](const PairManifold& found) { manifolds.push_back(found); });
  merge_supports(manifolds, {settings.margin, settings.step * relative_speed(a, b), settings.step * (a.spin - b.spin)});
  for (const PairManifold& m : manifolds) add(m);
}

}  // namespace

void Collider::collide_bodies(const IndexPair& pair, const CollideSettings& settings, Contacts& contacts) {
  const Proxy& a = proxies_[pair.first];
  std::optional<Proxy> image;
  if (period_.any()) image = seen_from(a, proxies_[pair.second], period_);
  const Proxy& b = image ? *image : proxies_[pair.second];
  const AtSeam start{pair, contacts.manifolds.size(), contacts.points.size()};
  bool at_seam = false;
  add_pair(a, b, period_, settings, contacts, [&](const auto& add) {
    collide_with_rings(a, b, settings, [&](const PairManifold& found) {
      at_seam = at_seam || (!found.is_inner_ring && may_be_at_seam(found, settings));
      if (!at_seam) add(found);
    });
  });
  if (!at_seam) return;
  contacts.manifolds.resize(start.manifolds), contacts.points.resize(start.points);
  at_seams_.push_back(start);
}

namespace {

// Each body's partners in pairs, ascending.
class Neighbours {
 public:
  Neighbours(const Pairs& pairs, std::size_t count) : ends_(count + 1), partners_(2 * pairs.size()) {
    for (const IndexPair& pair : pairs) ++ends_[pair.first + 1], ++ends_[pair.second + 1];
    std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
    std::vector<std::size_t> next(ends_.begin(), ends_.end() - 1);
    for (const IndexPair& pair : pairs) partners_[next[pair.first]++] = pair.second, partners_[next[pair.second]++] = pair.first;
    for (std::size_t i = 0; i < count; ++i) std::sort(at(ends_[i]), at(ends_[i + 1]));
  }

  std::span<const std::int32_t> of(std::int32_t body) const {
    const auto i = static_cast<std::size_t>(body);
    return std::span(partners_).subspan(ends_[i], ends_[i + 1] - ends_[i]);
  }

 private:
  std::vector<std::int32_t>::iterator at(std::size_t place) { return partners_.begin() + static_cast<std::ptrdiff_t>(place); }

  std::vector<std::size_t> ends_;  // after the first: the last one's of each body
  std::vector<std::int32_t> partners_;
};

}  // namespace

// Which bodies could be a pair's third is asked by bounds alone, without filters, so that all ranks on which the pair is find the
// same: a body whose swept bounds overlap both is on every rank on which one of the two is home. Of a pair with a body that is
// not dynamic there is one such rank, and what overlaps the other body is there.
void Collider::mend_seams(const CollideSettings& settings, const Surfaces* surfaces, Contacts& contacts) {
  std::vector<Bounds> bounds;
  for (const Proxy& p : proxies_) bounds.push_back(swept_bounds_of(p, settings));
  const auto count = proxies_.size();
  std::vector<Role> roles(count, Role::other);
  for (const AtSeam& s : at_seams_) roles[s.pair.first] = roles[s.pair.second] = Role::home;
  for (std::size_t i = 0; i < count; ++i)
    if (proxies_[i].kind == ShapeKind::plane || (surfaces && surfaces->is_node(proxies_[i].slot))) roles[i] = Role::absent;
  Pairs pairs;
  period_.any() ? find_periodic(broad_phase_, period_, bounds, roles, pairs) : broad_phase_.find(bounds, roles, pairs);
  const Neighbours near(pairs, count);

  Contacts mended;
  std::size_t manifolds = 0, points = 0;
  const auto take_until = [&](std::size_t last_manifold, std::size_t last_point) {
    for (; manifolds < last_manifold; ++manifolds) {
      Manifold m = contacts.manifolds[manifolds];
      m.first += static_cast<std::uint32_t>(mended.points.size() - points);
      mended.manifolds.push_back(m);
    }
    mended.points.insert(mended.points.end(), contacts.points.begin() + static_cast<std::ptrdiff_t>(points),
                         contacts.points.begin() + static_cast<std::ptrdiff_t>(last_point));
    points = last_point;
  };
  KnownContacts known(proxies_);
  std::vector<std::int32_t> both;
  std::vector<const Proxy*> thirds;
  for (const AtSeam& s : at_seams_) {
    take_until(s.manifolds, s.points);
    const Proxy& a = proxies_[s.pair.first];
    std::optional<Proxy> image;
    if (period_.any()) image = seen_from(a, proxies_[s.pair.second], period_);
    const Proxy& b = image ? *image : proxies_[s.pair.second];
    const auto of_a = near.of(s.pair.first), of_b = near.of(s.pair.second);
    both.clear();
    if (a.dynamic && b.dynamic)
      std::ranges::set_intersection(of_a, of_b, std::back_inserter(both));
    else
      both.assign((a.dynamic ? of_a : of_b).begin(), (a.dynamic ? of_a : of_b).end());
    both.insert(both.end(), planes_.begin(), planes_.end());
    if (is_composite(a.kind)) both.push_back(s.pair.first);
    if (is_composite(b.kind)) both.push_back(s.pair.second);
    std::ranges::sort(both);
    std::deque<Proxy> seen;
    thirds.clear();
    for (const std::int32_t k : both)
      thirds.push_back(period_.any() ? &seen.emplace_back(seen_from(a.dynamic ? a : b, proxies_[k], period_)) : &proxies_[k]);
    add_pair(a, b, period_, settings, mended, [&](const auto& add) {
      collide_with_rings(a, b, settings, [&](const PairManifold& found) {
        PairManifold manifold = found;
        if (!found.is_inner_ring) mend_at_seam(manifold, thirds, settings, known);
        if (manifold.count > 0) add(manifold);
      });
    });
  }
  take_until(contacts.manifolds.size(), contacts.points.size());
  contacts.manifolds = std::move(mended.manifolds), contacts.points = std::move(mended.points);
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

void Collider::collide_surface(const IndexPair& pair, const World& world, const CollideSettings& settings,
                               const Surfaces& surfaces, SurfaceCollider& collider) {
  const auto bodies = static_cast<std::int32_t>(proxies_.size());
  const auto edges = bodies + static_cast<std::int32_t>(surfaces.faces.size());
  if (pair.first >= edges) return collider.edge_edge(edges_[pair.first - edges], edges_[pair.second - edges]);
  const Proxy& body = proxies_[pair.first];
  const Slot of_face = surfaces.faces[static_cast<std::size_t>(pair.second - bodies)].nodes[0];
  if (!settings.may_touch(body.id, world.id[static_cast<std::size_t>(of_face)])) return;
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
    Proxy& p = proxies_.emplace_back(make_proxy(world, next[from]++, settings));
    put_into_cell(p, period_);
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
