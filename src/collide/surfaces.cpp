#include "collide/surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/capacity.hpp"

namespace unibody {

namespace {

// What a node can travel or reach in a step beyond its radius (m): its side of the margin rule.
double reach_of(const World& world, Slot s, const CollideSettings& settings) {
  const auto i = static_cast<std::size_t>(s);
  const double fall = settings.gravity.norm() * settings.step * settings.step;  // of pinned nodes too: as swept_bounds()
  return settings.margin / 2 + settings.step * world.velocity[i].norm() + fall;
}

Bounds bounds_of(const World& world, std::span<const Slot> nodes, double reach) {
  Bounds b{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
  double radius = 0;
  for (const Slot s : nodes) {
    const Vec3& x = world.position[static_cast<std::size_t>(s)];
    b.lower = b.lower.cwiseMin(x), b.upper = b.upper.cwiseMax(x);
    radius = std::max(radius, world.properties[static_cast<std::size_t>(s)].shape.size.x());
  }
  b.lower.array() -= radius + reach, b.upper.array() += radius + reach;
  return b;
}

// A surface's edge as one of its faces has it.
struct HalfEdge {
  Id low, high;  // ids of its nodes
  std::int32_t face, place;
};

}  // namespace

Bounds swept_bounds(const World& world, std::span<const Slot> nodes, const CollideSettings& settings) {
  const double still = settings.margin / 2 + settings.gravity.norm() * settings.step * settings.step;
  Bounds b{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
  double radius = 0;
  for (const Slot s : nodes) {
    const auto i = static_cast<std::size_t>(s);
    const Vec3 way = settings.step * world.velocity[i];
    const Vec3 from = settings.has_past ? Vec3(world.position[i] - way) : world.position[i], to = world.position[i] + way;
    b.lower = b.lower.cwiseMin(from).cwiseMin(to), b.upper = b.upper.cwiseMax(from).cwiseMax(to);
    radius = std::max(radius, world.properties[i].shape.size.x());
  }
  b.lower.array() -= radius + still, b.upper.array() += radius + still;
  return b;
}

double surface_slack(const World& world, std::span<const Slot> nodes) {
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  for (const Slot s : nodes) {
    const Vec3& x = world.position[static_cast<std::size_t>(s)];
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  return (high - low).maxCoeff() / 2;
}

// Its height over the line between its wings, against the radius of what it touches with.
bool is_sharp(const World& world, const SurfaceEdge& edge) {
  const auto place = [&](Slot s) -> const Vec3& { return world.position[static_cast<std::size_t>(s)]; };
  if (edge.wings[0] < 0 || edge.wings[1] < 0) return true;
  const Vec3& from = place(edge.nodes[0]);
  const Vec3 along = (place(edge.nodes[1]) - from).normalized();
  Vec3 a = place(edge.wings[0]) - from, b = place(edge.wings[1]) - from;
  a -= along * along.dot(a), b -= along * along.dot(b);
  const double radius = world.properties[static_cast<std::size_t>(edge.nodes[0])].shape.size.x();
  return !(a.cross(b).norm() <= 0.1 * radius * (a - b).norm()) || a.dot(b) > 0;
}

void Surfaces::clear() {
  faces.clear(), edges.clear(), surface_of_.clear(), interior_.clear();
  rings_ = {};
}

void Surfaces::build(const World& world) {
  clear();
  find_faces(world);
  find_edges(world);
}

// Each face once: with its node of lowest id.
void Surfaces::find_faces(const World& world) {
  surface_of_.assign(world.size(), -1), interior_.assign(world.size(), 0);
  std::vector<std::array<Id, 3>> cells;
  for (std::size_t k = 0; k < surfaces_.size(); ++k) {
    const Surface& surface = surfaces_[k];
    for (const std::size_t begin : {std::size_t{0}, world.homes}) {  // guests after homes; nodes are never static
      const auto end = world.id.begin() + static_cast<std::ptrdiff_t>(begin == 0 ? world.homes : world.first_static());
      auto node = std::lower_bound(world.id.begin() + static_cast<std::ptrdiff_t>(begin), end, surface.first_node);
      for (; node != end && *node < surface.first_node + surface.node_count; ++node) {
        const auto slot = static_cast<std::size_t>(node - world.id.begin());
        surface_of_[slot] = static_cast<std::int32_t>(k);
        cells.clear();
        surface.cells_of(*node, cells);
        interior_[slot] = cells.empty();
        for (const auto& ids : cells) {
          if (*node != std::min({ids[0], ids[1], ids[2]})) continue;
          const SurfaceFace face{
              {world.find(ids[0]), world.find(ids[1]), world.find(ids[2])}, {-1, -1, -1}, static_cast<std::int32_t>(k), false};
          if (std::any_of(face.nodes.begin(), face.nodes.end(), [](Slot s) { return s < 0; })) continue;
          faces.push_back(face);
          for (const Slot s : face.nodes) faces.back().home |= world.is_home(s);
        }
      }
    }
  }
}

void Surfaces::find_edges(const World& world) {
  std::vector<HalfEdge> halves;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < (faces[f].is_segment() ? 1 : 3); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Id a = world.id[static_cast<std::size_t>(faces[f].nodes[k])];
      const Id b = world.id[static_cast<std::size_t>(faces[f].nodes[(k + 1) % 3])];
      halves.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(f), i});
    }
  std::sort(halves.begin(), halves.end(),
            [](const HalfEdge& a, const HalfEdge& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  const auto third = [&](const HalfEdge& h) {
    const SurfaceFace& face = faces[static_cast<std::size_t>(h.face)];
    return face.is_segment() ? -1 : face.nodes[static_cast<std::size_t>(h.place + 2) % 3];
  };
  for (std::size_t i = 0; i < halves.size();) {
    const HalfEdge &h = halves[i], *other = i + 1 < halves.size() ? &halves[i + 1] : nullptr;
    const bool pair = other && other->low == h.low && other->high == h.high;
    SurfaceEdge edge{{world.find(h.low), world.find(h.high)}, {third(h), pair ? third(*other) : -1}, 0, false};
    edge.surface = faces[static_cast<std::size_t>(h.face)].surface;
    edge.home = world.is_home(edge.nodes[0]) || world.is_home(edge.nodes[1]);
    faces[static_cast<std::size_t>(h.face)].across[static_cast<std::size_t>(h.place)] = edge.wings[1];
    if (pair) faces[static_cast<std::size_t>(other->face)].across[static_cast<std::size_t>(other->place)] = edge.wings[0];
    edges.push_back(edge);
    i += pair ? 2 : 1;
  }

  auto& start = rings_.start;
  start.assign(world.size() + 1, 0);
  for (const SurfaceEdge& e : edges)
    for (const Slot s : e.nodes) ++start[static_cast<std::size_t>(s) + 1];
  for (std::size_t s = 0; s < world.size(); ++s) start[s + 1] += start[s];
  rings_.entries.resize(start.back());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for (const SurfaceEdge& e : edges)
    for (std::size_t k = 0; k < 2; ++k) rings_.entries[next[static_cast<std::size_t>(e.nodes[k])]++] = e.nodes[1 - k];
}

std::vector<Id> Surfaces::partners(const World& world) const {
  std::vector<Id> found;
  const auto end = world.id.begin() + static_cast<std::ptrdiff_t>(world.homes);
  const auto tidy = [](std::vector<Id>& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  };
  std::vector<std::array<Id, 3>> cells;
  for (const Surface& surface : surfaces_) {
    std::vector<Id> near;
    const auto add_ring = [&](Id node, std::vector<Id>& out) {
      cells.clear();
      surface.cells_of(node, cells);
      for (const auto& ids : cells)
        for (const Id id : ids)
          if (!std::binary_search(world.id.begin(), end, id)) out.push_back(id);
    };
    auto node = std::lower_bound(world.id.begin(), end, surface.first_node);
    for (; node != end && *node < surface.first_node + surface.node_count; ++node) add_ring(*node, near);
    tidy(near);
    found.insert(found.end(), near.begin(), near.end());
    for (const Id id : near) add_ring(id, found);
  }
  tidy(found);
  return found;
}

void Surfaces::widen(const World& world, const CollideSettings& settings, std::span<Bounds> bounds) const {
  if (faces.empty()) return;
  std::vector<double> of_face(faces.size()), of_node(world.size(), 0);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (const Slot s : faces[f].nodes) of_face[f] = std::max(of_face[f], reach_of(world, s, settings));
    for (const Slot s : faces[f].nodes)
      of_node[static_cast<std::size_t>(s)] = std::max(of_node[static_cast<std::size_t>(s)], of_face[f]);
  }
  for (const SurfaceFace& face : faces) {
    if (!face.home) continue;
    double reach = 0;  // the greatest of the face and of those around it
    for (const Slot s : face.nodes) reach = std::max(reach, of_node[static_cast<std::size_t>(s)]);
    const Bounds b = bounds_of(world, face.nodes, reach + surface_slack(world, face.nodes));
    for (const Slot s : face.nodes) {
      if (!world.is_home(s)) continue;
      Bounds& wide = bounds[static_cast<std::size_t>(s)];
      wide.lower = wide.lower.cwiseMin(b.lower), wide.upper = wide.upper.cwiseMax(b.upper);
    }
  }
}

bool Surfaces::edges_may_meet() const {
  return surfaces_.size() > 1 ||
         std::any_of(surfaces_.begin(), surfaces_.end(), [](const Surface& s) { return s.self_collision; });
}

bool Surfaces::all_closed() const {
  return std::all_of(surfaces_.begin(), surfaces_.end(), [](const Surface& s) { return s.closed; });
}

std::size_t Surfaces::bytes() const {
  return bytes_of(faces) + bytes_of(edges) + bytes_of(surface_of_) + bytes_of(interior_) + bytes_of(rings_.start) +
         bytes_of(rings_.entries);
}

}  // namespace unibody
