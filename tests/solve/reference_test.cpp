// The reference solver against closed forms and its own finite differences, and the iterative solvers against it.
#include <gtest/gtest.h>

#include <cmath>

#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::reference_test {

namespace {

using samples::Random;

Body particle(Id id, double mass, const Vec3& position, const Vec3& velocity, Motion motion = Motion::dynamic) {
  Body b = samples::body(id, ShapeKind::particle, Vec3(0.001, 0, 0), position, motion);
  b.properties.mass = mass;
  b.state.velocity = velocity;
  return b;
}

Constraint<Distance> link(Id a, Id b, double rest, double compliance = 0, double damping = 0) {
  Constraint<Distance> c;
  c.ids = {a, b}, c.parameters = {rest}, c.compliance = {compliance}, c.damping = damping;
  return c;
}

// N s; Distance is the list's first type
const MultiplierList<Distance>& of_links(const ConstraintMultipliers& all) { return std::get<0>(all); }

const char* const solvers[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};
int enough(const std::string& solver) { return solver == "jacobi" ? 20000 : 6000; }

// A cloth that has swung for some steps, so that its velocities belong to its constraints.
struct Swinging {
  Scene scene;
  Experiment run;
  World& world;
  const ConstraintSet& constraints;

  explicit Swinging(const ClothCase& of)
      : scene(cloth(of, 8, 0.008)), run(cloth(of, 8, 0.008)), world(run.world()), constraints(run.simulation->ties.constraints) {
    run.simulation->detect();
    shake(world, 0.3, 1e-3, 7);
    for (int k = 0; k < 12; ++k) {
      const ReferenceStep step = reference_step(world, constraints, scene.gravity, 0.004);
      EXPECT_TRUE(step.converged) << of.name << ": " << step.residual << " m/s, " << step.reason;
      advance(world, step, 0.004);
    }
  }
};

constexpr double spacing = 1.0 / 7;  // m, of the cloths' nodes

}  // namespace

// One step of a damped oscillator (v' = v - h/m k (x' - l + rho v'), x' = x + h v') and of a weight on a stiff link along it.
TEST(Reference, OneLinkIsTheClosedForm) {
  const double m = 2, k = 100, rho = 0.05, h = 0.01, g = 9.8, v = 0.3;
  for (const bool stiff : {false, true}) {
    const World world = samples::world_of(
        {particle(0, m, Vec3(0, 0, -1.1), Vec3(0, 0, -v)), particle(1, 1, Vec3::Zero(), Vec3::Zero(), Motion::fixed)});
    ConstraintSet set;
    std::get<ConstraintList<Distance>>(set).push_back(stiff ? link(1, 0, 1) : link(1, 0, 1, 1 / k, rho));
    const ReferenceStep step = reference_step(world, set, Vec3(0, 0, -g), h);
    const double expected = stiff ? -0.1 / h : (v + h * g - h / m * k * 0.1) / (1 + h / m * k * (h + rho));
    EXPECT_TRUE(step.converged) << step.reason;
    EXPECT_NEAR(-step.velocity[0].z(), expected, 1e-12 * std::abs(expected));
    EXPECT_EQ(step.velocity[1], Vec3(Vec3::Zero()));
    EXPECT_NEAR(of_links(step.multipliers)[0][0], m * (expected - v - h * g), 1e-12 * m * 10);
  }
}

