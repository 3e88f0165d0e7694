// Springs, chains and cloths against closed forms and direct solves of the same implicit step.
#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::flexible_test {

namespace {

using unibody::samples::Random;

Body particle(double mass, const Vec3& position) {
  Body b;
  b.properties.shape = {ShapeKind::particle, Vec3(0.001, 0, 0)};
  b.properties.mass = mass;
  b.properties.inertia = Vec3::Zero();
  b.state.position = position;
  return b;
}

// Adds links between bodies of the scene.
void link(Scene& scene, std::vector<Constraint<Distance>> links) {
  scene.constraint_groups.push_back({0, scene.body_count(), [links](Id id, ConstraintSet& out) {
                                       for (const auto& c : links)
                                         if (c.ids[0] == id || c.ids[1] == id)
                                           std::get<ConstraintList<Distance>>(out).push_back(c);
                                     }});
}

Constraint<Distance> spring(Id a, Id b, double rest, double stiffness, double damping, int colour = 0) {
  Constraint<Distance> c;
  c.ids = {a, b}, c.parameters = {rest}, c.compliance = {stiffness > 0 ? 1 / stiffness : 0}, c.damping = damping;
  c.colour = colour;
  return c;
}

Scene weightless(const std::string& solver, int iterations, double step = 0.016) {
  Scene scene = scene_with(0);
  scene.gravity = Vec3::Zero();
  scene.solver.name = solver, scene.solver.iterations = iterations, scene.solver.tolerance = 0;
  scene.time.frame = step;
  return scene;
}

const std::string solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

}  // namespace

// A damped oscillator takes the exact implicit map, in one iteration or many: m 1 kg, k 100 N/m, rho 0.05 s, h 0.01 s.
TEST(Flexible, DampedOscillatorIsTheImplicitMap) {
  const double m = 1, k = 100, rho = 0.05, h = 0.01;
  double x = 1, v = 0;
  for (int step = 0; step < 100; ++step) {
    v = (v - h / m * k * x) / (1 + h / m * k * (h + rho));  // v' = v - h/m k (x' + rho v'), x' = x + h v'
    x += h * v;
  }
  ASSERT_NEAR(v, -0.0036023399291, 1e-12);  // a figure computed elsewhere
  for (const std::string& solver : solver_list)
    for (const int iterations : {1, 2, 10})
      for (const double warm : {0.0, 0.5}) {
        Scene scene = weightless(solver, iterations, h);
        scene.solver.warm_start = warm;
        Body anchor = particle(1, Vec3::Zero());
        anchor.properties.motion = Motion::fixed;
        add(scene, anchor);
        const Id bob = add(scene, particle(m, Vec3(0, 0, -6)));
        link(scene, {spring(0, bob, 5, k, rho)});
        Experiment run(scene);
        run.steps(100);
        EXPECT_NEAR(-run.position(bob).z() - 5, x, 1e-11) << solver << ' ' << iterations << ' ' << warm;
        EXPECT_NEAR(-run.velocity(bob).z(), v, 1e-10) << solver << ' ' << iterations << ' ' << warm;
      }
}

// Springs of very different damping and stiffness along a line: every solver converges to the direct solve of the linear step
// (M + sum h (h + rho) k n n^T) v' = M v - h sum k c n. Rows scaled by 1 / (h + rho) make the dual matrix symmetric; unscaled it
// is not.
TEST(Flexible, MixedDampingConvergesToTheDirectSolve) {
  constexpr int n = 8;
  const double h = 0.016;
  Random random(21);
  std::vector<double> mass(n), place(n), speed(n);
  std::vector<Constraint<Distance>> links;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b(n);
  for (int i = 0; i < n; ++i)
    mass[i] = std::pow(10, random(-1, 1)), place[i] = 3.0 * i + random(-.5, .5), speed[i] = random(-1, 1);
  for (int i = 0; i < n; ++i) A(i, i) = mass[i], b[i] = mass[i] * speed[i];
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n, n - 1), softness = Eigen::MatrixXd::Zero(n - 1, n - 1);
  Eigen::VectorXd rho(n - 1);
  for (int i = 0; i + 1 < n; ++i) {
    const double k = std::pow(10, random(1, 4));
    rho[i] = i % 3 == 0 ? 0 : std::pow(10, random(-2, 0));
    const double rest = 3, c = place[i + 1] - place[i] - rest;
    links.push_back(spring(i, i + 1, rest, k, rho[i], i % 2));
    Eigen::VectorXd d = Eigen::VectorXd::Zero(n);
    d[i] = -1, d[i + 1] = 1;
    A += h * (h + rho[i]) * k * d * d.transpose();
    b -= h * k * c * d;
    D.col(i) = d, softness(i, i) = 1 / k;
  }
  const Eigen::VectorXd exact = A.ldlt().solve(b);

  const Eigen::MatrixXd W = Eigen::Map<Eigen::VectorXd>(mass.data(), n).cwiseInverse().asDiagonal();
  const Eigen::VectorXd hs = Eigen::VectorXd::Constant(n - 1, h);
  const Eigen::MatrixXd N = (h * (hs + rho)).asDiagonal() * (D.transpose() * W * D) + softness;
  const Eigen::MatrixXd scaled = (h * (hs + rho).cwiseInverse()).asDiagonal() * N;
  EXPECT_GT((N - N.transpose()).norm(), 1e-3 * N.norm());
  EXPECT_LT((scaled - scaled.transpose()).norm(), 1e-15 * scaled.norm());

  for (const std::string& solver : solver_list) {
    Scene scene = weightless(solver, solver == "jacobi" ? 40000 : 4000, h);
    for (int i = 0; i < n; ++i) {
      Body node = particle(mass[i], Vec3(place[i], 0, 0));
      node.state.velocity.x() = speed[i];
      add(scene, node);
    }
    link(scene, links);
    Experiment run(scene);
    run.step();
    for (int i = 0; i < n; ++i) EXPECT_NEAR(run.velocity(i).x(), exact[i], 1e-10) << solver << ", mass " << i;
    EXPECT_LT(run.last.residual, 1e-11);
  }
}

