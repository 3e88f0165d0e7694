#include "world/mesh_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "world/mesh_neighbours.hpp"
#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr std::int32_t leaf = 4;  // triangles

class TreeBuilder {
 public:
  explicit TreeBuilder(MeshSurface& mesh) : mesh_(mesh) {
    const auto n = static_cast<std::int32_t>(mesh.triangles.size());
    for (std::int32_t t = 0; t < n; ++t) mesh.order.push_back(t);
    build(0, 0, n);
  }

 private:
  const Vec3& corner(std::int32_t t, std::size_t k) const {
    return mesh_.nodes[static_cast<std::size_t>(mesh_.triangles[static_cast<std::size_t>(t)].nodes[k])];
  }

  // Halves along the longest side, by the triangles' middles.
  void build(std::size_t branch, std::int32_t first, std::int32_t count) {
    if (mesh_.tree.size() <= branch) mesh_.tree.resize(branch + 1);
    Vec3 low = corner(mesh_.order[static_cast<std::size_t>(first)], 0), high = low;
    for (std::int32_t i = first; i < first + count; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& x = corner(mesh_.order[static_cast<std::size_t>(i)], k);
        low = low.cwiseMin(x), high = high.cwiseMax(x);
      }
    mesh_.tree[branch] = {low, high, first, count <= leaf ? count : 0};
    if (count <= leaf) return;
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const auto key = [&](std::int32_t t) { return std::pair(corner(t, 0)[axis] + corner(t, 1)[axis] + corner(t, 2)[axis], t); };
    const auto begin = mesh_.order.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](std::int32_t s, std::int32_t t) { return key(s) < key(t); });
    build(2 * branch + 1, first, count / 2);
    build(2 * branch + 2, first + count / 2, count - count / 2);
  }

  MeshSurface& mesh_;
};

// Returns whether there is no border.
bool add_node_normals(MeshSurface& mesh) {
  mesh.node_normals.assign(mesh.nodes.size(), Vec3::Zero());
  std::vector<bool> on_border(mesh.nodes.size(), false);
  bool closed = true;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t i) { return static_cast<std::size_t>(t.nodes[i % 3]); };
      const Vec3 &x = mesh.nodes[at(k)], a = mesh.nodes[at(k + 1)] - x, b = mesh.nodes[at(k + 2)] - x;
      mesh.node_normals[at(k)] += std::atan2(a.cross(b).norm(), a.dot(b)) * t.normal;
      if (t.across[k] < 0) closed = false, on_border[at(k)] = on_border[at(k + 1)] = true;
    }
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    mesh.node_normals[i] = on_border[i] ? Vec3(Vec3::Zero()) : mesh.node_normals[i].normalized();
  return closed;
}

}  // namespace

MeshSurface make_mesh_shape(std::span<const Vec3> nodes, std::span<const std::array<std::int32_t, 3>> triangles, double below,
                            bool two_sided) {
  MeshSurface mesh;
  mesh.two_sided = two_sided;
  mesh.nodes.assign(nodes.begin(), nodes.end());
  for (const auto& t : triangles) {
    const Vec3 &a = nodes[static_cast<std::size_t>(t[0])], &b = nodes[static_cast<std::size_t>(t[1])],
               &c = nodes[static_cast<std::size_t>(t[2])];
    mesh.triangles.push_back({t, {-1, -1, -1}, {}, {}, (b - a).cross(c - a).normalized()});
  }
  for (const Vec3& x : nodes) mesh.size = mesh.size.cwiseMax(x.cwiseAbs()), mesh.radius = std::max(mesh.radius, x.norm());
  if (below > 0) mesh.size.z() += below, mesh.radius = mesh.size.norm();
  join_neighbours(mesh);
  mesh.is_solid = (add_node_normals(mesh) || below > 0) && !mesh.two_sided;
  TreeBuilder{mesh};
  return mesh;
}

namespace {

std::vector<std::array<std::int32_t, 3>> triangles_of(const MeshSurface& mesh) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const MeshSurface::Triangle& t : mesh.triangles) triangles.push_back(t.nodes);
  return triangles;
}

void make_again(MeshSurface& mesh, const std::vector<std::array<std::int32_t, 3>>& triangles, bool two_sided) {
  std::string note = std::move(mesh.note), name = std::move(mesh.name);
  const std::vector<Vec3> nodes = std::move(mesh.nodes);
  mesh = make_mesh_shape(nodes, triangles, 0, two_sided);
  mesh.note = std::move(note), mesh.name = std::move(name);
}

}  // namespace

void turn_over(MeshSurface& mesh) {
  std::vector<std::array<std::int32_t, 3>> triangles = triangles_of(mesh);
  for (auto& t : triangles) std::swap(t[1], t[2]);
  make_again(mesh, triangles, false);
}

void touch_from_both(MeshSurface& mesh) { make_again(mesh, triangles_of(mesh), true); }

void MeshSurface::find(const Vec3& low, const Vec3& high, std::vector<std::int32_t>& found) const {
  const std::size_t before = found.size();
  std::vector<std::size_t> waiting{0};
  const auto apart = [&](const Vec3& l, const Vec3& h) {
    return (l.array() > high.array()).any() || (h.array() < low.array()).any();
  };
  while (!waiting.empty()) {
    const std::size_t k = waiting.back();
    waiting.pop_back();
    const Branch& branch = tree[k];
    if (apart(branch.low, branch.high)) continue;
    if (branch.count == 0) waiting.push_back(2 * k + 1), waiting.push_back(2 * k + 2);
    for (std::int32_t i = branch.first; i < branch.first + branch.count; ++i) {
      const auto& n = triangles[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])].nodes;
      const Vec3 &a = nodes[static_cast<std::size_t>(n[0])], &b = nodes[static_cast<std::size_t>(n[1])],
                 &c = nodes[static_cast<std::size_t>(n[2])];
      if (!apart(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c))) found.push_back(order[static_cast<std::size_t>(i)]);
    }
  }
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end());
}

namespace {

const MeshSurface& mesh_of(const Shape& s) { return shape_library().meshes[s.data]; }
double bounding(const Shape& s) { return mesh_of(s).radius; }
Vec3 extents(const Shape& s, const Mat3& rotation) {
  return (rotation.cwiseAbs() * s.size).cwiseMin(Vec3::Constant(bounding(s)));
}
double none(const Shape&) { return 0; }
Vec3 unit_inertia(const Shape&, double) { return Vec3::Ones(); }
double infinite(const Shape&) { return std::numeric_limits<double>::infinity(); }

}  // namespace

const ShapeType mesh_type{ShapeKind::mesh, {}, nullptr, bounding, extents, none, unit_inertia, infinite, nullptr};

}  // namespace unibody
