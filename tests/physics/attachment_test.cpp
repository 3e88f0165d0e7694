// Nodes pinned to bodies: those that follow a prescribed motion, and those that dynamic bodies hang on.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::attachment_test {

namespace {

const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

// Where a body's point is that was at `start` when the body was in state `first`.
Vec3 point_of(const BodyState& first, const BodyState& now, const Vec3& start) {
  return now.position + now.orientation * (first.orientation.conjugate() * (start - first.position));
}

// A flag on a box that moves and turns about no axis of its own.
std::string flag(const std::string& solver, const std::string& more = "") {
  return R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
    position: [0, 0, -9]
  - name: pole
    shape: {box: {size: [0.1, 0.2, 2]}}
    motion: kinematic
    orientation: {axis: [0.6, 0, 0.8], angle: 20}
    velocity: [1, -0.5, 0.25]
    angular_velocity: [1, 2, 3]
cloths:
  - grid: {size: [0.8, 0.6], nodes: [5, 4]}
    mass: 0.2
    thickness: 0.02
    position: [0.5, 0, 0.5]
    pins: [{node: [0, 0], to: pole)" +
         more + R"(}, {node: [0, 3], to: 1)" + more + R"(}]
solver: {iterations: 20, name: )" +
         solver + "}\n";
}

// A ball of 1 kg below a thread of so many segments, pinned at its upper end and tied to the ball's top.
std::string pendulum(double thread_mass, int segments, const std::string& more = "") {
  return R"(
bodies:
  - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, -1.1]}
threads:
  - points: [[0, 0, 0], [0, 0, -1]]
    segments: )" +
         std::to_string(segments) + "\n    radius: 0.001\n    mass: " + std::to_string(thread_mass) +
         "\n    pins: [{node: 0}, {node: " + std::to_string(segments) + ", to: bob" + more + "}]\n";
}

}  // namespace

TEST(Attachment, NodesFollowAKinematicBody) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(flag(solver)));
    const BodyState pole = run.state(1);
    const Id nodes[] = {2, 17};
    const Vec3 start[] = {run.position(2), run.position(17)};
    for (int k = 0; k < 200; ++k) {
      run.step();
      for (int i = 0; i < 2; ++i)
        ASSERT_LT((run.position(nodes[i]) - point_of(pole, run.state(1), start[i])).norm(), 1e-12) << solver << ' ' << k;
    }
    EXPECT_GT((run.position(2) - start[0]).norm(), 3);
    EXPECT_LT((run.position(3) - run.position(2)).norm(), 0.5) << "the cloth came along";
  }
}

// However far from converged: what a pin's multiplier says is what its body was given in the step. Gauss-Seidel extrapolates
// velocities and multipliers from sweep to sweep, and both by the same share.
TEST(Attachment, ItsMultiplierIsTheImpulseThatItGave) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(pendulum(0.3, 6) + "solver: {iterations: 9, name: " + solver + "}\n"));
    for (int k = 0; k < 40; ++k) {
      const Vec3 before = run.velocity(0);
      run.step();
      const auto& history = run.simulation->history.of<AttachmentBatch>();
      ASSERT_EQ(history.size(), 1U);
      const Vec3 given = run.velocity(0) - before - run.h() * run.scene->gravity,
                 told(history[0][0], history[0][1], history[0][2]);
      EXPECT_NEAR(given.norm(), told.norm(), 1e-12) << solver << ' ' << k;
    }
  }
}

// The link sees the held node's velocity: in one step the free node has it too.
TEST(Attachment, ConstraintsSeeThePrescribedVelocity) {
  for (const char* solver : solver_list) {
    Scene scene = scene_from_text(R"(
gravity: [0, 0, 0]
bodies:
  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: kinematic, velocity: [0.7, 0, 0]}
threads:
  - {points: [[0.1, 0, 0], [1, 0, 0]], segments: 1, radius: 0.01, mass: 1, pins: [{node: 0, to: 0}]}
)");
    scene.solver.name = solver, scene.solver.tolerance = 0, scene.solver.warm_start = 0;
    Experiment run(std::move(scene));
    run.step();
    EXPECT_NEAR(run.velocity(2).x(), 0.7, 1e-12) << solver;
    EXPECT_NEAR(run.position(2).x(), 1 + 0.7 * run.h(), 1e-13) << solver;
  }
}

