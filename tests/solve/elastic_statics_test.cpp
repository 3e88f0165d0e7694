// Statics in closed form: uniform deformations of a distorted mesh, as nodal forces and as the equilibrium of one huge step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "solve/elastic_bench.hpp"
#include "solve/elastic_problem.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds::elastic_statics_test {

namespace {

using Eigen::Matrix3d;

constexpr double young = 1e5, poisson = 0.3;
constexpr double huge_step = 1e4;  // s

// A block of 3 x 2 x 2 cells, 0.6 m x 0.4 m x 0.5 m, with its inner nodes, and those of faces within their faces, out of place.
ElasticMesh distorted_block() {
  Experiment run(scene_from_text(
      block_text("[0.6, 0.4, 0.5]", "[3, 2, 2]", "density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3")));
  run.simulation->make_constraints();
  ElasticMesh mesh = mesh_of(run.simulation->ties.constraints, run.world().position, lame(young, poisson));
  const Vec3 half(0.3, 0.2, 0.25);
  samples::Random random(31);
  for (Vec3& x : mesh.rest) {
    const Vec3 shift = random.vector(-0.03, 0.03);
    for (int k = 0; k < 3; ++k)
      if (std::abs(std::abs(x[k]) - half[k]) > 1e-12) x[k] += shift[k];
  }
  return mesh;
}

// Of each node a third of the surface's triangles, as vectors out of the rest (m^2).
std::vector<Vec3> areas(const ElasticMesh& mesh) {
  std::map<std::array<Id, 3>, std::vector<std::array<Id, 3>>> faces;
  for (const auto& c : mesh.cells)
    for (const auto& f : {std::array{c[1], c[2], c[3]}, {c[0], c[3], c[2]}, {c[0], c[1], c[3]}, {c[0], c[2], c[1]}}) {
      auto key = f;
      std::sort(key.begin(), key.end());
      faces[key].push_back(f);
    }
  std::vector<Vec3> result(mesh.rest.size(), Vec3::Zero());
  for (const auto& [key, sides] : faces) {
    if (sides.size() != 1) continue;
    const auto at = [&, f = sides[0]](std::size_t k) { return mesh.rest[static_cast<std::size_t>(f[k])]; };
    const Vec3 share = (at(1) - at(0)).cross(at(2) - at(0)) / 6;
    for (const Id n : key) result[static_cast<std::size_t>(n)] += share;
  }
  return result;
}

World world_of(const std::vector<Vec3>& places) {
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < places.size(); ++i)
    bodies.push_back(samples::body(static_cast<Id>(i), ShapeKind::particle, Vec3(0.001, 0, 0), places[i]));
  return samples::world_of(bodies);
}

struct Uniform {
  const char* name;
  Matrix3d F, P;  // 1; Pa: nominal stress, in closed form
};

std::vector<Uniform> uniform_deformations() {
  const auto [la, mu] = lame(young, poisson);
  std::vector<Uniform> cases;
  const double l = 1.2, side = std::sqrt(1 - poisson * (l * l - 1));
  cases.push_back({"uniaxial", Vec3(l, side, side).asDiagonal(), Vec3(young / 2 * l * (l * l - 1), 0, 0).asDiagonal()});
  const double g = 0.3, across = (la / 2 + mu) * g * g;
  Uniform shear{"simple shear", Matrix3d::Identity(), Matrix3d::Zero()};
  shear.F(0, 1) = g;
  shear.P << across, mu * g + (la / 2 + mu) * g * g * g, 0, mu * g, across, 0, 0, 0, la / 2 * g * g;
  cases.push_back(shear);
  const double s = 0.9;
  cases.push_back({"hydrostatic", s * Matrix3d::Identity(), (3 * la + 2 * mu) / 2 * s * (s * s - 1) * Matrix3d::Identity()});
  const Matrix3d turn = Quat(Eigen::AngleAxisd(2, Vec3(1, -2, 0.5).normalized())).toRotationMatrix();
  cases.push_back({"uniaxial and turned", turn * cases[0].F, turn * cases[0].P});
  // P / E of F2, the third of them the least there is: pressed further the material is softer.
  for (const auto& [at, nominal] :
       {std::pair(0.5, -0.1875), {0.8, -0.144}, {1 / std::sqrt(3), -0.1924500897298753}, {1.5, 0.9375}, {2.0, 3.0}}) {
    const double narrow = std::sqrt(1 - poisson * (at * at - 1));
    cases.push_back(
        {"stretched or pressed far", Vec3(at, narrow, narrow).asDiagonal(), Vec3(nominal * young, 0, 0).asDiagonal()});
  }
  return cases;
}

