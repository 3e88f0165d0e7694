#include "collide/mesh_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

struct Nearest {
  const MeshSurface::Triangle* triangle = nullptr;
  TrianglePoint at;
};

double squared_distance(const MeshSurface::Branch& branch, const Vec3& x) {
  return (x - x.cwiseMax(branch.low).cwiseMin(branch.high)).squaredNorm();
}

Nearest find_nearest(const MeshSurface& mesh, const Vec3& x, double limit) {
  Nearest nearest;
  double best = limit * limit;
  std::array<std::pair<std::size_t, double>, 64> waiting;  // one a level of the tree
  std::size_t count = 0;
  waiting[count++] = {0, squared_distance(mesh.tree[0], x)};
  while (count > 0) {
    const auto [k, bound] = waiting[--count];
    if (bound > best) continue;
    const MeshSurface::Branch& branch = mesh.tree[k];
    for (std::int32_t i = branch.first; i < branch.first + branch.count; ++i) {
      const auto& triangle = mesh.triangles[static_cast<std::size_t>(mesh.order[static_cast<std::size_t>(i)])];
      const auto node = [&](std::size_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(triangle.nodes[n])]; };
      const TrianglePoint at = closest_on_triangle(x, node(0), node(1), node(2));
      const double squared = at.distance * at.distance;
      if (squared > best || (nearest.triangle && squared == best)) continue;
      best = squared, nearest = {&triangle, at};
    }
    if (branch.count > 0) continue;
    const std::pair left{2 * k + 1, squared_distance(mesh.tree[2 * k + 1], x)},
        right{2 * k + 2, squared_distance(mesh.tree[2 * k + 2], x)};
    const bool left_first = left.second <= right.second;
    waiting[count++] = left_first ? right : left;
    waiting[count++] = left_first ? left : right;
  }
  return nearest;
}

// The mean of the two triangles at edge k; 0 on a border.
Vec3 edge_normal(const MeshSurface& mesh, const MeshSurface::Triangle& t, std::size_t k) {
  if (t.across[k] < 0) return Vec3::Zero();
  const auto node = [&](std::int32_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n)]; };
  const Vec3 &from = node(t.nodes[k]), &to = node(t.nodes[(k + 1) % 3]);
  return (t.normal + (from - to).cross(node(t.across[k]) - to).normalized()).normalized();
}

Vec3 normal_at(const MeshSurface& mesh, const Nearest& nearest) {
  const MeshSurface::Triangle& t = *nearest.triangle;
  switch (nearest.at.feature()) {
    case 1:
    case 2:
    case 4:
      return mesh.node_normals[static_cast<std::size_t>(t.nodes[nearest.at.feature() / 2])];
    case 3:
      return edge_normal(mesh, t, 0);
    case 6:
      return edge_normal(mesh, t, 1);
    case 5:
      return edge_normal(mesh, t, 2);
    default:
      return t.normal;
  }
}

TrianglePoint closest(const MeshSurface& mesh, std::int32_t t, const Vec3& x) {
  const auto& n = mesh.triangles[static_cast<std::size_t>(t)].nodes;
  const auto node = [&](std::size_t k) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n[k])]; };
  return closest_on_triangle(x, node(0), node(1), node(2));
}

// Of a point whose nearest point is on an edge that several triangles share: whether two others, which are joined there, lie
// between this triangle and the point, by their angles about the edge.
bool is_hidden(const MeshSurface& mesh, std::int32_t triangle, const TrianglePoint& nearest, const Vec3& x) {
  const auto node = [&](std::int32_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n)]; };
  const auto& nodes = mesh.triangles[static_cast<std::size_t>(triangle)].nodes;
  auto b = std::lower_bound(mesh.branchings.begin(), mesh.branchings.end(), triangle,
                            [](const MeshSurface::Branching& branching, std::int32_t t) { return branching.triangle < t; });
  for (; b != mesh.branchings.end() && b->triangle == triangle; ++b) {
    const auto k = static_cast<std::size_t>(b->place);
    if (nearest.weights[static_cast<Eigen::Index>((k + 2) % 3)] > 0) continue;
    const Vec3 &from = node(nodes[k]), along = (node(nodes[(k + 1) % 3]) - from).normalized();
    const Vec3 own = node(nodes[(k + 2) % 3]) - from, first = (own - along * along.dot(own)).normalized();
    const auto angle = [&](const Vec3& place) {
      const double a = std::atan2((place - from).dot(along.cross(first)), (place - from).dot(first));
      return a < 0 ? a + 2 * M_PI : a;
    };
    const auto [low, high] = std::minmax({angle(node(b->across[0])), angle(node(b->across[1]))});
    const double of_point = angle(x);
    if (low < of_point && of_point < high) return true;
  }
  return false;
}

