// Friction of soft solids with all that they may lie on, in the solve and after it, and a solid that touches itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "collide/crossings.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::soft_friction_test {

namespace {

constexpr double g = 9.81;
const std::string solver_list[] = {"accelerated_jacobi", "gauss_seidel"};

std::string soft_block(const std::string& size, const std::string& cells, const std::string& more) {
  return "  - block: {size: " + size + ", cells: " + cells +
         "}\n    density: 1000\n    youngs_modulus: 2.0e5\n    poissons_ratio: 0\n    damping: 0.01\n    thickness: 0.01\n    " +
         more + "\n";
}

const std::string held = "pins: [{within: {min: [-9, -9, -9], max: [9, 9, 0.001]}}]";

// A block of 6 kg, whose nodes come first, on something whose surface, skin included, is at z = 0.005; gravity leans, downhill is
// +x.
Scene on(const std::string& support, double mu, double tangent) {
  const double angle = std::atan(tangent);
  std::string text = "time: {frame: 0.008}\n";
  if (support == "sheet") text += "cloths:\n  - {grid: {size: [3, 1], nodes: [13, 5]}, mass: 1, thickness: 0.01, " + held + "}\n";
  text += "solids:\n";
  if (support == "block") text += soft_block("[3, 1, 0.1]", "[12, 4, 1]", "position: [0, 0, -0.05]\n    " + held);
  const bool skin = support == "sheet" || support == "block";
  text += soft_block("[0.3, 0.2, 0.1]", "[2, 2, 1]", "position: [0.01, 0.02, " + std::string(skin ? "0.06]" : "0.055]"));
  Scene scene = scene_from_text(text);
  scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle)), scene.friction = {mu};
  Body under = support == "sphere" ? ball(1, 1000, Vec3(0, 0, -1000)) : block(1, Vec3(3, 1, 1), Vec3(0, 0, -0.5));
  under.properties.motion = Motion::fixed, under.properties.mass = 0, under.properties.inertia = Vec3::Zero();
  if (!skin) add(scene, under);
  return scene;
}

double speed(const Experiment& run, Id first) {  // m/s downhill, of its 18 nodes
  double momentum = 0, mass = 0;
  for (Id id = first; id < first + 18; ++id) {
    const double m = run.simulation->world.properties[run.slot(id)].mass;
    momentum += m * run.velocity(id).x(), mass += m;
  }
  return momentum / mass;
}

Id first_node(const std::string& support) { return support == "sheet" ? 65 : support == "block" ? 130 : 0; }

}  // namespace

// Below the angle of friction it stays, beyond it gains g (sin - mu cos) a second: for as far as it lies on the same faces of a
// sheet or a block. Where its nodes and edges pass over those of the other mesh, it is held back a little more than that.
TEST(SoftFriction, ABlockSticksOrSlidesOnBodiesClothsAndSolids) {
  const double mu = 0.4, angle = std::atan(1.2 * mu);
  for (const std::string& solver : solver_list)
    for (const std::string support : {"box", "sphere", "sheet", "block"})
      for (const double factor : {0.8, 1.2}) {
        Scene scene = on(support, mu, factor * mu);
        scene.solver.name = solver, scene.solver.iterations = 100, scene.solver.tolerance = 0;
        Experiment run(std::move(scene));
        const Id first = first_node(support);
        run.steps(factor > 1 ? 10 : 25);  // the first ones press it flat
        const double before = speed(run, first), x = run.position(first).x();
        run.steps(40);
        const double gained = speed(run, first) - before, expected = g * (std::sin(angle) - mu * std::cos(angle)) * 40 * run.h();
        if (factor > 1) {
          EXPECT_NEAR(gained, expected, 0.01 * expected) << solver << ' ' << support;
        } else {
          EXPECT_LT(std::abs(run.position(first).x() - x), 1e-4) << solver << ' ' << support;  // free of friction 0.15 m
        }
      }
}

// As torus_on_box has it: friction in the solve holds the block, after it the block creeps, as every step moves with the speed
// that gravity alone gives to what starts at rest, and further where the block trembles.
TEST(SoftFriction, InTheSolveItHoldsAndAfterItItSlips) {
  const double mu = 0.3, tangent = 0.21, seconds = 0.4;
  for (const auto model : {FrictionModel::disc, FrictionModel::postprocess}) {
    Scene scene = on("box", mu, tangent);
    scene.solver.friction = model, scene.solver.iterations = 100;
    const double h = scene.time.frame = 0.016;
    Experiment run(std::move(scene));
    run.seconds(0.6);
    const double x = run.position(0).x();
    run.seconds(seconds);
    const double moved = (run.position(0).x() - x) / seconds;  // m/s
    if (model == FrictionModel::disc) {
      EXPECT_LT(std::abs(moved), 1e-3);
    } else {
      EXPECT_GT(moved, 0.9 * g * std::sin(std::atan(tangent)) * h);
    }
  }
}

