// The reference step with the impulses eliminated: against the full system, finite differences, and exact steps.
#include "solve/elastic_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/errors.hpp"
#include "scene/kuhn_mesh.hpp"
#include "scene/scene_text.hpp"
#include "solve/elastic_bench.hpp"
#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::elastic_problem_test {

namespace {

using samples::Random;

Body node(Id id, double mass, const Vec3& position, const Vec3& velocity = Vec3::Zero(), Motion motion = Motion::dynamic) {
  Body b = samples::body(id, ShapeKind::particle, Vec3(0.001, 0, 0), position, motion);
  b.properties.mass = mass;
  b.state.velocity = velocity;
  return b;
}

Scene held_block(const std::string& damping) {
  Scene scene =
      scene_from_text(block_text("[0.3, 0.2, 0.2]", "[3, 2, 2]",
                                 "density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3\n    damping: " + damping +
                                     "\n    pins: [{within: {min: [-0.15, -1, -1], max: [-0.15, 1, 1]}}]"));
  scene.time.frame = 0.008;
  return scene;
}

struct Case {
  const char* name;
  Scene scene;
};
std::vector<Case> elastic_cases() {
  constexpr ClothCase undamped{"springs without damping", "links: {stiffness: 2000}"};
  constexpr ClothCase sheet{"membrane without damping", "membrane: {youngs_modulus: 1.0e5, poissons_ratio: 0.3}"};
  std::vector<Case> cases;
  for (const ClothCase& of : {springs, undamped, membrane, sheet}) cases.push_back({of.name, cloth(of, 6, 0.008)});
  cases.push_back({"block", held_block("0")});
  cases.push_back({"damped block", held_block("0.02")});
  return cases;
}

double multiplier_difference(const ConstraintMultipliers& a, const ConstraintMultipliers& b, double& size) {
  double worst = 0;
  for_each_type(a, [&](auto type, const auto& list) {
    const auto& other = std::get<type.value>(b);
    ASSERT_EQ(list.size(), other.size());
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t k = 0; k < list[i].size(); ++k)
        worst = std::max(worst, std::abs(list[i][k] - other[i][k])), size = std::max(size, std::abs(list[i][k]));
  });
  return worst;
}

}  // namespace

TEST(ElasticProblem, IsTheFullSystemWithoutItsImpulses) {
  for (Case& of : elastic_cases()) {
    Experiment run(std::move(of.scene));
    run.simulation->detect();
    shake(run.world(), 0.5, 2e-3, 5);
    const ConstraintSet& set = run.simulation->ties.constraints;
    for (const LinearSolver linear : {LinearSolver::direct, LinearSolver::cg}) {
      ReferenceSettings settings;
      settings.linear = linear;
      const ReferenceProblem full(run.world(), set, run.scene->gravity, run.h());
      const NewtonResult expected = newton(full);
      const ReferenceStep step = reference_step(run.world(), set, run.scene->gravity, run.h(), settings);
      ASSERT_TRUE(expected.converged) << of.name << ": " << expected.reason;
      EXPECT_TRUE(step.converged) << of.name << ": " << step.residual << " m/s, " << step.reason;
      const auto velocity = full.velocity(expected.unknowns);
      EXPECT_LT(largest_difference(step.velocity, velocity), 1e-10 * largest(velocity)) << of.name;
      EXPECT_LT(step.correction, 1e-10 * largest(velocity)) << of.name;
      double size = 0;
      const double gap = multiplier_difference(full.multipliers(expected.unknowns), step.multipliers, size);
      EXPECT_LT(gap, 1e-10 * size) << of.name;
    }
  }
}

// All elastic types at once, damped, between bodies of which one is fixed.
TEST(ElasticProblem, JacobianIsTheDerivativeOfTheResidual) {
  for (int trial = 0; trial < 20; ++trial) {
    Random random(static_cast<std::uint64_t>(300 + trial));
    std::vector<Body> bodies;
    for (int i = 0; i < 6; ++i)
      bodies.push_back(node(i, random(0.5, 2), Vec3(std::cos(2.0 * i), std::sin(2.0 * i), 0.3 * i) + random.vector(-.3, .3),
                            random.vector(-1, 1), i == 2 ? Motion::fixed : Motion::dynamic));
    ConstraintSet set;
    const bool damped = trial % 2;
    for_each_type(set, [&]<class C>(auto, ConstraintList<C>& list) {
      for (int first = 0; first < 3 && !is_unilateral<C>; ++first) {
        Constraint<C>& c = list.emplace_back();
        for (std::size_t e = 0; e < C::stencil; ++e) c.ids[e] = first + static_cast<Id>(e);
        for (double& p : c.parameters) p = random(0.5, 1.5);
        for (double& e : c.compliance) e = random(0.01, 0.1);
        c.damping = damped && first != 2 ? random(0, 0.2) : 0;
      }
    });
    const World world = samples::world_of(bodies);
    const ElasticProblem problem(world, set, predict_bodies(world, Vec3(0, 0, -9.81), 0.1), 0.1);
    Eigen::VectorXd u = problem.start();
    for (double& entry : u) entry += random(-1, 1);

    std::vector<PetscInt> rows, columns;
    std::vector<double> values;
    problem.pattern(rows, columns);
    problem.jacobian(u, values);
    ASSERT_EQ(values.size(), rows.size());
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(u.size(), u.size());
    for (std::size_t i = 0; i < values.size(); ++i) J(rows[i], columns[i]) += values[i];
    EXPECT_EQ(problem.is_symmetric(), !damped);
    const double asymmetry = (J - J.transpose()).lpNorm<Eigen::Infinity>();
    EXPECT_EQ(asymmetry < 1e-11 * J.lpNorm<Eigen::Infinity>(), !damped) << asymmetry;
    constexpr double d = 1e-5;
    for (Eigen::Index j = 0; j < u.size(); ++j) {
      Eigen::VectorXd up = u, down = u;
      up[j] += d, down[j] -= d;
      const Eigen::VectorXd slope = (problem.residual(up) - problem.residual(down)) / (2 * d);
      ASSERT_LT((J.col(j) - slope).lpNorm<Eigen::Infinity>(), 1e-7 * (1 + slope.lpNorm<Eigen::Infinity>()))
          << "trial " << trial << ", unknown " << j;
    }
  }
}

