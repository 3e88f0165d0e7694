// Sheets that hang from their upper edge, against springs in a row, elastic strips and the hanging chain.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "small_worlds.hpp"

namespace unibody::small_worlds::hanging_cloth_test {

namespace {

constexpr double g = 9.81, width = 0.3, height = 1, per_area = 2;  // m/s^2, m, kg/m^2

// A sheet of nx by ny nodes hangs straight from its uppermost row at z = 0; node [i, j] is `depth(j)` below it.
Scene sheet(int nx, int ny, const std::string& model) {
  std::ostringstream text;
  text << "gravity: [0, 0, " << -g << "]\ncloths:\n  - grid: {size: [" << width << ", " << height << "], nodes: [" << nx << ", "
       << ny << "]}\n    mass_per_area: " << per_area << "\n    thickness: 0.002\n    " << model
       << "\n    orientation: {axis: [1, 0, 0], angle: -90}\n    position: [0, 0, " << -0.5 * height << "]\n    pins: [";
  for (int i = 0; i < nx; ++i) text << (i > 0 ? ", " : "") << "{node: [" << i << ", 0]}";
  Scene scene = scene_from_text(text.str() + "]\n");
  scene.solver.tolerance = 0;
  return scene;
}

// Weight (N) of what hangs below the middle of segment j, of n, of the whole sheet: its nodes' masses go half to each cell.
double weight_below(int j, int n) { return per_area * width * height * g * (n - j - 0.5) / n; }

}  // namespace

// Rows of springs without diagonals: columns hang one by one, an outer one with half the mass of an inner one. Each spring is
// longer by the weight below it over its stiffness, as far as 300 iterations go.
TEST(HangingSheet, StretchIsThatOfSpringsInARow) {
  constexpr int nx = 4, ny = 11;
  const double k = 400, cell = width / (nx - 1);
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Scene scene = sheet(nx, ny, "links: {diagonals: none, stiffness: 400, damping: 0.05}");
    scene.time.substeps = 2, scene.solver.name = solver, scene.solver.iterations = 300;
    Experiment run(std::move(scene));
    run.seconds(10);
    for (int i = 0; i < nx; ++i) {
      double depth = 0;
      const double share = (i == 0 || i == nx - 1 ? 0.5 : 1) * cell / width;
      for (int j = 1; j < ny; ++j) {
        depth += height / (ny - 1) + share * weight_below(j - 1, ny - 1) / k;
        EXPECT_NEAR(-run.position(i + nx * j).z(), depth, 2e-6) << solver << ' ' << i << ' ' << j;  // of 12 mm
      }
    }
  }
}