// A spring that carries a weight: stretch m g / k, whatever the solver, its iterations and the step.
TEST(Flexible, StretchOfALoadedSpring) {
  for (const std::string& solver : solver_list)
    for (const auto& [h, iterations] : {std::pair(0.004, 3), std::pair(0.016, 1), std::pair(0.016, 3), std::pair(0.016, 50)}) {
      Scene scene = weightless(solver, iterations, h);
      scene.gravity = Vec3(0, 0, -9.8);
      Body anchor = particle(1, Vec3::Zero());
      anchor.properties.motion = Motion::fixed;
      add(scene, anchor);
      const Id bob = add(scene, particle(2, Vec3(0, 0, -1)));
      link(scene, {spring(0, bob, 1, 500, 0.3)});
      Experiment run(scene);
      run.seconds(12);
      EXPECT_NEAR(-run.position(bob).z() - 1, 2 * 9.8 / 500, 1e-6 * 0.04) << solver << ' ' << h << ' ' << iterations;
    }
}

const std::string free_cloth = R"(
cloths:
  - grid: {size: [1, 1], nodes: [9, 9]}
    mass: 2
    thickness: 0.01
    MODEL
    position: [0.3, -0.2, 0.1]
gravity: [0, 0, 0]
solver: {name: SOLVER, iterations: 12}
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

const std::string models[] = {
    "links: {}", "links: {stiffness: 2000, damping: 0.02}",
    "membrane: {youngs_modulus: 1.0e5, poissons_ratio: 0.3, damping: 0.01}\n    bending: {model: dihedral, stiffness: 0.01}"};

// A shaking cloth without support: its momentum stays. Its angular momentum changes by what implicit Euler takes from a turning
// link, -h^2 sum v_rel x f: second order in the step.
TEST(Flexible, MomentumOfAFreeCloth) {
  for (const std::string& model : models)
    for (const std::string& solver : solver_list) {
      Experiment run(scene_from_text(replaced(replaced(free_cloth, "MODEL", model), "SOLVER", solver)));
      Random random(31);
      World& world = run.world();
      for (std::size_t i = 0; i < world.homes; ++i)
        world.velocity[i] = random.vector(-.5, .5) + Vec3(0, 0, 1).cross(world.position[i]);
      const Vec3 p = run.momentum();
      Vec3 L = run.angular_momentum();
      const double size = 2.0;
      const double start = run.kinetic_energy();
      for (int k = 0; k < 60; ++k) {
        run.step();
        ASSERT_LT((run.momentum() - p).norm(), 1e-12 * size) << model << ' ' << solver;
        ASSERT_LT((run.angular_momentum() - L).norm(), 5e-2 * L.norm()) << model << ' ' << solver << ' ' << k;
        L = run.angular_momentum();
      }
      EXPECT_LT(run.kinetic_energy(), start) << model << ' ' << solver;
      EXPECT_TRUE(run.finite());
    }
}

// Pinned nodes stay where they are until they are released.
TEST(Flexible, PinsHoldAndLetGo) {
  const std::string text = R"(
cloths:
  - grid: {size: [1, 1], nodes: [5, 5]}
    mass: 1
    thickness: 0.01
    velocity: [0.1, 0, 0]
    pins: [{node: [0, 0]}, {node: [4, 0], release: 0.16}]
)";
  Experiment run(scene_from_text(text));
  const Vec3 first = run.position(0), second = run.position(4);
  run.steps(10);
  EXPECT_EQ(run.position(0), first);
  EXPECT_EQ(run.position(4), second);
  run.steps(10);
  EXPECT_EQ(run.position(0), first);
  EXPECT_LT(run.position(4).z(), second.z() - 1e-3);
}

// A grain on a cloth is held by its nodes; the cloth is not drawn through the floor either.
TEST(Flexible, ParticlesTouchBodies) {
  const std::string text = R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - shape: {sphere: {radius: 0.4}}
    mass: 5
    position: [0, 0, 0.4]
cloths:
  - grid: {size: [1.5, 1.5], nodes: [31, 31]}
    mass: 0.5
    thickness: 0.02
    position: [0, 0, 1]
solver: {iterations: 200}
)";
  Experiment run(scene_from_text(text));
  run.seconds(2);
  const World& world = run.world();
  double lowest = 1, nearest = 1, highest = 0;
  for (std::size_t i = 1; i < world.homes; ++i) {
    lowest = std::min(lowest, world.position[i].z());
    highest = std::max(highest, world.position[i].z());
    nearest = std::min(nearest, (world.position[i] - run.position(1)).norm());
  }
  EXPECT_GT(lowest, 0.01 - 0.002);
  EXPECT_GT(nearest, 0.41 - 0.002);
  EXPECT_GT(highest, 0.75);
}

}  // namespace unibody::small_worlds::flexible_test
