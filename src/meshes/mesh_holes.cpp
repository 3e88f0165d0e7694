#include "meshes/mesh_holes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace unibody {

namespace {

constexpr double hole_share = 0.25;  // of the extent of its part, below which a border is a hole

// Nodes that hang together.
class Groups {
 public:
  explicit Groups(std::size_t nodes) : parent_(nodes) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t of(std::int32_t node) {
    while (at(node) != node) node = at(node) = at(at(node));
    return node;
  }
  void join(std::int32_t a, std::int32_t b) { at(of(a)) = of(b); }

 private:
  std::int32_t& at(std::int32_t node) { return parent_[static_cast<std::size_t>(node)]; }
  std::vector<std::int32_t> parent_;
};

struct Box {
  Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
  void add(const Vec3& x) { low = low.cwiseMin(x), high = high.cwiseMax(x); }
  double width() const { return (high - low).maxCoeff(); }
};

using Edge = std::array<std::int32_t, 2>;

std::vector<Edge> border_of(const TriangleMesh& mesh) {
  std::map<Edge, int> triangles;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++triangles[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  std::vector<Edge> border;
  for (const auto& [edge, count] : triangles)
    if (count == 1) border.push_back(edge);
  return border;
}

}  // namespace

std::vector<Hole> holes_of(const TriangleMesh& mesh) {
  const std::vector<Edge> border = border_of(mesh);
  if (border.empty()) return {};
  const auto place = [&](std::int32_t node) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(node)]; };
  Groups parts(mesh.nodes.size()), loops(mesh.nodes.size());
  for (const auto& t : mesh.triangles) parts.join(t[0], t[1]), parts.join(t[1], t[2]);
  for (const Edge& e : border) loops.join(e[0], e[1]);

  std::map<std::int32_t, Box> of_part, of_loop;
  std::map<std::int32_t, std::int64_t> edges;
  for (const auto& t : mesh.triangles)
    for (const std::int32_t node : t) of_part[parts.of(node)].add(place(node));
  for (const Edge& e : border) {
    Box& box = of_loop[loops.of(e[0])];
    box.add(place(e[0])), box.add(place(e[1])), ++edges[loops.of(e[0])];
  }
  std::vector<Hole> holes;
  for (const auto& [loop, box] : of_loop)
    if (box.width() < hole_share * of_part[parts.of(loop)].width())
      holes.push_back({edges[loop], box.width(), (box.low + box.high) / 2});
  std::ranges::stable_sort(holes, [](const Hole& a, const Hole& b) { return a.width > b.width; });
  return holes;
}

}  // namespace unibody