// A membrane without lateral contraction: row for row, P = E/2 l (l^2 - 1) of St. Venant and Kirchhoff carries the weight below.
// The gradients turn within a step; steps end in the total form, so that nothing is left of that, whatever their length.
TEST(HangingSheet, MembraneStretchesAsStVenantKirchhoff) {
  constexpr int nx = 4, ny = 9;
  const double E = 5e4, section = 0.002 * width;
  std::vector<double> depth{0};
  for (int j = 1; j < ny; ++j) {
    const double P = weight_below(j - 1, ny - 1) / section;
    double l = 1;
    for (int k = 0; k < 50; ++k) l -= (0.5 * E * l * (l * l - 1) - P) / (0.5 * E * (3 * l * l - 1));
    depth.push_back(depth.back() + height / (ny - 1) * l);
  }
  const double extension = depth.back() - height;
  EXPECT_GT(extension, 0.08 * height);  // 0.1 by Hooke's law
  for (const std::string solver : {"nesterov", "optimized", "gauss_seidel", "total"})
    for (const int substeps : {1, 2, 4}) {
      Scene scene = sheet(nx, ny, "membrane: {youngs_modulus: 5.0e4, poissons_ratio: 0, damping: 0.05}");
      scene.time.substeps = substeps, scene.solver.iterations = 200;
      if (solver == "nesterov") scene.solver.acceleration = Acceleration::nesterov;
      if (solver == "optimized") scene.solver.acceleration = Acceleration::optimized;
      if (solver == "gauss_seidel") scene.solver.name = solver;
      if (solver == "total") scene.solver.form = Form::total;
      Experiment run(std::move(scene));
      run.seconds(8);
      for (int j = 1; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
          EXPECT_NEAR(-run.position(i + nx * j).z(), depth[static_cast<std::size_t>(j)], 1e-6 * extension)
              << solver << ' ' << substeps << ' ' << i << ' ' << j;
    }
}

// A light membrane of stiffness number 27 (h^2 D^T W D / E) that a bar of seven times its mass stretches by a tenth: the tension
// turns with the membrane by more than the masses of its nodes can follow, which a pass of the total form takes into account.
TEST(HangingSheet, AMembraneBearsAHeavyBar) {
  constexpr int ny = 9;
  constexpr double E = 5e4, wide = 0.5, section = 0.002 * wide, mass = 0.14 * wide, bar = 0.5, tolerance = 1e-7;
  double depth = 0;
  for (int j = 0; j + 1 < ny; ++j) {
    const double P = (mass * (ny - 1.5 - j) / (ny - 1) + bar) * g / section;
    double l = 1;
    for (int k = 0; k < 50; ++k) l -= (0.5 * E * l * (l * l - 1) - P) / (0.5 * E * (3 * l * l - 1));
    depth += l / (ny - 1);
  }
  ASSERT_GT(depth, 1.09);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const std::string form : {"auto", "total"}) {
      std::ostringstream text;
      text << "gravity: [0, 0, " << -g << "]\nsolver: {iterations: 2000, tolerance: " << tolerance << ", name: " << solver
           << ", form: " << form
           << "}\nbodies:\n  - {name: bar, shape: {box: {size: [0.5, 0.02, 0.05]}}, mass: 0.5, position: [0, 0, -1.03]}\n"
              "cloths:\n  - grid: {size: [0.5, 1], nodes: [4, 9]}\n    mass_per_area: 0.14\n    thickness: 0.002\n"
              "    membrane: {youngs_modulus: 5.0e4, poissons_ratio: 0, damping: 0.05}\n"
              "    orientation: {axis: [1, 0, 0], angle: -90}\n    position: [0, 0, -0.5]\n    pins: [";
      for (int i = 0; i < 4; ++i) text << "{node: [" << i << ", 0]}, {node: [" << i << ", 8], to: bar}" << (i < 3 ? ", " : "]\n");
      Experiment run(scene_from_text(text.str()));
      run.seconds(8);
      EXPECT_NEAR(-run.position(0).z() - 0.03, depth, 10 * tolerance) << solver << ' ' << form;
    }
}

// Small swings of a sheet that does not stretch are those of a hanging chain, whose shape is J0(j0 sqrt(u)) with the distance u L
// from the free end and the first zero j0 of the Bessel function J0: period 4 pi / j0 sqrt(L / g). A chain of n segments is
// slower by 0.3 / n^2. Stiff links that say the same twice are left out: the tension they share is not unique.
TEST(HangingSheet, SwingsWithThePeriodOfTheChain) {
  const double j0 = 2.404825557695773, period = 4 * M_PI / j0 * std::sqrt(height / g);
  for (const auto& [nx, ny, diagonals] : {std::tuple(4, 11, "none"), std::tuple(2, 11, "both"), std::tuple(3, 21, "none")}) {
    Scene scene = sheet(nx, ny, std::string("links: {diagonals: ") + diagonals + "}");
    scene.time.substeps = 8, scene.solver.iterations = 100;
    Experiment run(std::move(scene));
    World& world = run.world();
    for (std::size_t s = 0; s < world.homes; ++s) {
      const double u = std::max(0.0, 1 + world.position[s].z() / height);
      world.velocity[s].y() = 0.01 * std::cyl_bessel_j(0, j0 * std::sqrt(u));
    }
    std::vector<double> zeros;  // s
    double before = 0;
    for (int k = 1; zeros.size() < 5 && k < 5000; ++k) {
      run.step();
      const double now = run.position(nx * ny - 1).y();
      if (now * before < 0) zeros.push_back(run.h() * (k - now / (now - before)));
      before = now;
    }
    ASSERT_EQ(zeros.size(), 5u);
    const double segments = ny - 1, expected = period * (1 + 0.3 / (segments * segments));
    EXPECT_NEAR((zeros[4] - zeros[0]) / 2, expected, 1e-3 * period) << nx << ' ' << ny << ' ' << diagonals;
  }
}

}  // namespace unibody::small_worlds::hanging_cloth_test
