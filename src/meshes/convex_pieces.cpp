#include "meshes/convex_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>

#include "meshes/sets.hpp"

namespace unibody {

namespace {

using Outline = std::vector<Vec3>;

// What of a convex polygon lies on one side of a plane across an axis.
Outline cut(const Outline& from, Eigen::Index axis, double at, double side) {
  Outline kept;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 &p = from[i], &q = from[(i + 1) % from.size()];
    const double dp = side * (p[axis] - at), dq = side * (q[axis] - at);
    if (dp <= 0) kept.push_back(p);
    if ((dp <= 0) == (dq <= 0)) continue;
    Vec3 x = p + dp / (dp - dq) * (q - p);
    x[axis] = at;
    kept.push_back(x);
  }
  return kept;
}

}  // namespace

std::vector<Hull> convex_pieces(const TriangleMesh& mesh, int cells) {
  Vec3 low = mesh.nodes[0], high = low;
  for (const Vec3& x : mesh.nodes) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double edge = (high - low).maxCoeff() / cells, thin = 0.01 * edge;
  const auto cell_of = [&](double x, Eigen::Index k) { return std::clamp(static_cast<int>((x - low[k]) / edge), 0, cells - 1); };
  std::map<std::array<int, 3>, std::vector<Vec3>> points;
  for (const auto& t : mesh.triangles) {
    const Outline whole{mesh.nodes[static_cast<std::size_t>(t[0])], mesh.nodes[static_cast<std::size_t>(t[1])],
                        mesh.nodes[static_cast<std::size_t>(t[2])]};
    const Vec3 inwards = -thin * (whole[1] - whole[0]).cross(whole[2] - whole[0]).normalized();
    const Vec3 from = whole[0].cwiseMin(whole[1]).cwiseMin(whole[2]), to = whole[0].cwiseMax(whole[1]).cwiseMax(whole[2]);
    std::array<int, 3> c{};
    for (c[0] = cell_of(from[0], 0); c[0] <= cell_of(to[0], 0); ++c[0])
      for (c[1] = cell_of(from[1], 1); c[1] <= cell_of(to[1], 1); ++c[1])
        for (c[2] = cell_of(from[2], 2); c[2] <= cell_of(to[2], 2); ++c[2]) {
          Outline part = whole;
          for (std::size_t k = 0; k < 3 && !part.empty(); ++k) {
            const auto axis = static_cast<Eigen::Index>(k);
            part = cut(cut(part, axis, low[axis] + edge * c[k], -1), axis, low[axis] + edge * (c[k] + 1), 1);
          }
          auto& list = points[c];
          for (const Vec3& x : part) list.push_back(x), list.push_back(x + inwards);
        }
  }
  std::vector<Hull> pieces;
  for (const auto& [cell, list] : points) {
    try {
      pieces.push_back(make_hull(list));
    } catch (const std::invalid_argument&) {  // a corner of a triangle in this cell: its neighbours hold the rest
    }
  }
  return pieces;
}

std::vector<Hull> convex_parts(const TriangleMesh& mesh) {
  Sets sets(mesh.nodes.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 1; k < 3; ++k) sets.join(t[0], t[k]);
  std::map<std::int32_t, std::vector<std::array<std::int32_t, 3>>> parts;  // in the order of their first nodes
  for (const auto& t : mesh.triangles) parts[sets.root(t[0])].push_back(t);
  std::vector<Hull> pieces;
  for (const auto& [root, triangles] : parts) {
    const std::string which =
        "part " + std::to_string(pieces.size()) + " of " + std::to_string(parts.size()) + " (numbered from 0)";
    std::vector<Vec3> points;
    double volume = 0;
    const Vec3& origin = mesh.nodes[static_cast<std::size_t>(root)];
    for (const auto& t : triangles) {
      for (const std::int32_t node : t) points.push_back(mesh.nodes[static_cast<std::size_t>(node)]);
      const Vec3 *a = &points.back() - 2, *b = a + 1, *c = b + 1;
      volume += (*a - origin).dot((*b - origin).cross(*c - origin)) / 6;
    }
    try {
      pieces.push_back(make_hull(points));
    } catch (const std::invalid_argument& fault) {
      throw std::invalid_argument(which + " spans no volume: " + fault.what());
    }
    if (std::abs(volume) < 0.99 * pieces.back().volume) {
      std::array<char, 96> text{};
      std::snprintf(text.data(), text.size(), " encloses %.3g of its hull's %.3g m^3", std::abs(volume), pieces.back().volume);
      throw std::invalid_argument(which + text.data());
    }
  }
  return pieces;
}

}  // namespace unibody
