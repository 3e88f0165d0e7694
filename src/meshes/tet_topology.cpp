#include "meshes/tet_topology.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"

namespace unibody {

namespace {

using Tet = std::array<std::int32_t, 4>;
using Face = std::array<std::int32_t, 3>;

constexpr double least_volume = 1e-12;  // of the longest edge cubed

// A face of a tet, by ascending nodes, so that the sides of a face stand together when sorted.
struct Side {
  Face nodes;
  std::int32_t tet, face;
  bool odd;  // the ascending nodes are clockwise from the outside of the tet
  auto operator<=>(const Side&) const = default;
};

[[noreturn]] void fail(const std::string& origin, const std::string& found, const std::string& expected) {
  throw InputError(origin + ": found " + found + ", expected " + expected);
}

template <class Number>
std::string named(const char* what, Number number) {
  return std::string(what) + " " + std::to_string(number);
}
template <class Number>
std::string pair_of(const char* what, Number a, Number b) {
  return named(what, a) + " and " + std::to_string(b);
}
std::string face_of(const Face& n) {
  return named("the face of nodes", n[0]) + ", " + std::to_string(n[1]) + named(" and", n[2]);
}

const Vec3& place(const TetMesh& mesh, std::size_t tet, std::size_t corner) {
  return mesh.nodes[static_cast<std::size_t>(mesh.tets[tet][corner])];
}

Face face_nodes(const Tet& tet, std::size_t face) {
  const auto& corners = tet_faces[face];
  return {tet[corners[0]], tet[corners[1]], tet[corners[2]]};
}

std::vector<Side> sorted_sides(const TetMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t k = 0; k < 4; ++k) {
      Face n = face_nodes(mesh.tets[t], k);
      const bool odd = (n[0] > n[1]) ^ (n[1] > n[2]) ^ (n[0] > n[2]);
      std::sort(n.begin(), n.end());
      sides.push_back({n, static_cast<std::int32_t>(t), static_cast<std::int32_t>(k), odd});
    }
  std::sort(sides.begin(), sides.end());
  return sides;
}

void check_nodes(const TetMesh& mesh, const std::string& origin) {
  const auto count = static_cast<std::int64_t>(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const std::int32_t node : mesh.tets[t])
      if (node < 0 || node >= count)
        fail(origin, named("tet", t) + named(" with node", node), "nodes in [0, " + std::to_string(count) + ")");
}

void check_repeated(const TetMesh& mesh, const std::string& origin) {
  std::vector<std::pair<Tet, std::size_t>> sorted;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Tet tet = mesh.tets[t];
    std::sort(tet.begin(), tet.end());
    const auto twice = std::adjacent_find(tet.begin(), tet.end());
    if (twice != tet.end()) fail(origin, named("tet", t) + named(" with node", *twice) + " twice", "four different nodes");
    sorted.emplace_back(tet, t);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t t = 1; t < sorted.size(); ++t)
    if (sorted[t].first == sorted[t - 1].first)
      fail(origin, pair_of("tets", sorted[t - 1].second, sorted[t].second) + " with the same nodes", "each tet once");
}

void check_shapes(const TetMesh& mesh, const std::string& origin) {
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (!mesh.nodes[n].allFinite()) fail(origin, named("node", n) + " at a place that isn't finite", "finite coordinates");
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double longest = 0;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b) longest = std::max(longest, (place(mesh, t, a) - place(mesh, t, b)).norm());
    const double relative = tet_volume(mesh, t) / (longest * longest * longest);
    if (!(relative >= least_volume))
      fail(origin, named("tet", t) + (relative <= -least_volume ? " turned inside out" : " without volume"),
           "a volume of 1e-12 of its longest edge cubed");
  }
}

}  // namespace

double tet_volume(const TetMesh& mesh, std::size_t tet) {
  const Vec3& x = place(mesh, tet, 0);
  return (place(mesh, tet, 1) - x).cross(place(mesh, tet, 2) - x).dot(place(mesh, tet, 3) - x) / 6;
}

std::int64_t orient_tets(TetMesh& mesh, const std::string& origin) {
  check_nodes(mesh, origin);
  std::int64_t turned = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    if (tet_volume(mesh, t) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]), ++turned;
  return turned;
}

void check_tets(const TetMesh& mesh, const std::string& origin) {
  check_nodes(mesh, origin);
  check_repeated(mesh, origin);
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t i = 2; i < sides.size(); ++i)
    if (sides[i].nodes == sides[i - 2].nodes)
      fail(origin,
           named("tets", sides[i - 2].tet) + ", " + pair_of("", sides[i - 1].tet, sides[i].tet).substr(1) + " at " +
               face_of(sides[i].nodes),
           "at most two tets at a face");
  check_shapes(mesh, origin);
  for (std::size_t i = 1; i < sides.size(); ++i)
    if (sides[i].nodes == sides[i - 1].nodes && sides[i].odd == sides[i - 1].odd)
      fail(origin, pair_of("tets", sides[i - 1].tet, sides[i].tet) + " on the same side of " + face_of(sides[i].nodes),
           "neighbours on opposite sides");
}

std::int64_t drop_unused_nodes(TetMesh& mesh) {
  std::vector<std::int32_t> number(mesh.nodes.size(), -1);
  for (const Tet& tet : mesh.tets)
    for (const std::int32_t node : tet) number[static_cast<std::size_t>(node)] = 0;
  std::size_t kept = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (number[n] < 0) continue;
    number[n] = static_cast<std::int32_t>(kept);
    mesh.nodes[kept++] = mesh.nodes[n];
  }
  const std::size_t dropped = mesh.nodes.size() - kept;
  mesh.nodes.resize(kept);
  for (Tet& tet : mesh.tets)
    for (std::int32_t& node : tet) node = number[static_cast<std::size_t>(node)];
  return static_cast<std::int64_t>(dropped);
}

std::vector<Face> boundary_of(const TetMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<std::pair<std::int32_t, std::int32_t>> open;  // tet and face
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool shared =
        (i > 0 && sides[i - 1].nodes == sides[i].nodes) || (i + 1 < sides.size() && sides[i + 1].nodes == sides[i].nodes);
    if (!shared) open.emplace_back(sides[i].tet, sides[i].face);
  }
  std::sort(open.begin(), open.end());
  std::vector<Face> faces;
  faces.reserve(open.size());
  for (const auto& [tet, face] : open)
    faces.push_back(face_nodes(mesh.tets[static_cast<std::size_t>(tet)], static_cast<std::size_t>(face)));
  return faces;
}

}  // namespace unibody
