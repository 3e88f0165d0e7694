// Pressure on cloths and solids against closed forms and direct sums.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "collide/bodies.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::pressure_test {

namespace {

using unibody::samples::Random;

const char* const solver_list[] = {"accelerated_jacobi", "gauss_seidel"};

// A ball's surface as triangles of an octahedron, divided `levels` times; 0.1 m of radius.
std::string ball_mesh(int levels) {
  std::vector<Vec3> nodes{Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
  std::vector<std::array<int, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                            {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> halves;
    const auto half = [&](int a, int b) {
      const auto [at, is_new] = halves.emplace(std::minmax(a, b), static_cast<int>(nodes.size()));
      if (is_new) nodes.push_back((nodes[static_cast<std::size_t>(a)] + nodes[static_cast<std::size_t>(b)]).normalized());
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int ab = half(a, b), bc = half(b, c), ca = half(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = finer;
  }
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& x : nodes) text << "v " << 0.1 * x.x() << ' ' << 0.1 * x.y() << ' ' << 0.1 * x.z() << '\n';
  for (const auto& t : triangles) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

std::string balloon(const TextFile& mesh, const std::string& solver, int substeps) {
  return "time: {substeps: " + std::to_string(substeps) + "}\ngravity: [0, 0, 0]\nsolver: {" + solver +
         ", iterations: 300}\ncloths:\n  - mesh: " + mesh.path().substr(mesh.path().rfind('/') + 1) +
         "\n    mass_per_area: 5\n    thickness: 0.002\n    pressure: 545\n"
         "    membrane: {youngs_modulus: 1.0e+5, poissons_ratio: 0.3, damping: 0.05}\n";
}

// m^2 and m^3: the sum of the triangles' areas along their normals, and the volume within a closed surface.
std::pair<Vec3, double> sums(Experiment& run, double after = 0) {
  Vec3 area = Vec3::Zero();
  double volume = 0;
  const Surface& surface = run.scene->surfaces[0];
  for (Id k = 0; k < surface.count; ++k) {
    const auto ids = surface.cell(k);
    const auto place = [&](std::size_t i) -> Vec3 { return run.position(ids[i]) + after * run.velocity(ids[i]); };
    const Vec3 a = place(0), b = place(1), c = place(2);
    area += 0.5 * (b - a).cross(c - a), volume += a.dot(b.cross(c)) / 6;
  }
  return {area, volume};
}

}  // namespace

// Of a crumpled open sheet the momentum grows in a step by the pressure's mean over the step times the area vector to which the
// velocities at its start lead: of a constant, a table that rises in the step, and a sine.
TEST(Pressure, TheForceIsThatOfTheTriangles) {
  const double h = 0.016;
  const auto law = [&](double from, double to, double (*integral)(double)) {
    return (integral(to) - integral(from)) / (to - from);
  };
  const std::pair<const char*, double (*)(double)> laws[] = {{"-30", [](double t) { return -30 * t; }},
                                                             {"[[0, 0], [10, 5000]]", [](double t) { return 250 * t * t; }},
                                                             {"{sine: {mean: 5, amplitude: 20, frequency: 3}}", [](double t) {
                                                                return 5 * t - 20 * std::cos(6 * M_PI * t) / (6 * M_PI);
                                                              }}};
  for (const char* solver : solver_list)
    for (const auto& [pressure, integral] : laws) {
      Experiment run(
          scene_from_text("gravity: [0, 0, 0]\nsolver: {name: " + std::string(solver) +
                          "}\ncloths:\n  - grid: {size: [1, 0.8], nodes: [6, 5]}\n    mass_per_area: 0.2\n    thickness: 0.01\n" +
                          "    links: {stiffness: 1.0e-9}\n    pressure: " + pressure + "\n"));
      Random random(5);
      for (std::size_t i = 0; i < run.world().homes; ++i)
        run.world().position[i] += Vec3(random(-.05, .05), random(-.05, .05), random(-.2, .2));
      ASSERT_EQ(run.h(), h);
      for (int k = 0; k < 3; ++k) {
        const Vec3 before = run.momentum(), area = sums(run, h).first;
        run.step();
        const Vec3 expected = law(k * h, (k + 1) * h, integral) * h * area;
        EXPECT_GT(expected.norm(), 1e-4);
        EXPECT_LT((run.momentum() - before - expected).norm(), 1e-9 * expected.norm()) << solver << ' ' << pressure << ' ' << k;
      }
    }
}

// It neither pushes nor turns a closed surface, and blows it up as the thin ball of its law: the tension T = p R l / 2 across a
// section, and the membrane's T = t E / (1 - nu) (l^2 - 1) / 2, R and t at rest, l the stretch. The rest is that of the mesh, of
// second order, in the total form and by default, where steps end in it.
TEST(Pressure, ABalloonTakesTheSizeAtWhichItsMembraneBalances) {
  const double pressure = 545, scale = 1e5 * 0.002 / 0.7, half = pressure * 0.1 / scale / 2;
  const double expected = half + std::sqrt(half * half + 1);  // of scale (l^2 - 1) = p R l
  ASSERT_GT(expected, 1.09);
  const auto error = [&](int levels, const std::string& solver, int substeps) {
    const TextFile mesh(ball_mesh(levels), ".obj");
    Experiment run(scene_from_text(balloon(mesh, solver, substeps)));
    const double before = sums(run).second;
    run.seconds(1.5);
    const double mass = 5 * 4 * M_PI * 0.01;
    EXPECT_LT(run.momentum().norm(), 1e-12 * mass) << solver;
    EXPECT_LT(run.angular_momentum().norm(), 1e-8 * mass) << solver;
    EXPECT_TRUE(run.last.converged) << solver;
    return std::cbrt(sums(run).second / before) - expected;
  };
  for (const std::string solver : solver_list) {
    const std::string total = "form: total, name: " + solver;
    const double coarse = error(1, total, 8), fine = error(2, total, 8);
    EXPECT_LT(std::abs(fine), 0.05 * (expected - 1)) << solver;
    EXPECT_NEAR(coarse / fine, 4, 1) << solver << ' ' << coarse << ' ' << fine;
    EXPECT_NEAR(error(2, "name: " + solver, 8), fine, 1e-4 * (expected - 1)) << solver;
  }
}

// A block under pressure from all sides strains alike everywhere, which linear tetrahedra have exactly: of St. Venant-Kirchhoff's
// law p l = E / (1 - 2 nu) (1 - l^2) / 2 at the stretch l.
TEST(Pressure, ABlockIsPressedTogetherAsItsLawSays) {
  const double modulus = 1e4, poisson = 0.3, pressure = 1000, half = pressure * (1 - 2 * poisson) / modulus;
  const double expected = std::sqrt(half * half + 1) - half;
  ASSERT_LT(expected, 0.97);
  for (const char* solver : solver_list)
    for (const int substeps : {1, 4}) {
      Scene scene =
          scene_from_text("gravity: [0, 0, 0]\nsolver: {name: " + std::string(solver) +
                          ", iterations: 300}\nsolids:\n  - block: {size: [0.4, 0.3, 0.2], cells: [4, 3, 2]}\n    density: 1000\n"
                          "    youngs_modulus: 1.0e+4\n    poissons_ratio: 0.3\n    damping: 0.05\n    thickness: 0.01\n"
                          "    pressure: -1000\n");
      scene.time.substeps = substeps;
      Experiment run(std::move(scene));
      const double before = sums(run).second;
      run.seconds(2);
      EXPECT_NEAR(std::cbrt(sums(run).second / before), expected, 1e-6) << solver << ' ' << substeps;
      EXPECT_LT(run.momentum().norm(), 1e-12) << solver;
    }
}

// A force on a part of a solid that changes in time: the momentum grows by its integral, and the face that it pulls at leads.
TEST(Pressure, AForceOnAPartThatChangesInTimeGivesItsIntegral) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\nsolver: {name: " + std::string(solver) +
        "}\nsolids:\n  - block: {size: [0.4, 0.2, 0.2], cells: [4, 2, 2]}\n    density: 1000\n"
        "    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3\n    thickness: 0.01\n"
        "    loads: [{within: {min: [0.2, -1, -1], max: [0.2, 1, 1]}, force: [{sine: {mean: 3, amplitude: 2, "
        "frequency: 5}}, 0, [[0, 0], [1, 8]]]}, {within: {min: [-0.2, -1, -1], max: [-0.2, 1, 1]}, force: [1, 0, 0]}]\n"));
    run.steps(10);
    const double t = 10 * run.h();
    const Vec3 expected(4 * t + 2 * (1 - std::cos(10 * M_PI * t)) / (10 * M_PI), 0, 4 * t * t);
    EXPECT_LT((run.momentum() - expected).norm(), 1e-9 * expected.norm()) << solver << ' ' << run.momentum().transpose();
    EXPECT_LT(run.angular_momentum().y(), -1e-3) << solver;  // the pull upwards is at the end of greater x
  }
}

// A node that is held stays where it is.
TEST(Pressure, AHeldSheetBulgesToItsSide) {
  Experiment run(
      scene_from_text("gravity: [0, 0, 0]\nsolver: {iterations: 200}\ncloths:\n  - grid: {size: [1, 1], nodes: [3, 3]}\n    "
                      "mass: 0.2\n    thickness: 0.01\n"
                      "    pressure: 5\n    links: {stiffness: 100, damping: 0.1}\n"
                      "    pins: [{node: [0, 0]}, {node: [1, 0]}, {node: [2, 0]}, {node: [0, 1]}, {node: [2, 1]}, {node: [0, "
                      "2]}, {node: [1, 2]}, "
                      "{node: [2, 2]}]\n"));
  run.seconds(1);
  for (const Id id : {0, 1, 2, 3, 5, 6, 7, 8}) EXPECT_EQ(run.position(id).z(), 0);
  EXPECT_GT(run.position(4).z(), 0.01);
}

}  // namespace unibody::small_worlds::pressure_test
