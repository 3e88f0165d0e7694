// Triangles that resist a change of their area, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/cloth_shape.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::area_test {

namespace {

constexpr double h = 0.016;  // s
const std::string solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

using Triangle = std::array<Vec3, 3>;

double area(const Triangle& x) { return 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm(); }
Triangle places(const Experiment& run) { return {run.position(0), run.position(1), run.position(2)}; }

// Three free particles at `start` and nothing but the area of the triangle `rest`, without gravity.
Scene free_triangle(const std::string& solver, const Triangle& start, const Triangle& rest, const Spring& law,
                    const std::array<double, 3>& mass) {
  Scene scene = scene_with(0);
  scene.gravity = Vec3::Zero(), scene.time.frame = h;
  scene.solver.name = solver, scene.solver.iterations = 100, scene.solver.tolerance = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    Body node;
    node.properties.shape = {ShapeKind::particle, Vec3(0.001, 0, 0)};
    node.properties.mass = mass[k], node.properties.inertia = Vec3::Zero();
    node.state.position = start[k];
    add(scene, node);
  }
  Constraint<Area> c = area_at_rest(law, rest[0], rest[1], rest[2]);
  c.ids = {0, 1, 2};
  scene.constraint_groups.push_back({0, 3, [c](Id, ConstraintSet& out) { std::get<ConstraintList<Area>>(out).push_back(c); }});
  return scene;
}

Triangle equilateral(double radius) {
  Triangle x;
  for (int k = 0; k < 3; ++k)
    x[static_cast<std::size_t>(k)] = radius * Vec3(std::cos(k * 2 * M_PI / 3), std::sin(k * 2 * M_PI / 3), 0);
  return x;
}

}  // namespace

// An equilateral triangle of circumradius r, whose corners have the mass m, breathes with omega^2 = sqrt 3 k / m, since
// A = 3/4 sqrt 3 r^2; implicit Euler takes force and damping at the end of the step. To the first order in the amplitude, the
// step being nonlinear.
TEST(Area, BreathingTriangleIsTheImplicitMap) {
  const double m = 0.7, k = 30, rho = 0.02, r0 = 0.5, amplitude = 1e-6 * r0, squared = std::sqrt(3.0) * k / m;
  for (const std::string& solver : solver_list) {
    double x = amplitude, v = 0;
    Experiment run(free_triangle(solver, equilateral(r0 + x), equilateral(r0), {k, rho}, {m, m, m}));
    for (int step = 0; step < 60; ++step) {
      v = (v - h * squared * x) / (1 + h * squared * (h + rho)), x += h * v;
      run.step();
      for (Id id = 0; id < 3; ++id) ASSERT_NEAR(run.position(id).norm() - r0, x, 1e-5 * amplitude) << solver << ", step " << step;
    }
    EXPECT_LT(std::abs(x), 0.5 * amplitude) << "it must have moved";
  }
}

// Without a stiffness a stretched triangle has its area after one step, whatever its shape and masses, and its centre of mass
// stays.
TEST(Area, StiffTriangleComesToItsArea) {
  const Triangle rest{Vec3(0.1, 0, 0.2), Vec3(1, 0.3, 0), Vec3(0.2, 0.9, 0.4)};
  const std::array<double, 3> mass{0.2, 1, 3};
  for (const std::string& solver : solver_list)
    for (const Vec3& factor : {Vec3(1.3, 0.9, 1.1), Vec3(0.7, 1.2, 0.9), Vec3(2, 1.5, 1)}) {
      Triangle start = rest;
      for (Vec3& x : start) x = x.cwiseProduct(factor);
      ASSERT_GT(std::abs(area(start) - area(rest)), 0.03);
      Experiment run(free_triangle(solver, start, rest, {}, mass));
      run.step();
      EXPECT_NEAR(area(places(run)), area(rest), 1e-12) << solver << ' ' << factor.transpose();
      EXPECT_LT(run.momentum().norm(), 1e-12 * std::sqrt(2 * 4.2 * run.kinetic_energy())) << solver;
    }
}

// A shear keeps the area and costs nothing: not a bit moves.
TEST(Area, ShearIsFree) {
  const Triangle rest{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, start{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.75, 1, 0)};
  for (const std::string& solver : solver_list)
    for (const Spring& law : {Spring{}, Spring{100, 0.01}}) {
      Experiment run(free_triangle(solver, start, rest, law, {1, 2, 1}));
      run.steps(3);
      for (Id id = 0; id < 3; ++id) EXPECT_EQ(run.position(id), start[static_cast<std::size_t>(id)]) << solver;
    }
}

// A mesh of one triangle hangs from two nodes b apart; the third, of mass m, was d below them and comes to rest where the area
// pulls with its weight: k (A - A0) / A0 dA/dy = k (y - d) / d b / 2 = m g. The links give nothing to speak of.
TEST(Area, HangingTriangleBearsItsLoad) {
  const double b = 0.8, d = 0.5, m = 1, g = 9.8;
  const TextFile obj("v -0.4 0 0\nv 0.4 0 0\nv 0 0 -0.5\nf 1 2 3\n");
  for (const std::string& solver : solver_list)
    for (const double k : {100.0, 300.0}) {
      Scene scene = scene_from("cloths:\n  - mesh: " + obj.path().substr(obj.path().rfind('/') + 1) +
                               "\n    mass: 3\n    thickness: 0.01\n    links: {stiffness: 1.0e-6}\n    area: {stiffness: " +
                               std::to_string(k) + ", damping: 0.3}\n    pins: [{node: 0}, {node: 1}]\ngravity: [0, 0, -9.8]\n");
      scene.solver.name = solver, scene.solver.iterations = 50, scene.solver.tolerance = 0;
      Experiment run(std::move(scene));
      run.seconds(12);
      EXPECT_NEAR(-run.position(2).z(), d + 2 * m * g * d / (k * b), 1e-6) << solver << ' ' << k;
    }
}

}  // namespace unibody::small_worlds::area_test