// Let go, a node goes on with the velocity of its last step; the thread is next to no thread.
TEST(Attachment, AReleasedNodeKeepsItsVelocity) {
  Experiment run(scene_from_text(R"(
gravity: [0, 0, 0]
bodies:
  - {name: wheel, shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: kinematic, velocity: [0.7, 0, 0], angular_velocity: [0, 0, 2]}
threads:
  - points: [[0.3, 0, 0], [0.3, 1, 0]]
    segments: 1
    radius: 0.01
    mass: 1
    stretch: {stiffness: 1.0e-12}
    pins: [{node: 0, to: wheel, release: 0.3}]
)"));
  const BodyState wheel = run.state(0);
  const Vec3 start = run.position(1);
  const int steps = static_cast<int>(std::ceil(0.3 / run.h()));
  run.steps(steps - 1);
  const Vec3 before = run.position(1);
  run.step();
  const Vec3 at = run.position(1), velocity = (at - before) / run.h();
  EXPECT_LT((at - point_of(wheel, run.state(0), start)).norm(), 1e-12);
  EXPECT_NEAR((velocity - Vec3(0.7, 0, 0)).norm(), 2 * 0.3, 1e-3);
  run.steps(10);
  EXPECT_LT((run.position(1) - at - 10 * run.h() * velocity).norm(), 1e-11);
}

TEST(Attachment, AFixedBodyHoldsStill) {
  Experiment run(scene_from_text(R"(
bodies:
  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: fixed, position: [0, 0, 1], orientation: {axis: [0, 1, 0], angle: 33}}
threads:
  - {points: [[0, 0, 0.9], [0.5, 0, 0.9]], segments: 5, radius: 0.01, mass: 1, pins: [{node: 0, to: 0}]}
)"));
  run.seconds(1);
  EXPECT_EQ(run.position(1), Vec3(0, 0, 0.9));
  EXPECT_LT(run.position(6).z(), 0.8);
}

// From the first step on the upper link bears the weight of all below it, and nothing moves.
TEST(Attachment, AThreadBearsAHangingBall) {
  for (const char* solver : solver_list) {
    Scene scene = scene_from_text(pendulum(0.5, 4));
    scene.solver.name = solver, scene.solver.iterations = 6000, scene.solver.tolerance = 0;
    Experiment run(std::move(scene));
    run.steps(5);
    const auto& links = std::get<ConstraintList<Distance>>(run.simulation->ties.constraints);
    const auto& impulses = run.simulation->history.of<ConstraintBatch<Distance>>();
    ASSERT_EQ(links.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      const double below = 1 + 0.125 * (3.5 - static_cast<double>(k));
      EXPECT_NEAR(-impulses[k][0] / run.h(), below * 9.81, 1e-6) << solver << ", link " << k;
    }
    EXPECT_LT((run.position(0) - Vec3(0, 0, -1.1)).norm(), 1e-8) << solver;
    EXPECT_LT(run.last.residual_of<AttachmentBatch>(), 1e-9) << solver;
  }
}

// Three ties share the mass of one body, which is light against what they tie it to: each bears a third of it.
TEST(Attachment, ThreeThreadsShareABall) {
  for (const char* solver : solver_list) {
    std::string text = "bodies:\n  - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 1}\nthreads:\n";
    for (const double angle : {0.1, 0.1 + 2 * M_PI / 3, 0.1 + 4 * M_PI / 3}) {
      const std::string x = std::to_string(0.1 * std::cos(angle)), y = std::to_string(0.1 * std::sin(angle));
      text += "  - {points: [[" + x + ", " + y + ", 1], [" + x + ", " + y +
              ", 0]], segments: 1, radius: 0.001, mass: 20, pins: [{node: 0}, {node: 1, to: bob}]}\n";
    }
    Scene scene = scene_from_text(text);
    scene.solver.name = solver, scene.solver.iterations = 3000, scene.solver.tolerance = 0;
    Experiment run(std::move(scene));
    run.steps(3);
    for (const auto& impulse : run.simulation->history.of<ConstraintBatch<Distance>>())
      EXPECT_NEAR(-impulse[0] / run.h(), (10 + 1.0 / 3) * 9.81, 1e-3) << solver;
    EXPECT_LT(run.position(0).norm(), 1e-7) << solver;
  }
}

// Thread and ball are a double pendulum: the slower of its two small oscillations, from the closed form of two coordinates,
// theta of the thread, phi of the ball about its top. Implicit Euler lowers the frequency by a part of (omega h)^2 / 3.
TEST(Attachment, PendulumHasItsPeriod) {
  const double l = 1, r = 0.1, M = 1, m = 0.1, g = 9.81, I = 0.4 * M * r * r, h = 0.004;
  const double a = (M + m) * l * l, b = M * l * r, c = M * r * r + I, p = (M + m) * g * l, q = M * g * r;
  // (a c - b^2) w^4 - (a q + c p) w^2 + p q = 0
  const double A = a * c - b * b, B = a * q + c * p, squared = (B - std::sqrt(B * B - 4 * A * p * q)) / (2 * A);
  const double ratio = (p - squared * a) / (squared * b);  // phi / theta in that mode
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Scene scene = scene_from_text(pendulum(0.2, 1));
    scene.time.frame = h, scene.solver.name = solver, scene.solver.iterations = 400, scene.solver.tolerance = 1e-12;
    Experiment run(std::move(scene));
    const Id bob = 0, end = 2;
    const double theta = 0.01;
    World& world = run.world();
    world.position[run.slot(end)] = l * Vec3(std::sin(theta), 0, -std::cos(theta));
    world.position[run.slot(bob)] = run.position(end) + r * Vec3(std::sin(ratio * theta), 0, -std::cos(ratio * theta));
    world.orientation[run.slot(bob)] = Quat(Eigen::AngleAxisd(-ratio * theta, Vec3::UnitY()));
    std::vector<double> crossings;
    double before = run.position(bob).x();
    for (int k = 1; crossings.size() < 4; ++k) {
      ASSERT_LT(k, 3000);
      run.step();
      const double now = run.position(bob).x();
      if ((before > 0) != (now > 0)) crossings.push_back((k - now / (now - before)) * h);
      before = now;
    }
    const double omega = 2 * M_PI / (crossings[2] - crossings[0]);
    EXPECT_NEAR(omega / std::sqrt(squared), 1 - squared * h * h / 3, 1e-5) << solver;
    EXPECT_GT(std::abs(ratio - 1), 0.005) << "the ball turns against the thread";
  }
}