std::vector<Vec3> deformed(const ElasticMesh& mesh, const Matrix3d& F) {
  std::vector<Vec3> x;
  for (const Vec3& X : mesh.rest) x.emplace_back(F * X);
  return x;
}

}  // namespace

// With unit masses and a step of 1 s the residual at rest is the force of the material on each node.
TEST(ElasticStatics, UniformStressActsOnTheSurfaceAlone) {
  const ElasticMesh mesh = distorted_block();
  const std::vector<Vec3> area = areas(mesh);
  const ConstraintSet set = constraints_of(mesh, young, poisson);
  int inner = 0;
  for (const Vec3& a : area) inner += a.norm() < 1e-15;
  EXPECT_EQ(inner, 2);
  for (const Uniform& of : uniform_deformations()) {
    const World world = world_of(deformed(mesh, of.F));
    const ElasticProblem problem(world, set, predict_bodies(world, Vec3::Zero(), 1), 1);
    const Eigen::VectorXd inwards = problem.residual(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.size())));
    for (std::size_t i = 0; i < area.size(); ++i)
      EXPECT_LT((inwards.segment<3>(3 * static_cast<Eigen::Index>(i)) - of.P * area[i]).norm(), 1e-10 * of.P.norm() * 0.04)
          << of.name << ' ' << i;
  }
}

// Held at the surface, or at three nodes under dead forces P A: from a start out of place one step gives the uniform deformation.
TEST(ElasticStatics, OneHugeStepGivesTheUniformEquilibrium) {
  const ElasticMesh mesh = distorted_block();
  const std::vector<Vec3> area = areas(mesh);
  const ConstraintSet set = constraints_of(mesh, young, poisson);
  for (const Uniform& of : uniform_deformations())
    for (const bool dead : {false, true}) {
      if (dead && of.P.trace() < 0) continue;  // a compressed block may turn away from dead forces
      const std::vector<Vec3> expected = deformed(mesh, of.F);
      World world = world_of(expected);
      samples::Random random(7);
      std::size_t held = 0;
      for (std::size_t i = 0; i < area.size(); ++i) {
        const Vec3 shift = random.vector(-0.02, 0.02);
        const bool hold = dead ? i == 0 || i == 3 || i == 8 : area[i].norm() > 1e-15;
        BodyProperties properties = world.properties[i];
        if (hold)
          properties.motion = Motion::pinned, ++held;
        else
          world.position[i] += shift, properties.force = dead ? Vec3(of.P * area[i]) : Vec3::Zero();
        world.properties.set(i, properties);
      }
      ASSERT_EQ(held, dead ? 3 : area.size() - 2);
      for (const LinearSolver linear : {LinearSolver::direct, LinearSolver::cg}) {
        if (linear == LinearSolver::cg && !dead) continue;  // two nodes that move have no six rigid motions for multigrid
        ReferenceSettings settings;
        settings.linear = linear;
        const ReferenceStep step = reference_step(world, set, Vec3::Zero(), huge_step, settings);
        EXPECT_TRUE(step.converged) << of.name << ": " << step.residual << " m/s, " << step.reason;
        for (std::size_t i = 0; i < area.size(); ++i)
          EXPECT_LT((world.position[i] + huge_step * step.velocity[i] - expected[i]).norm(), 1e-8) << of.name << ' ' << dead << i;
      }
    }
}

}  // namespace unibody::small_worlds::elastic_statics_test