// On which side of the patches a point is. Of triangles that share the nearest point the one tells it that faces it the most.
class PatchSides {
 public:
  void add(const MeshSurface::Triangle& t, const TrianglePoint& nearest, const Vec3& x) {
    const double height = t.normal.dot(x - nearest.point);
    const auto same = [&](const Side& s) { return s.patch == t.patch; };
    const auto found = std::find_if(sides_.begin(), sides_.end(), same);
    if (found == sides_.end()) {
      sides_.push_back({t.patch, nearest.distance, height});
      return;
    }
    const bool tied = std::abs(nearest.distance - found->distance) <= 1e-9 * found->distance;
    if (tied ? std::abs(height) > std::abs(found->height) : nearest.distance < found->distance)
      found->distance = nearest.distance, found->height = height;
  }
  bool is_behind(std::int32_t patch) const {
    return std::find_if(sides_.begin(), sides_.end(), [&](const Side& s) { return s.patch == patch; })->height < 0;
  }

 private:
  struct Side {
    std::int32_t patch;
    double distance, height;  // m, of the nearest point, and over its triangle
  };
  std::vector<Side> sides_;
};

constexpr int cells_along = 64;  // the surface's longest side
constexpr double cells_around = 2;

MeshSurface::FrontCells make_front_cells(const MeshSurface& mesh) {
  MeshSurface::FrontCells grid;
  grid.is_made = true;
  const auto has_border = [](const MeshSurface::Triangle& t) { return std::ranges::min(t.across) < 0; };
  if (!mesh.is_solid || std::ranges::any_of(mesh.triangles, has_border)) return grid;
  const Vec3 extent = mesh.tree[0].high - mesh.tree[0].low;
  grid.size = extent.maxCoeff() / cells_along;
  grid.low = mesh.tree[0].low.array() - cells_around * grid.size;
  grid.counts = (extent.array() / grid.size + 2 * cells_around).ceil().cast<int>();
  grid.cells.assign(static_cast<std::size_t>(grid.counts.prod()), MeshSurface::FrontCells::Cell::unknown);
  return grid;
}

// Whether the cell around a place lies all in front of the surface, since its middle does, further away than the cell reaches.
bool is_among_front_cells(const MeshSurface& mesh, const Vec3& x) {
  using Cell = MeshSurface::FrontCells::Cell;
  MeshSurface::FrontCells& grid = mesh.front_cells;
  if (!grid.is_made) grid = make_front_cells(mesh);
  if (grid.cells.empty()) return false;
  const Eigen::Array3d at = ((x - grid.low) / grid.size).array();
  if (!((at >= 0).all() && (at < grid.counts.cast<double>()).all())) return false;
  const Eigen::Array3i k = at.cast<int>();
  Cell& cell = grid.cells[static_cast<std::size_t>((k.z() * grid.counts.y() + k.y()) * grid.counts.x() + k.x())];
  if (cell == Cell::unknown) {
    const Vec3 middle = grid.low + grid.size * (k.cast<double>() + 0.5).matrix();
    const double reach = 1.001 * std::sqrt(0.75) * grid.size;
    MeshPlace place;
    cell = find_place(mesh, middle, HUGE_VAL, place) && place.depth < -reach ? Cell::in_front : Cell::other;
  }
  return cell == Cell::in_front;
}

}  // namespace

std::vector<MeshSurface::Triangle> facing(const MeshSurface& mesh, const std::vector<std::int32_t>& near, const Vec3& x) {
  std::vector<MeshSurface::Triangle> result;
  PatchSides sides;
  for (const std::int32_t t : near) {
    const TrianglePoint nearest = closest(mesh, t, x);
    const MeshSurface::Triangle& triangle = mesh.triangles[static_cast<std::size_t>(t)];
    sides.add(triangle, nearest, x);
    if (!is_hidden(mesh, t, nearest, x)) result.push_back(triangle);
  }
  if (!mesh.two_sided) return result;
  for (MeshSurface::Triangle& t : result)
    if (sides.is_behind(t.patch)) t.turn_over();
  return result;
}

bool find_place(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place) {
  if (mesh.two_sided) return false;
  const Nearest nearest = find_nearest(mesh, x, limit);
  if (!nearest.triangle) return false;
  place.point = nearest.at.point, place.normal = normal_at(mesh, nearest);
  place.depth = place.normal.dot(x - place.point) > 0 ? -nearest.at.distance : nearest.at.distance;
  return place.normal != Vec3::Zero();
}

bool is_behind(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place) {
  if (is_among_front_cells(mesh, x)) return false;
  return find_place(mesh, x, limit, place) && place.depth > 0;
}

}  // namespace unibody
