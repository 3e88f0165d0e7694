// A round cloth over a round table, as Cusick's drape meter has it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::drape_test {

namespace {

constexpr double radius = 0.15, table = 0.09, spacing = 0.015;  // m
constexpr double edge = 1e-9;                                   // m, beyond which a node is outside a circle

// The equilateral lattice between two nodes' width inside the table's rim and the cloth's.
struct Ring {
  std::vector<Eigen::Vector2d> places;  // m, of the nodes
  std::vector<std::array<std::size_t, 3>> triangles;

  Ring() {
    const auto place = [](std::pair<int, int> at) {
      return Eigen::Vector2d(spacing * (at.first + 0.5 * at.second), spacing * std::sqrt(0.75) * at.second);
    };
    std::map<std::pair<int, int>, std::size_t> number;
    const auto add_if_inside = [&](const std::array<std::pair<int, int>, 3>& corners) {
      for (const auto& at : corners)
        if (place(at).norm() > radius + edge || place(at).norm() < table - 2 * spacing) return;
      std::array<std::size_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [at, is_new] = number.emplace(corners[k], number.size());
        triangle[k] = at->second;
        if (is_new) places.push_back(place(corners[k]));
      }
      triangles.push_back(triangle);
    };
    for (int j = -12; j <= 12; ++j)
      for (int i = -18; i <= 18; ++i) {
        add_if_inside({std::pair(i, j), std::pair(i + 1, j), std::pair(i, j + 1)});
        add_if_inside({std::pair(i, j), std::pair(i + 1, j - 1), std::pair(i + 1, j)});
      }
  }
  bool is_held(std::size_t node) const { return places[node].norm() < table + edge; }
  bool is_held(const std::array<std::size_t, 3>& t) const { return is_held(t[0]) && is_held(t[1]) && is_held(t[2]); }

  std::string obj() const {
    std::ostringstream text;
    text.precision(17);
    for (const auto& x : places) text << "v " << x.transpose() << " 0\n";
    for (const auto& t : triangles) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return text.str();
  }
};

// The drape coefficient: the shadow of what hangs over, by its area. A cloth of this rigidity (N m), sqrt(3) / 2 of an edge's
// stiffness; all lengths times `scale`, and all times by its root.
double drape(double rigidity, double scale = 1) {
  const Ring ring;
  const TextFile mesh(ring.obj());
  std::ostringstream text;
  text.precision(17);
  text << "time: {frame: " << 0.004 * std::sqrt(scale)
       << "}\ncloths:\n  - mesh: " << mesh.path().substr(mesh.path().rfind('/') + 1) << "\n    scale: " << scale
       << "\n    mass_per_area: 0.2\n    thickness: 0.001\n    links: {stiffness: " << 100 * scale
       << ", damping: " << 0.01 * std::sqrt(scale)
       << "}\n    bending: {model: dihedral, stiffness: " << rigidity * 2 / std::sqrt(3)
       << ", damping: " << 0.03 * std::sqrt(scale) << "}\n    pins: [";
  const char* between = "";
  for (std::size_t node = 0; node < ring.places.size(); ++node)
    if (ring.is_held(node)) text << between << "{node: " << node << '}', between = ", ";
  Scene scene = scene_from_text(text.str() + "]\n");
  scene.solver.tolerance = 0, scene.solver.iterations = 100;
  Experiment run(std::move(scene));
  for (std::size_t node = 0; node < ring.places.size(); ++node)  // folds need a cause
    if (!ring.is_held(node))
      run.world().position[run.slot(static_cast<Id>(node))].z() += 1e-4 * scale * std::sin(double(node * node));
  run.steps(300);
  double shadow = 0, area = 0;
  for (const auto& t : ring.triangles) {
    if (ring.is_held(t)) continue;
    const auto at = [&](std::size_t k) { return run.position(static_cast<Id>(t[k])); };
    shadow += 0.5 * std::abs((at(1) - at(0)).cross(at(2) - at(0)).z());
    area += 0.5 * std::sqrt(0.75) * std::pow(spacing * scale, 2);
  }
  return shadow / area;
}

}  // namespace

// Stiffer cloths throw a larger shadow; one that is stiff for its weight lies as a disc.
TEST(Drape, CoefficientGrowsWithTheRigidity) {
  const double limp = drape(3e-5), middling = drape(1e-4), stiff = drape(1e-3);
  RecordProperty("nodes", static_cast<int>(Ring().places.size()));
  RecordProperty("coefficients", std::to_string(limp) + ", " + std::to_string(middling) + ", " + std::to_string(stiff));
  EXPECT_GT(limp, 0.5);
  EXPECT_GT(middling, limp + 0.05);
  EXPECT_GT(stiff, middling + 0.05);
  EXPECT_LT(stiff, 1);
}

// The shape depends on weight L^3 / B alone, the springs in its plane taken along: four times as large and 64 times as stiff, the
// cloth has the same.
TEST(Drape, DependsOnOneRatio) {
  const double small = drape(1e-4), large = drape(64e-4, 4);
  EXPECT_NEAR(large, small, 1e-6);
}

}  // namespace unibody::small_worlds::drape_test