TEST(Attachment, AReleasedBallFalls) {
  Scene scene = scene_from_text(pendulum(0.5, 4, ", release: 0.16"));
  scene.solver.iterations = 2000;
  Experiment run(std::move(scene));
  run.steps(10);
  EXPECT_NEAR(run.position(0).z(), -1.1, 1e-4);
  const double z = run.position(0).z(), v = run.velocity(0).z();
  run.steps(10);
  EXPECT_NEAR(run.velocity(0).z() - v, -10 * run.h() * 9.81, 1e-12);
  EXPECT_NEAR(run.position(0).z() - z - 10 * run.h() * v, -55 * run.h() * run.h() * 9.81, 1e-12);
}

namespace {

// A spinning ball, off whose centre a node is tied, next to free of the other one.
struct Pair {
  double loss, gap, turned;  // of angular momentum, relative; m, the largest; m, h^2 / 2 |w x (w x arm)|
};
Pair spin(double h) {
  Scene scene = scene_from_text(R"(
gravity: [0, 0, 0]
bodies:
  - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 1, angular_velocity: [1, 2, 3], velocity: [0.1, 0.2, 0.3]}
threads:
  - points: [[0.2, 0, 0.1], [9, 0, 0]]
    segments: 1
    radius: 0.01
    mass: 1
    velocity: [0.1, 0.2, 0.3]
    stretch: {stiffness: 1.0e-12}
    pins: [{node: 0, to: bob}]
)");
  scene.time.frame = h, scene.solver.iterations = 200, scene.solver.tolerance = 0;
  Experiment run(std::move(scene));
  const BodyState bob = run.state(0);
  const Vec3 start = run.position(1);
  run.step();
  const Vec3 L = run.angular_momentum();
  Pair result{0, 0, 0};
  for (int k = 1; k < static_cast<int>(0.64 / h + 0.5); ++k) {
    run.step();
    result.loss = std::max(result.loss, (run.angular_momentum() - L).norm() / L.norm());
    result.gap = std::max(result.gap, (run.position(1) - point_of(bob, run.state(0), start)).norm());
  }
  const Vec3 w = run.state(0).angular_velocity, arm = run.position(1) - run.position(0);
  result.turned = 0.5 * h * h * w.cross(w.cross(arm)).norm();
  return result;
}

// A ball on a corner of a cloth, both in motion, in weightlessness: losses of momentum and of angular momentum, relative.
std::pair<double, double> tumble(const char* solver, double h) {
  Scene scene = scene_from_text(R"(
gravity: [0, 0, 0]
bodies:
  - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.6, 0.5, 0], velocity: [0, 0.4, 1], angular_velocity: [0, 2, 1]}
