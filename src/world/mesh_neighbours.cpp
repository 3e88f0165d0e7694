#include "world/mesh_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_set>

namespace unibody {

namespace {

// One of the triangles at an edge.
struct Side {
  std::int32_t low, high, triangle, place;  // the edge's nodes, ascending; from node `place` of the triangle to the next
  bool goes_up;                             // from low to high
};

// Two triangles that go on into each other over an edge; the first has the smaller number.
struct Pair {
  Side first, second;
  bool agrees() const { return first.goes_up != second.goes_up; }
};

std::vector<Side> sorted_sides(const MeshSurface& mesh) {
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t p = mesh.triangles[t].nodes[k], q = mesh.triangles[t].nodes[(k + 1) % 3];
      sides.push_back({std::min(p, q), std::max(p, q), static_cast<std::int32_t>(t), static_cast<std::int32_t>(k), p < q});
    }
  const auto key = [](const Side& s) { return std::tuple(s.low, s.high, s.triangle); };
  std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) { return key(a) < key(b); });
  return sides;
}

MeshSurface::Triangle& triangle_of(MeshSurface& mesh, const Side& s) {
  return mesh.triangles[static_cast<std::size_t>(s.triangle)];
}
std::int32_t opposite(const MeshSurface& mesh, const Side& s) {
  return mesh.triangles[static_cast<std::size_t>(s.triangle)].nodes[static_cast<std::size_t>(s.place + 2) % 3];
}

// The direction from the edge into the triangle, square to the edge.
Vec3 inwards(const MeshSurface& mesh, const Side& s) {
  const auto node = [&](std::int32_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n)]; };
  const Vec3 along = (node(s.high) - node(s.low)).normalized(), in = node(opposite(mesh, s)) - node(s.low);
  return (in - along * along.dot(in)).normalized();
}

// Of all triangles at an edge, selects the two that go on into each other the most evenly: wherever the edge stands out towards
// a body it is between these two.
Pair flattest(const MeshSurface& mesh, std::span<const Side> sides) {
  Pair best{sides[0], sides[1]};
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < sides.size() && sides.size() > 2; ++i)
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      const double bend = inwards(mesh, sides[i]).dot(inwards(mesh, sides[j]));
      if (bend < least) least = bend, best = {sides[i], sides[j]};
    }
  return best;
}

// Throughout the mesh; sets speaks_for_edge and branchings.
std::vector<Pair> find_pairs(MeshSurface& mesh, const std::vector<Side>& sides) {
  std::vector<Pair> pairs;
  for (std::size_t from = 0, to; from < sides.size(); from = to) {
    for (to = from; to < sides.size() && sides[to].low == sides[from].low && sides[to].high == sides[from].high;) ++to;
    const std::span<const Side> at(sides.data() + from, to - from);
    const auto speaks = [&](const Side& s) -> bool& {
      return triangle_of(mesh, s).speaks_for_edge[static_cast<std::size_t>(s.place)];
    };
    for (const Side& s : at) speaks(s) = at.size() == 1;
    if (at.size() == 1) continue;
    const Pair& pair = pairs.emplace_back(flattest(mesh, at));
    speaks(pair.first) = true;
    for (const Side& s : at)
      if (s.triangle != pair.first.triangle && s.triangle != pair.second.triangle)
        mesh.branchings.push_back({s.triangle, s.place, {opposite(mesh, pair.first), opposite(mesh, pair.second)}});
  }
  return pairs;
}

// Numbers the patches and turns over those of a patch that do not agree with its first. The places of pairs and branchings are
// those of the triangles as they were, and follow.
void find_patches(MeshSurface& mesh, std::vector<Pair>& pairs) {
  const std::size_t count = mesh.triangles.size();
  std::vector<std::vector<const Pair*>> at(count);
  for (const Pair& p : pairs)
    for (const Side& s : {p.first, p.second}) at[static_cast<std::size_t>(s.triangle)].push_back(&p);
  std::vector<std::uint8_t> turned(count, 0);
  std::int32_t patches = 0;
  std::vector<std::size_t> front;
  for (MeshSurface::Triangle& t : mesh.triangles) t.patch = -1;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (mesh.triangles[seed].patch >= 0) continue;
    mesh.triangles[seed].patch = patches++, front = {seed};
    while (!front.empty()) {
      const std::size_t t = front.back();
      front.pop_back();
      for (const Pair* p : at[t]) {
        const auto other = static_cast<std::size_t>(p->first.triangle) == t ? static_cast<std::size_t>(p->second.triangle)
                                                                            : static_cast<std::size_t>(p->first.triangle);
        if (mesh.triangles[other].patch >= 0) continue;
        mesh.triangles[other].patch = mesh.triangles[t].patch;
        turned[other] = p->agrees() ? turned[t] : !turned[t];
        front.push_back(other);
      }
    }
  }
  const auto is_turned = [&](std::int32_t t) { return turned[static_cast<std::size_t>(t)] != 0; };
  for (Pair& p : pairs)
    for (Side* s : {&p.first, &p.second})
      if (is_turned(s->triangle)) s->place = 2 - s->place, s->goes_up = !s->goes_up;
  for (MeshSurface::Branching& b : mesh.branchings)
    if (is_turned(b.triangle)) b.place = 2 - b.place;
  for (std::size_t t = 0; t < count; ++t)
    if (turned[t]) mesh.triangles[t].turn_over();
}

void find_rings(MeshSurface& mesh) {
  std::vector<std::vector<MeshSurface::RingNode>> rings(mesh.nodes.size());
  for (const MeshSurface::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3})
        rings[static_cast<std::size_t>(t.nodes[k])].push_back({t.patch, t.nodes[other]});
  mesh.ring.clear(), mesh.ring_begin.assign(1, 0);
  for (auto& ring : rings) {
    std::ranges::sort(ring);
    mesh.ring.insert(mesh.ring.end(), ring.begin(), std::unique(ring.begin(), ring.end()));
    mesh.ring_begin.push_back(mesh.ring.size());
  }
}

}  // namespace

void MeshSurface::Triangle::turn_over() {
  std::swap(nodes[1], nodes[2]);
  std::swap(across[0], across[2]);
  std::swap(speaks_for_edge[0], speaks_for_edge[2]);
  std::swap(speaks_for_node[1], speaks_for_node[2]);
  normal = -normal;
}

void join_neighbours(MeshSurface& mesh) {
  std::vector<Pair> pairs = find_pairs(mesh, sorted_sides(mesh));
  mesh.two_sided |= std::any_of(pairs.begin(), pairs.end(), [](const Pair& p) { return !p.agrees(); });
  if (mesh.two_sided) find_patches(mesh, pairs);
  for (const Pair& p : pairs) {
    const auto own = static_cast<std::size_t>(p.first.place), others = static_cast<std::size_t>(p.second.place);
    if (!p.agrees()) {  // cut
      triangle_of(mesh, p.second).speaks_for_edge[others] = true;
      continue;
    }
    triangle_of(mesh, p.first).across[own] = opposite(mesh, p.second);
    triangle_of(mesh, p.second).across[others] = opposite(mesh, p.first);
  }
  std::sort(mesh.branchings.begin(), mesh.branchings.end(),
            [](const auto& a, const auto& b) { return std::pair(a.triangle, a.place) < std::pair(b.triangle, b.place); });
  std::unordered_set<std::size_t> taken;  // nodes of patches
  for (MeshSurface::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      t.speaks_for_node[k] =
          taken.insert(static_cast<std::size_t>(t.patch) * mesh.nodes.size() + static_cast<std::size_t>(t.nodes[k])).second;
  find_rings(mesh);
}

}  // namespace unibody
