#include "meshes/triangle_soup.hpp"

#include <algorithm>
#include <map>

#include "core/errors.hpp"
#include "meshes/weld.hpp"

namespace unibody {

namespace {

using Triangle = std::array<std::int32_t, 3>;

// Each node's first that is at the same place.
std::vector<std::int32_t> first_at_place(const std::vector<Vec3>& nodes) {
  std::map<std::array<double, 3>, std::int32_t> numbers;
  std::vector<std::int32_t> first;
  for (const Vec3& x : nodes)
    first.push_back(numbers.try_emplace({x.x(), x.y(), x.z()}, static_cast<std::int32_t>(first.size())).first->second);
  return first;
}

// Each node's first that is within the distance (m), or else at the same place. welded: how many of those within the distance are
// not at the same place.
std::vector<std::int32_t> first_near(const std::vector<Vec3>& nodes, double distance, std::int64_t& welded) {
  std::vector<std::int32_t> first = first_at_place(nodes), kept;
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (first[i] == static_cast<std::int32_t>(i)) kept.push_back(first[i]), places.push_back(nodes[i]);
  const std::vector<std::int32_t> number = weld(places, distance);
  std::vector<std::int32_t> to(nodes.size(), -1), of_place;  // of each node that is the first at its place; of each that stays
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto place = static_cast<std::size_t>(number[k]);
    if (place == of_place.size()) of_place.push_back(kept[k]);
    to[static_cast<std::size_t>(kept[k])] = of_place[place];
  }
  welded = static_cast<std::int64_t>(kept.size() - of_place.size());
  for (std::int32_t& i : first) i = to[static_cast<std::size_t>(i)];
  return first;
}

bool has_area(const TriangleMesh& mesh, const Triangle& t) {
  const auto node = [&](std::size_t k) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(t[k])]; };
  const Vec3 a = node(1) - node(0), b = node(2) - node(1), c = node(0) - node(2);
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
  return longest > 0 && a.cross(c).norm() >= 1e-8 * longest;
}

// Whether a triangle turns through its nodes in the order of their numbers.
bool goes_up(const Triangle& t) {
  const auto least = static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
  return t[(least + 1) % 3] < t[(least + 2) % 3];
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

// Each edge is passed once up and once down, and every triangle has an area.
bool is_closed_and_sound(const TriangleMesh& mesh) {
  std::map<std::array<std::int32_t, 2>, std::array<int, 2>> passed;
  for (const Triangle& t : mesh.triangles) {
    if (!has_area(mesh, t)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t p = t[k], q = t[(k + 1) % 3];
      ++passed[{std::min(p, q), std::max(p, q)}][p < q];
    }
  }
  return std::all_of(passed.begin(), passed.end(), [](const auto& edge) { return edge.second == std::array{1, 1}; });
}

void drop_unused_nodes(TriangleMesh& mesh) {
  std::vector<std::int32_t> number(mesh.nodes.size(), -1);
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t n : t) number[static_cast<std::size_t>(n)] = 0;
  std::int32_t kept = 0;
  for (std::size_t i = 0; i < number.size(); ++i)
    if (number[i] == 0) mesh.nodes[static_cast<std::size_t>(kept)] = mesh.nodes[i], number[i] = kept++;
  mesh.nodes.resize(static_cast<std::size_t>(kept));
  for (Triangle& t : mesh.triangles)
    for (std::int32_t& n : t) n = number[static_cast<std::size_t>(n)];
}

}  // namespace

SoupFaults mend_soup(TriangleMesh& mesh, const std::string& origin, double weld_share) {
  const auto count = static_cast<std::int32_t>(mesh.nodes.size());
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t n : t)
      if (n < 0 || n >= count)
        throw InputError(origin + ": found node " + std::to_string(n) + " in a triangle, expected one in [0, " +
                         std::to_string(count) + ")");
  SoupFaults faults;
  if (is_closed_and_sound(mesh)) {
    drop_unused_nodes(mesh);
    return faults;
  }
  const std::vector<std::int32_t> first = first_near(mesh.nodes, weld_share * extent_of(mesh.nodes), faults.welded);
  std::map<Triangle, bool> known;  // nodes, ascending -> goes_up
  std::vector<Triangle> kept;
  for (Triangle t : mesh.triangles) {
    for (std::int32_t& n : t) n = first[static_cast<std::size_t>(n)];
    if (!has_area(mesh, t)) {
      ++faults.without_area;
      continue;
    }
    const auto [at, is_new] = known.try_emplace(sorted(t), goes_up(t));
    if (is_new)
      kept.push_back(t);
    else
      ++faults.repeated, faults.both_ways |= at->second != goes_up(t);
  }
  if (kept.empty()) throw InputError(origin + ": found no triangle with an area, expected at least one");
  mesh.triangles = std::move(kept);
  drop_unused_nodes(mesh);
  return faults;
}

}  // namespace unibody
