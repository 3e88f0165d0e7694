// Nothing goes through a surface: bullets, layers, folds. Crossings are counted exactly in every frame.
#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"
#include "collide/continuous.hpp"
#include "collide/crossings.hpp"
#include "report/surface_report.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::surface_crossing_test {

namespace {

using unibody::samples::Random;

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

std::int64_t crossings(Experiment& run) {
  run.simulation->detect();  // the surfaces, too
  return count_crossings(MPI_COMM_SELF, run.world(), run.simulation->search.surfaces);
}

void expect_no_crossings(Experiment& run, int steps, const std::string& what) {
  for (int k = 0; k < steps; ++k) {
    run.step();
    ASSERT_EQ(crossings(run), 0) << what << ", step " << k;
  }
  ASSERT_TRUE(run.finite()) << what;
}

std::array<Vec3, 5> places(const Experiment& run, Id body) {
  return {run.position(0), run.position(1), run.position(2), run.position(3), run.position(body)};
}

const std::string solver_list[] = {"accelerated_jacobi", "gauss_seidel"};

}  // namespace

// At h = 16 ms 1.6 m and 16 m a step. A cloth of one cell and 4 nodes, hit on a face, on its diagonal, and aslant, and pinned or
// free: the ball's centre goes through no face on the way from place to place, and the momentum of the two stays (free).
TEST(SurfaceCrossing, ABulletDoesNotPassAClothOfOneCell) {
  for (const std::string& solver : solver_list)
    for (const double speed : {100.0, 1000.0})
      for (const double mass : {0.01, 1.0})
        for (const bool pinned : {false, true})
          for (const Vec3& aim : {Vec3(0.3, -0.2, 0), Vec3(0.1, 0.1, 0), Vec3(-0.2, 0.31, 0)})
            for (const double slant : {0.0, 0.5}) {
              const std::string pins = pinned ? ", pins: [{node: [0, 0]}, {node: [1, 0]}, {node: [0, 1]}, {node: [1, 1]}]" : "";
              Scene scene = scene_from_text("cloths:\n  - {grid: {size: [2, 2], nodes: [2, 2]}, mass: 1, thickness: 0.01" + pins +
                                            "}\ngravity: [0, 0, 0]\n");
              scene.solver.name = solver;
              const Vec3 velocity = speed * Vec3(std::sin(slant), 0, -std::cos(slant));
              Body bullet = ball(mass, 0.02, aim - 0.4 * 0.016 * velocity);
              bullet.state.velocity = velocity;
              const Id id = add(scene, bullet);
              Experiment run(std::move(scene));
              const Vec3 p = run.momentum();
              const double energy = run.kinetic_energy();
              std::int64_t held = 0;
              for (int k = 0; k < 5; ++k) {
                const std::array<Vec3, 5> before = places(run, id);
                run.step();
                const std::array<Vec3, 5> after = places(run, id);
                const auto way = [&](std::size_t i) { return MovingPoint{before[i], after[i]}; };
                for (const auto& f : run.simulation->search.surfaces.faces) {
                  const auto node = [&](std::size_t i) { return way(static_cast<std::size_t>(f.nodes[i])); };
                  EXPECT_FALSE(point_meets_triangle(way(4), node(0), node(1), node(2), {0, 1e-9, 200}).hit)
                      << solver << ", speed " << speed << ", mass " << mass << ", pinned " << pinned << ", aim " << aim.x()
                      << ", slant " << slant << ", step " << k << ", held " << run.last.guard.pairs;
                }
                // What is held last of all, on the diagonal by two faces at once, loses some.
                held += run.last.guard.pairs;
                if (!pinned) {
                  EXPECT_LT((run.momentum() - p).norm(), (held > 0 ? 0.03 : 1e-12) * p.norm())
                      << solver << ", speed " << speed << ", mass " << mass << ", aim " << aim.x() << ", slant " << slant;
                }
                ASSERT_LE(run.kinetic_energy(), energy * (1 + 1e-9));
              }
              EXPECT_LT(run.kinetic_energy(), 0.999 * energy) << "it met nothing";
            }
}