cloths:
  - grid: {size: [1, 1], nodes: [5, 5]}
    mass: 1
    thickness: 0.01
    links: {stiffness: 200}
    velocity: [0.2, 0, 0.1]
    pins: [{node: [4, 4], to: bob}]
)");
  scene.time.frame = h, scene.solver.name = solver, scene.solver.iterations = 100, scene.solver.tolerance = 0;
  Experiment run(std::move(scene));
  const Vec3 p = run.momentum(), L = run.angular_momentum();
  run.seconds(0.4);
  EXPECT_LT(run.position(25).z(), 0.4) << "the cloth holds the ball back";
  return {(run.momentum() - p).norm() / p.norm(), (run.angular_momentum() - L).norm() / L.norm()};
}

}  // namespace

// Both ends are pushed at one place: angular momentum stays to round-off where nothing else acts. The node, which is as heavy as
// its ball, strays from its point by what the step changes of the ball's turn, which is of third order: less than a fifth of how
// far a point's circle is off its tangent.
TEST(Attachment, KeepsAngularMomentumByItself) {
  const Pair coarse = spin(0.016), fine = spin(0.008);
  EXPECT_LT(coarse.loss, 1e-12);
  EXPECT_LT(fine.loss, 1e-12);
  EXPECT_LT(coarse.gap, 0.2 * coarse.turned);
  EXPECT_NEAR(std::log2(coarse.gap / fine.gap), 3, 0.01);
}

// A thread on a heavy wheel that turns freely at 0.13 rad a step: its node is on the wheel's point to a ten-thousandth of the
// thread's radius. In such a step the wheel's point ends a whole radius of the thread beside the tangent on which it started.
TEST(Attachment, OnAFastWheel) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nsolver: {name: " + std::string(solver) + R"(}
bodies:
  - {name: wheel, shape: {box: {size: [1, 1, 0.1]}}, mass: 10000, angular_velocity: [0, 0, 8]}
threads:
  - points: [[0.6, 0, 0], [0.8, 0, 0]]
    segments: 2
    radius: 0.005
    mass: 0.02
    velocity: [0, 4.8, 0]
    pins: [{node: 0, to: wheel}]
)"));
    const BodyState wheel = run.state(0);
    const Vec3 start = run.position(1);
    for (int k = 0; k < 120; ++k) {
      run.step();
      EXPECT_LT((run.position(1) - point_of(wheel, run.state(0), start)).norm(), 5e-7) << solver << ' ' << k;
    }
  }
}

// With a cloth that swings, angular momentum is lost at first order in the step, as implicit Euler loses it.
TEST(Attachment, KeepsMomentumWithACloth) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const auto coarse = tumble(solver, 0.004), fine = tumble(solver, 0.002);
    EXPECT_LT(coarse.first, 1e-13) << solver;
    EXPECT_LT(fine.first, 1e-13) << solver;
    EXPECT_NEAR(std::log2(coarse.second / fine.second), 1, 0.2) << solver;
  }
}

// Of a thread that lies along a ball, the tied node does not touch it, the others do; let go, it does too.
TEST(Attachment, ANodeDoesNotTouchWhatHoldsIt) {
  for (const char* motion : {"mass: 1", "motion: kinematic", "motion: fixed"}) {
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nbodies:\n  - {name: bob, shape: {sphere: {radius: 0.1}}, " +
                                   std::string(motion) + R"(}
threads:
  - points: [[0, -0.03, 0.1], [0, 0.09, 0.1]]
    segments: 2
    radius: 0.01
    mass: 1
    pins: [{node: 1, to: bob, release: 0.03}]
)"));
    const auto touches = [&](Id node) {
      run.simulation->detect();
      const auto& all = run.simulation->contacts.manifolds;
      return std::any_of(all.begin(), all.end(), [&](const Manifold& m) { return m.id_a == 0 && m.id_b == node; });
    };
    EXPECT_FALSE(touches(2)) << motion;
    EXPECT_TRUE(touches(1)) << motion;
    EXPECT_TRUE(run.simulation->contacts.surface.empty()) << "of the segments at the node";
    run.steps(2);
    EXPECT_TRUE(touches(2)) << motion;
    EXPECT_FALSE(run.simulation->contacts.surface.empty()) << motion;
  }
}

}  // namespace unibody::small_worlds::attachment_test