// Against differences of the gradients, which are linear in the places.
TEST(ElasticProblem, SecondDerivativesOfATetrahedronAreThoseOfItsGradients) {
  Random random(17);
  Constraint<Tetrahedron> c;
  c.parameters = Tetrahedron::at_rest(Vec3(0, 0, 0.1), Vec3(1, 0.2, 0), Vec3(0.1, 0.7, 0), Vec3(0.2, -0.1, 1.3));
  using At = Local<Tetrahedron>;
  At::Place x, y;
  for (double& entry : x) entry = random(-1, 1);
  for (double& entry : y) entry = random(-1, 1);
  const auto at = At::evaluate(c, {x, y, x, y});
  const At::Gradient change = At::gradient(at, 1) - At::gradient(at, 0);
  const auto H = At::second_derivatives(c, x);
  for (int k = 0; k < 6; ++k)
    EXPECT_LT((H[static_cast<std::size_t>(k)] * (y - x) - change.col(k)).lpNorm<Eigen::Infinity>(), 1e-12);
}

// Of implicit Euler with the consistent tangent, computed by an independent code.
TEST(ElasticProblem, OneTetrahedronIsTheExactStep) {
  const Vec3 stretch(1.3, 0.9, 1);
  ElasticMesh mesh{{{0, 1, 2, 3}}, {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}, {}};
  const std::vector<Vec3> v{Vec3::Zero(), Vec3(0, 2, 0), Vec3(0, 0, 1), Vec3(-3, 0, 0)};
  std::vector<Body> bodies;
  for (int i = 0; i < 4; ++i) bodies.push_back(node(i, 0.25, stretch.cwiseProduct(mesh.rest[i]), v[i]));
  const World world = samples::world_of(bodies);
  const ReferenceStep step = reference_step(world, constraints_of(mesh, 1e4, 0.3), Vec3(0, 0, -9.8), 0.016);
  const Vec3 expected[] = {{.08525434575660, -.02293222799951, -.006418645220846},
                           {1.157823498691, .03714567900670, .03077268643718},
                           {.01312984484611, .9298246658866, -.0005376108951537},
                           {-.004207689293789, -.01203811689383, .9821483696788}};
  EXPECT_TRUE(step.converged) << step.reason;
  for (int i = 0; i < 4; ++i)
    EXPECT_LT((world.position[i] + 0.016 * step.velocity[i] - expected[i]).lpNorm<Eigen::Infinity>(), 1e-10) << i;
}

TEST(ElasticProblem, CantileverIsTheExactStep) {
  const TextFile mesh(kuhn_mesh(Vec3(1, 0.25, 0.25), {4, 1, 1}), ".msh");
  Experiment run(scene_from_text(
      "gravity: [0, 0, -9.8]\nsolver: {name: newton}\nsolids:\n  - mesh: " + mesh.path().substr(mesh.path().rfind('/') + 1) +
      "\n    thickness: 0.001\n    position: [0.5, 0.125, 0.125]\n    density: 1000\n"
      "    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3\n"
      "    pins: [{within: {min: [0, 0, 0], max: [0, 1, 1]}}]\n"));
  World& world = run.world();
  std::size_t tip = world.size();
  for (std::size_t i = 0; i < world.size(); ++i) {
    world.velocity[i] = Vec3(0, 0, -2 * world.position[i].x());
    if ((world.position[i] - Vec3::UnitX()).norm() < 1e-12) tip = i;
  }
  ASSERT_LT(tip, world.size());
  run.step();
  EXPECT_TRUE(run.last.converged);
  const Vec3 expected(.9987159036241, .0001134099133829, -.03273559506878);
  EXPECT_LT((world.position[tip] - expected).lpNorm<Eigen::Infinity>(), 1e-10) << world.position[tip].transpose();
}

TEST(ElasticProblem, UnilateralConstraintsAreRefused) {
  const World world = samples::world_of(
      {node(0, 1, Vec3::Zero()), node(1, 1, Vec3::UnitX()), node(2, 1, Vec3::UnitY()), node(3, 1, Vec3::UnitZ())});
  ConstraintSet set;
  Constraint<InversionGuard>& guard = std::get<ConstraintList<InversionGuard>>(set).emplace_back();
  guard.ids = {0, 1, 2, 3}, guard.parameters = {1, 0.1, 1};
  try {
    reference_step(world, set, Vec3::Zero(), 0.016);
    FAIL() << "taken";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("inversion_guard"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ElasticProblem(world, set, predict_bodies(world, Vec3::Zero(), 0.016), 0.016), RunError);
}

}  // namespace unibody::small_worlds::elastic_problem_test