// A chain of springs and stiff links along a line: the linear system, written out densely.
TEST(Reference, LinearChainIsTheDenseSolve) {
  constexpr int n = 8;
  const double h = 0.016;
  Random random(21);
  std::vector<Body> bodies;
  ConstraintSet set;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n - 1, 2 * n - 1);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * n - 1);
  for (int i = 0; i < n; ++i) {
    const double mass = std::pow(10, random(-1, 1));
    bodies.push_back(particle(i, mass, Vec3(3 * i + random(-.5, .5), 0, 0), Vec3(random(-1, 1), 0, 0)));
    A(i, i) = mass, b[i] = mass * bodies.back().state.velocity.x();
  }
  for (int i = 0; i + 1 < n; ++i) {
    const double compliance = i % 2 ? std::pow(10, -random(1, 4)) : 0, rho = i % 3 ? std::pow(10, random(-2, 0)) : 0;
    std::get<ConstraintList<Distance>>(set).push_back(link(i, i + 1, 3, compliance, rho));
    const int row = n + i;
    A(i, row) = 1, A(i + 1, row) = -1;  // M v - D lambda, D = (-1, 1)
    A(row, i) = -(h + rho), A(row, i + 1) = h + rho, A(row, row) = compliance / h;
    b[row] = -(bodies[i + 1].state.position.x() - bodies[i].state.position.x() - 3);
  }
  const Eigen::VectorXd exact = A.fullPivLu().solve(b);
  const ReferenceStep step = reference_step(samples::world_of(bodies), set, Vec3::Zero(), h);
  EXPECT_TRUE(step.converged) << step.reason;
  for (int i = 0; i < n; ++i) EXPECT_NEAR(step.velocity[i].x(), exact[i], 1e-11 * exact.head(n).lpNorm<Eigen::Infinity>());
  for (int i = 0; i + 1 < n; ++i)
    EXPECT_NEAR(of_links(step.multipliers)[i][0], exact[n + i], 1e-11 * exact.tail(n - 1).lpNorm<Eigen::Infinity>());
}

