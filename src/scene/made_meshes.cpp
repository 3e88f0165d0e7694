#include "scene/made_meshes.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "scene/random.hpp"

namespace unibody {

namespace {

// z = heights at (cells + 1)^2 nodes over a rectangle about the origin; triangles face up.
TriangleMesh height_field(const std::array<double, 2>& size, const std::array<Id, 2>& cells,
                          const std::function<double(Id, Id)>& z) {
  TriangleMesh mesh;
  const Id nx = cells[0] + 1, ny = cells[1] + 1;
  for (Id j = 0; j < ny; ++j)
    for (Id i = 0; i < nx; ++i)
      mesh.nodes.emplace_back(size[0] * (static_cast<double>(i) / static_cast<double>(cells[0]) - 0.5),
                              size[1] * (static_cast<double>(j) / static_cast<double>(cells[1]) - 0.5), z(i, j));
  for (Id j = 0; j + 1 < ny; ++j)
    for (Id i = 0; i + 1 < nx; ++i) {
      const auto a = static_cast<std::int32_t>(i + nx * j), b = a + 1, c = a + static_cast<std::int32_t>(nx), d = c + 1;
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({a, d, c});
      } else {
        mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({b, d, c});
      }
    }
  return mesh;
}

// Hills: eight waves of lengths from the field's to a quarter of it, in directions and phases that the seed gives.
std::function<double(Id, Id)> hills(double height, std::uint64_t seed, const std::array<Id, 2>& cells) {
  struct Wave {
    double x, y, phase;
  };
  BodyRandom random(seed, 0);
  std::vector<Wave> waves;
  for (int k = 0; k < 8; ++k) {
    const double turns = random.between(1, 4), angle = random.between(-std::numbers::pi, std::numbers::pi);
    waves.push_back({turns * std::cos(angle), turns * std::sin(angle), random.between(0, 1)});
  }
  return [=](Id i, Id j) {
    double sum = 0;
    for (const Wave& w : waves)
      sum += std::sin(2 * std::numbers::pi *
                      (w.x * static_cast<double>(i) / static_cast<double>(cells[0]) +
                       w.y * static_cast<double>(j) / static_cast<double>(cells[1]) + w.phase));
    return height * sum / 8;
  };
}

struct ProfilePoint {
  double radius, height;  // m, from the axis and along it
};

std::vector<ProfilePoint> read_profile(const Value& list) {
  std::vector<ProfilePoint> profile;
  for (const Value& point : list.list("points [radius, height] (m)")) {
    const auto numbers = point.numbers(2, any_number, "m, radius and height");
    if (numbers[0] < 0) point.fail_expected("a radius >= 0 (m)");
    profile.push_back({numbers[0], numbers[1]});
  }
  if (profile.size() < 2) list.fail_expected("2 points [radius, height] or more (m)");
  for (std::size_t k = 1; k < profile.size(); ++k)
    if (profile[k].radius == 0 && profile[k - 1].radius == 0)
      list.entries[k].fail_expected("a radius > 0, since the point before is on the axis, too (m)");
  return profile;
}

Key sides_key(const char* about) { return keys::integer("sides", 3, 10'000, 64, about); }

}  // namespace

const Keys& height_field_keys() {
  static const Keys table{"height_field",
                          "Terrain about the origin.",
                          {keys::numbers("size", 2, "m", positive, needed, "lengths along x and y"),
                           keys::integers("cells", 2, 1, 10'000, needed, "cells along x and y"),
                           keys::list("heights", "m", "a list of numbers (m), row by row along x", "hills",
                                      "heights of the nodes, one more along each axis than cells, row by row along x",
                                      [] { return keys::of_type("number"); }),
                           keys::number("hills", "m", any_number, "heights", "height of hills that are drawn at random"),
                           keys::integer("seed", 0, std::int64_t{1} << 53, 1, "number that gives the hills")}};
  return table;
}

const Keys& tube_keys() {
  static const Keys table{"tube",
                          "The inside of a drum about z, with both ends.",
                          {keys::number("radius", "m", positive, needed, "radius of the drum"),
                           keys::number("length", "m", positive, needed, "length along z"), sides_key("flat sides of the drum")}};
  return table;
}

const Keys& revolved_keys() {
  static const Keys table{"revolve",
                          "What a line covers that turns about z: pipes, funnels, cones, rings.",
                          {keys::list("profile", "m", "a list of points [radius, height] (m)", needed,
                                      "points of the line, each a distance from the axis and a height",
                                      [] { return keys::list_of(keys::of_type("number"), 2); }),
                           sides_key("flat sides around the axis")}};
  return table;
}

TriangleMesh read_height_field(const Value& value, double& below) {
  const KeyedMap map(value, height_field_keys());
  const auto size = map.numbers("size");
  below = std::min(size[0], size[1]) / 4;
  const std::array<Id, 2> cells = map.integers<2>("cells");
  const Value *heights = map.find("heights"), *height = map.find("hills");
  if ((heights != nullptr) == (height != nullptr)) value.fail("both or none of heights and hills", "one of the two");
  if (height) {
    const auto seed = static_cast<std::uint64_t>(map.integer("seed"));
    return height_field({size[0], size[1]}, cells, hills(map.number("hills"), seed, cells));
  }
  map.none_of({"seed"}, "beside heights");
  const auto z = heights->numbers(static_cast<std::size_t>((cells[0] + 1) * (cells[1] + 1)), any_number, "m, row by row along x");
  return height_field({size[0], size[1]}, cells, [&](Id i, Id j) { return z[static_cast<std::size_t>(i + (cells[0] + 1) * j)]; });
}

TriangleMesh read_tube(const Value& value) {
  const KeyedMap map(value, tube_keys());
  const double radius = map.number("radius"), length = map.number("length");
  const auto n = static_cast<std::int32_t>(map.integer("sides"));
  TriangleMesh mesh;
  for (std::int32_t k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * k / n, x = radius * std::cos(angle), y = radius * std::sin(angle);
    mesh.nodes.emplace_back(x, y, -length / 2), mesh.nodes.emplace_back(x, y, length / 2);
  }
  const std::int32_t bottom = 2 * n, top = bottom + 1;
  mesh.nodes.emplace_back(0, 0, -length / 2), mesh.nodes.emplace_back(0, 0, length / 2);
  for (std::int32_t k = 0; k < n; ++k) {
    const std::int32_t a = 2 * k, b = 2 * ((k + 1) % n);
    mesh.triangles.push_back({a, b + 1, b}), mesh.triangles.push_back({a, a + 1, b + 1});
    mesh.triangles.push_back({bottom, a, b}), mesh.triangles.push_back({top, b + 1, a + 1});
  }
  return mesh;
}

TriangleMesh read_revolved(const Value& value) {
  const KeyedMap map(value, revolved_keys());
  const auto profile = read_profile(map.need("profile"));
  const auto n = static_cast<std::int32_t>(map.integer("sides"));
  TriangleMesh mesh;
  std::vector<std::int32_t> first;  // node of each point's ring
  for (const ProfilePoint& point : profile) {
    first.push_back(static_cast<std::int32_t>(mesh.nodes.size()));
    for (std::int32_t k = 0; k < (point.radius > 0 ? n : 1); ++k) {
      const double angle = 2 * std::numbers::pi * k / n;
      mesh.nodes.emplace_back(point.radius * std::cos(angle), point.radius * std::sin(angle), point.height);
    }
  }
  for (std::size_t p = 0; p + 1 < profile.size(); ++p)
    for (std::int32_t k = 0; k < n; ++k) {
      const auto node = [&](std::size_t point, std::int32_t at) {
        return first[point] + (profile[point].radius > 0 ? at % n : 0);
      };
      const std::int32_t a = node(p, k), b = node(p, k + 1), c = node(p + 1, k), d = node(p + 1, k + 1);
      if (a != b) mesh.triangles.push_back({a, b, d});
      if (c != d) mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

}  // namespace unibody