// Sheets that fall one on the other on a ball and on a box: C7 of the catalogue.
TEST(SurfaceCrossing, LayersOnABallAndOnABox) {
  const std::string sheet = R"(
  - grid: {size: [1, 1], nodes: [9, 9]}
    mass: 0.2
    thickness: 0.01
    self_collision: true
    links: {stiffness: 1000, damping: 0.01}
    position: [0, 0, HEIGHT]
    orientation: {axis: [0, 0, 1], angle: ANGLE})";
  // Gauss-Seidel takes contacts of surfaces by plain sweeps: five layers are too much for it at the usual iterations.
  for (const auto& [solver, layers] : {std::pair(solver_list[0], 5), std::pair(solver_list[1], 2)})
    for (const std::string shape : {"{sphere: {radius: 0.3}}", "{box: {size: [0.4, 0.4, 0.6]}}"}) {
      std::string text = "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: " + shape +
                         ", motion: fixed, position: [0, 0, 0.3]}\ncloths:";
      for (int k = 0; k < layers; ++k)
        text += replaced(replaced(sheet, "HEIGHT", std::to_string(0.615 + 0.015 * k)), "ANGLE", std::to_string(17 * k));
      Scene scene = scene_from_text(text + "\n");
      scene.solver.name = solver;
      Experiment run(std::move(scene));
      const double start = run.position(2).z();
      expect_no_crossings(run, 40, solver + ' ' + std::to_string(layers) + ' ' + shape);
      EXPECT_LT(run.position(2).z(), start - 0.1) << "a corner hangs down";
      double top = 0;
      for (Id id = 2; id < 2 + 81 * layers; ++id) top = std::max(top, run.position(id).z());
      EXPECT_GT(top, 0.58) << "held by what is below";
    }
}

// A sheet whose one half is thrown over onto the other, with and without self-collision. The control: without, it crosses.
TEST(SurfaceCrossing, AFoldedClothDoesNotPassThroughItself) {
  for (const std::string& solver : solver_list) {
    bool crossed = false;
    for (const bool itself : {true, false}) {
      Scene scene = scene_from_text(replaced(R"(
bodies:
  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [50, 0, 0]}
cloths:
  - grid: {size: [1, 0.5], nodes: [21, 11]}
    mass: 0.2
    thickness: 0.01
    self_collision: ITSELF
    links: {stiffness: 500, damping: 0.01}
gravity: [0, 0, 0]
)",
                                             "ITSELF", itself ? "true" : "false"));
      scene.solver.name = solver;
      Experiment run(std::move(scene));
      Random random(9);
      World& world = run.world();
      for (std::size_t i = 1; i < world.homes; ++i) {  // the right half stands upright and falls to the left
        Vec3& x = world.position[i];
        if (x.x() > 0) x = Vec3(0.05, x.y(), x.x()), world.velocity[i] = Vec3(-6 * x.z(), 1.5, -1);
        world.velocity[i] += random.vector(-0.2, 0.2);
      }
      for (int k = 0; k < 60; ++k) {
        run.step();
        std::int64_t count = crossings(run);
        if (itself) {
          ASSERT_EQ(count, 0) << solver << ", step " << k;
        } else if (!crossed) {
          std::vector<std::array<Slot, 3>> faces;
          std::vector<std::array<Slot, 2>> edges;
          for (const auto& f : run.simulation->search.surfaces.faces) faces.push_back(f.nodes);
          for (const auto& e : run.simulation->search.surfaces.edges) edges.push_back(e.nodes);
          crossed = !find_crossings(world.position, faces, edges).empty();
          ASSERT_EQ(count, 0) << "of a cloth that doesn't collide with itself none count";
        }
      }
      EXPECT_TRUE(run.finite());
    }
    EXPECT_TRUE(crossed) << "the motion would not have led through";
  }
}