// Constraints of every type of the list, stiff, soft and damped, between bodies of which one is fixed: the assembled Jacobian
// against central differences of the residual.
TEST(Reference, JacobianIsTheDerivativeOfTheResidual) {
  for (int trial = 0; trial < 20; ++trial) {
    Random random(static_cast<std::uint64_t>(100 + trial));
    std::vector<Body> bodies;
    for (int i = 0; i < 6; ++i)
      bodies.push_back(particle(i, random(0.5, 2), Vec3(std::cos(2.0 * i), std::sin(2.0 * i), 0.3 * i) + random.vector(-.3, .3),
                                random.vector(-1, 1), i == 2 ? Motion::fixed : Motion::dynamic));
    ConstraintSet set;
    for_each_type(set, [&]<class C>(auto, ConstraintList<C>& list) {
      for (int first = 0; first < 3 && !is_unilateral<C>; ++first) {
        Constraint<C>& c = list.emplace_back();
        for (std::size_t e = 0; e < C::stencil; ++e) c.ids[e] = first + static_cast<Id>(e);
        for (double& p : c.parameters) p = random(0.5, 1.5);
        for (double& e : c.compliance) e = first == 1 ? 0 : random(0, 0.1);
        c.damping = first == 2 ? 0 : random(0, 0.2);
      }
    });
    const World world = samples::world_of(bodies);
    const ReferenceProblem problem(world, set, Vec3(0, 0, -9.81), 0.1);
    Eigen::VectorXd u = problem.start();
    for (double& entry : u) entry += random(-1, 1);

    std::vector<PetscInt> rows, columns;
    std::vector<double> values;
    problem.pattern(rows, columns);
    problem.jacobian(u, values);
    ASSERT_EQ(values.size(), rows.size());
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(u.size(), u.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      if (rows[i] >= 0 && columns[i] >= 0) J(rows[i], columns[i]) += values[i];
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

// Two equal stiff links make the system singular. A little softening solves it all the same: the exact velocities, the impulse
// shared between the two.
TEST(Reference, SofteningSolvesRedundantLinks) {
  const World world =
      samples::world_of({particle(0, 1, Vec3::Zero(), Vec3(0, 1, 0)), particle(1, 2, Vec3(1, 0, 0), Vec3::Zero())});
  ConstraintSet once, twice;
  std::get<ConstraintList<Distance>>(once) = {link(0, 1, 1)};
  std::get<ConstraintList<Distance>>(twice) = {link(0, 1, 1), link(0, 1, 1)};
  const ReferenceStep exact = reference_step(world, once, Vec3::Zero(), 0.016);
  ReferenceSettings settings;
  settings.softening = 1e-7;
  const ReferenceStep step = reference_step(world, twice, Vec3::Zero(), 0.016, settings);
  EXPECT_TRUE(step.converged) << step.reason;
  EXPECT_LT(largest_difference(step.velocity, exact.velocity), 1e-12);
  const auto &one = of_links(exact.multipliers), &two = of_links(step.multipliers);
  EXPECT_NEAR(two[0][0], 0.5 * one[0][0], 1e-10);
  EXPECT_NEAR(two[1][0], 0.5 * one[0][0], 1e-10);
}

// A straight stiff row between two bodies that do not move has no regular solution under its weight: said, not hidden.
TEST(Reference, SaysWhereItDoesNotConverge) {
  std::vector<Body> bodies;
  ConstraintSet set;
  for (int i = 0; i < 5; ++i) {
    bodies.push_back(particle(i, 1, Vec3(i, 0, 0), Vec3::Zero(), i % 4 ? Motion::dynamic : Motion::fixed));
    if (i > 0) std::get<ConstraintList<Distance>>(set).push_back(link(i - 1, i, 0.9));
  }
  const ReferenceStep step = reference_step(samples::world_of(bodies), set, Vec3(0, 0, -9.81), 0.016);
  EXPECT_FALSE(step.converged);
  EXPECT_GT(step.residual, 1e-3);
}

// Each change of an impulse is applied along the directions of its iteration: the sum differs from D lambda at the end of the
// step by how far the directions turn while the velocities change, h |v - v~| / L, and the velocities from implicit Euler's by h
// |v - v~|^2 / L, 1e-5 to 1e-4 m/s here. Steps end in the total form, and at the implicit Euler step.
TEST(Reference, IterativeSolversEndAtTheImplicitEulerStep) {
  for (const ClothCase& of : {stiff_links, springs, membrane})
    for (const std::string solver : solvers)
      for (const double warm : {0.0, 0.5}) {
        Scene scene = cloth(of, 8, 0.008);
        scene.solver.name = solver, scene.solver.warm_start = warm, scene.solver.iterations = enough(solver);
        Experiment run(std::move(scene));
        run.world() = Swinging(of).world;
        run.simulation->detect();
        run.step();
        run.simulation->detect();
        const World start = run.world();
        const ReferenceStep exact = reference_step(start, run.simulation->ties.constraints, run.scene->gravity, run.h());
        ASSERT_TRUE(exact.converged) << of.name << ": " << exact.reason;
        std::vector<Vec3> free;
        for (std::size_t i = 0; i < start.size(); ++i)
          free.push_back(start.velocity[i] + (start.properties[i].motion == Motion::dynamic ? run.h() : 0) * run.scene->gravity);
        run.step();
        const double change = largest_difference(exact.velocity, free);
        const double gap = largest_difference(run.world().velocity, exact.velocity);
        const double unit = run.h() * change * change / spacing;
        EXPECT_LT(run.last.residual, 1e-10) << of.name << ' ' << solver << ' ' << warm;
        EXPECT_GT(unit, 1e-5) << of.name;
        EXPECT_LT(gap, 1e-7 * unit) << of.name << ' ' << solver << ' ' << warm;
        EXPECT_LT(run.last.turning, 1e-10) << of.name << ' ' << solver << ' ' << warm;
      }
}

// -error_estimate of a step that the iterations leave unfinished, far from where the cloth was in the step before, is its
// distance from the implicit Euler step: also what the impulses miss by the turning of their directions is in it.
TEST(Reference, TheErrorEstimateIsTheDistanceFromTheImplicitEulerStep) {
  for (const ClothCase& of : {springs, membrane})
    for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
      Scene scene = cloth(of, 8, 0.008);
      scene.solver.name = solver, scene.solver.iterations = 40;
      Experiment run(std::move(scene));
      run.world() = Swinging(of).world;
      run.simulation->detect();
      const World start = run.world();
      const ReferenceStep exact = reference_step(start, run.simulation->ties.constraints, run.scene->gravity, run.h());
      ASSERT_TRUE(exact.converged) << of.name << ": " << exact.reason;
      StepRequest request;
      request.error = true;
      const StepReport step = run.simulation->step(request);
      double squares = 0, mass = 0;
      for (std::size_t i = 0; i < start.size(); ++i) {
        if (start.properties[i].motion != Motion::dynamic) continue;
        squares += start.properties[i].mass * (run.world().velocity[i] - exact.velocity[i]).squaredNorm();
        mass += start.properties[i].mass;
      }
      const double right = run.h() * std::sqrt(squares / mass);
      ASSERT_TRUE(step.error.has_value()) << of.name << ' ' << solver;
      EXPECT_GT(step.turning, 1e-7) << of.name << ' ' << solver;
      EXPECT_NEAR(step.error->distance, right, 1e-3 * right) << of.name << ' ' << solver;
    }
}

// That difference with the step: where forces are smooth v - v~ is of the order of h and the difference of h^3; where velocities
// jump, as after an impact, of h.
TEST(Reference, TheDifferenceVanishesWithTheStep) {
  const auto gap = [](const World& world, const ConstraintSet& set, const Vec3& gravity, double h) {
    const ReferenceStep exact = reference_step(world, set, gravity, h);
    EXPECT_TRUE(exact.converged) << exact.reason;
    IterativeStep step(world, set, gravity, h, "accelerated_jacobi");
    step.iterate(6000);
    EXPECT_LT(step.residual(), 1e-10);
    return largest_difference(step.velocity(), exact.velocity);
  };
  for (const ClothCase& of : {springs, membrane}) {
    const Swinging at(of);
    double before = gap(at.world, at.constraints, at.scene.gravity, 0.004);
    for (const double h : {0.002, 0.001}) {
      const double now = gap(at.world, at.constraints, at.scene.gravity, h);
      EXPECT_NEAR(std::log2(before / now), 3, 0.4) << of.name << ' ' << h;
      before = now;
    }
  }
  Swinging jumping(stiff_links);
  shake(jumping.world, 0.3, 0, 11);
  double before = gap(jumping.world, jumping.constraints, jumping.scene.gravity, 0.004);
  for (const double h : {0.002, 0.001}) {
    const double now = gap(jumping.world, jumping.constraints, jumping.scene.gravity, h);
    EXPECT_NEAR(std::log2(before / now), 1, 0.4) << h;
    before = now;
  }
}

// With v = v~ + W D lambda put anew now and then, at the present directions, the iterative solvers' fixed point is implicit
// Euler.
TEST(Reference, ReappliedImpulsesGiveTheExactStep) {
  const double h = 0.008;
  for (const ClothCase& of : {stiff_links, springs, membrane}) {
    const Swinging at(of);
    const ReferenceStep exact = reference_step(at.world, at.constraints, at.scene.gravity, h);
    for (const char* solver : solvers) {
      IterativeStep step(at.world, at.constraints, at.scene.gravity, h, solver);
      for (int pass = 0; pass < 12; ++pass) {
        step.iterate(enough(solver) / 12);
        step.reapply();
      }
      step.iterate(enough(solver) / 12);
      EXPECT_LT(step.residual(), 1e-12) << of.name << ' ' << solver;
      EXPECT_LT(largest_difference(step.velocity(), exact.velocity), 1e-8 * largest(exact.velocity)) << of.name << ' ' << solver;
    }
  }
}

// Under high tension for the mass, d = h^2 T / (m L) above about 1, the re-application itself diverges; with the share
// 1 / (1 + d) of each body it converges.
TEST(Reference, ReapplicationUnderHighTensionNeedsAShare) {
  const double h = 0.016;
  Swinging at(springs);
  for (int k = 0; k < 18; ++k) advance(at.world, reference_step(at.world, at.constraints, at.scene.gravity, 0.004), 0.004);
  const ReferenceStep exact = reference_step(at.world, at.constraints, at.scene.gravity, h);
  ASSERT_TRUE(exact.converged) << exact.reason;
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const bool shared : {false, true}) {
      IterativeStep step(at.world, at.constraints, at.scene.gravity, h, solver);
      double largest_feedback = 0;
      for (int pass = 0; pass < 80; ++pass) {
        step.iterate(50);
        std::vector<double> share = step.feedback();
        largest_feedback = std::max(largest_feedback, *std::max_element(share.begin(), share.end()));
        for (double& s : share) s = 1 / (1 + s);
        step.reapply(shared ? share : std::vector<double>{});
      }
      const double gap = largest_difference(step.velocity(), exact.velocity);
      EXPECT_GT(largest_feedback, 2);
      if (shared) {
        EXPECT_LT(gap, 1e-8 * largest(exact.velocity)) << solver;
      } else {
        EXPECT_FALSE(gap < 1) << solver;
      }
    }
}

}  // namespace unibody::small_worlds::reference_test