namespace {

// A C of cells of 0.1 m: a floor of 1.2 m, a spine of 0.2 m and an arm above that reaches to 0.8 m, 0.3 m above the floor.
std::string letter_c() {
  using Node = std::array<int, 3>;
  std::map<Node, int> numbers;
  std::vector<Node> nodes;
  const auto number = [&](const Node& at) {
    const auto [place, added] = numbers.emplace(at, static_cast<int>(nodes.size()) + 1);
    if (added) nodes.push_back(at);
    return place->second;
  };
  std::ostringstream tets, text;
  int count = 0;
  for (int i = 0; i < 12; ++i)
    for (int k = 0; k < 5; ++k) {
      if (!(i < 2 || k == 0 || (k == 4 && i < 8))) continue;
      std::array<std::size_t, 3> path{0, 1, 2};
      do {
        Node at{i, 0, k};
        tets << ++count << " 4 0 " << number(at);
        for (const std::size_t axis : path) ++at[axis], tets << ' ' << number(at);
        tets << '\n';
      } while (std::next_permutation(path.begin(), path.end()));
    }
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << nodes.size() << '\n';
  for (std::size_t n = 0; n < nodes.size(); ++n)
    text << n + 1 << ' ' << 0.1 * nodes[n][0] << ' ' << 0.1 * nodes[n][1] << ' ' << 0.1 * nodes[n][2] << '\n';
  text << "$EndNodes\n$Elements\n" << count << '\n' << tets.str() << "$EndElements\n";
  return text.str();
}

std::size_t crossings_of_surface(const Experiment& run) {
  std::vector<Face> faces;
  const Surface& surface = run.scene->surfaces[0];
  for (Id k = 0; k < surface.count; ++k) {
    const auto ids = surface.cell(k);
    faces.push_back({run.simulation->world.find(ids[0]), run.simulation->world.find(ids[1]), run.simulation->world.find(ids[2])});
  }
  return find_crossings(run.simulation->world.position, faces, unique_edges(faces)).size();
}

}  // namespace

// The arm sinks onto the floor of the C: its end comes to lie there, two halves of the skin above it, and its edges go through no
// face; they do where the solid does not collide with itself.
TEST(SoftFriction, AnArmOfASolidComesToRestOnTheSolidItself) {
  const TextFile mesh(letter_c(), ".msh");
  for (const bool itself : {true, false}) {
    Scene scene =
        scene_from_text("time: {frame: 0.008}\nsolids:\n  - mesh: " + mesh.path() +
                        "\n    density: 1000\n    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3\n    damping: 0.02\n"
                        "    thickness: 0.01\n    position: [0, 0, 0.005]\n    least_volume: 0.1\n    self_collision: " +
                        (itself ? "true" : "false") + "\n");
    add(scene, ground());
    Experiment run(std::move(scene));
    std::vector<Id> floor, arm;  // at the arm's end, those that face each other
    const Id nodes = run.scene->surfaces[0].node_count;
    for (Id id = 0; id < nodes; ++id) {
      const Vec3 x = run.position(id);
      if (std::abs(x.x() - 0.8) > 1e-9) continue;
      if (std::abs(x.z() - 0.105) < 1e-9) floor.push_back(id);
      if (std::abs(x.z() - 0.405) < 1e-9) arm.push_back(id);
    }
    ASSERT_EQ(floor.size(), 2);
    ASSERT_EQ(arm.size(), 2);
    std::size_t crossings = 0;
    for (int k = 0; k < 250; ++k) {
      run.step();
      crossings += crossings_of_surface(run);
    }
    const auto height = [&](const std::vector<Id>& of) { return 0.5 * (run.position(of[0]).z() + run.position(of[1]).z()); };
    if (itself) {
      EXPECT_EQ(crossings, 0);
      EXPECT_NEAR(height(arm) - height(floor), 0.01, 0.001);  // m; apart by 0.3 at the start
    } else {
      EXPECT_GT(crossings, 100);
    }
  }
}

}  // namespace unibody::small_worlds::soft_friction_test