// A sheet thrown at a sheet that is held, at speeds at which it would be through within one step.
TEST(SurfaceCrossing, AThrownSheetDoesNotPassASheet) {
  for (const std::string& solver : solver_list)
    for (const double speed : {3.0, 30.0, 300.0})
      for (const bool itself : {false, true}) {
        Scene scene = scene_from_text(replaced(replaced(R"(
cloths:
  - grid: {size: [1, 1], nodes: [9, 9]}
    mass: 1
    thickness: 0.01
    self_collision: ITSELF
    links: {stiffness: 1.0e+4, damping: 0.01}
    pins: [{node: [0, 0]}, {node: [8, 0]}, {node: [0, 8]}, {node: [8, 8]}]
  - grid: {size: [0.6, 0.6], nodes: [8, 8]}
    mass: 0.2
    thickness: 0.01
    self_collision: ITSELF
    links: {stiffness: 1.0e+4, damping: 0.01}
    position: [0.03, 0.02, 0.25]
    orientation: {axis: [0.6, 0, 0.8], angle: 30}
    velocity: [0.5, 0, SPEED]
)",
                                                        "SPEED", std::to_string(-speed)),
                                               "ITSELF", itself ? "true" : "false"));
        scene.solver.name = solver;
        Experiment run(std::move(scene));
        ASSERT_EQ(crossings(run), 0);
        expect_no_crossings(run, 30, solver + ' ' + std::to_string(speed));
        const Vec3 p = run.position(81 + 27);
        EXPECT_GT(p.norm(), 1e-3);
      }
}

// A thread that falls across another one that is held at its ends.
TEST(SurfaceCrossing, AThreadHangsOverAThread) {
  for (const std::string& solver : solver_list) {
    Scene scene = scene_from_text(R"(
threads:
  - {points: [[-0.5, 0, 0], [0.5, 0, 0]], segments: 7, radius: 0.01, mass: 0.1, pins: [{node: 0}, {node: 7}]}
  - {points: [[0.03, -0.5, 0.05], [0.03, 0.5, 0.05]], segments: 9, radius: 0.01, mass: 0.05}
)");
    scene.solver.name = solver, scene.friction = {0.8};
    Experiment run(std::move(scene));
    for (int k = 0; k < 60; ++k) {
      run.step();
      double upper = -1, lower = 1;
      for (Id id = 0; id < 8; ++id) lower = std::min(lower, run.position(id).z());
      for (Id id = 8; id < 18; ++id) upper = std::max(upper, run.position(id).z());
      ASSERT_GT(upper, lower) << solver << ' ' << k;
    }
    EXPECT_LT(run.position(8).z(), -0.3) << "its ends hang down";
    EXPECT_TRUE(run.finite());
  }
}

// A heavy ball on a light cloth that hangs between two edges: whatever the iterations leave undone, it stays on its side.
TEST(SurfaceCrossing, AHeavyBallStaysOnItsSide) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int iterations : {2, 4, 50}) {
      Experiment run(scene_from_text("solver: {name: " + std::string(solver) + ", iterations: " + std::to_string(iterations) +
                                     "}\nbodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, "
                                     "2.103]}\ncloths:\n  - {grid: {size: [1, 1], "
                                     "nodes: [21, 21]}, mass: 0.3, thickness: 0.005, position: [0, 0, 2], pins: [{within: {min: "
                                     "[-0.51, -0.51, 1], max: [-0.49, "
                                     "0.51, 3]}}, {within: {min: [0.49, -0.51, 1], max: [0.51, 0.51, 3]}}]}\n"));
      for (int k = 0; k < 300; ++k) {
        run.step();
        const Vec3 ball = run.position(0);
        double nearest = HUGE_VAL, height = 0;
        for (Id id = 1; id <= 441; ++id) {
          const Vec3 way = run.position(id) - ball;
          if (way.head<2>().norm() < nearest) nearest = way.head<2>().norm(), height = way.z();
        }
        ASSERT_LT(height, 0) << solver << ", " << iterations << " iterations, step " << k;
      }
    }
}

}  // namespace unibody::small_worlds::surface_crossing_test
