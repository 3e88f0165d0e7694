// Joints against closed forms: pendulums, momentum, tensions, limits, motors, friction.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::joints_test {

namespace {

const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

std::string settings(const std::string& solver, int iterations, double step, const std::string& more = "") {
  return "solver: {name: " + solver + ", iterations: " + std::to_string(iterations) +
         ", tolerance: 0}\ntime: {frame: " + std::to_string(step) + "}\n" + more;
}

// A rod of 1 m and 1 kg that hangs at its upper end on a hinge of the world about y, turned out by an angle (degrees).
std::string rod(double angle, const std::string& more = "", const std::string& gravity = "[0, 0, -9.81]") {
  const double a = angle * M_PI / 180;
  return "gravity: " + gravity + "\nbodies:\n  - {name: rod, shape: {box: {size: [0.05, 0.05, 1]}}, mass: 1, position: [" +
         std::to_string(-0.5 * std::sin(a)) + ", 0, " + std::to_string(-0.5 * std::cos(a)) +
         "], orientation: {axis: [0, 1, 0], angle: " + std::to_string(angle) +
         "}}\njoints:\n  - {type: hinge, bodies: [rod, world], " + "anchors: [[0, 0, 0.5], [0, 0, 0]], axis: [0, 1, 0]" + more +
         "}\n";
}

const double inertia_at_end = (1 + 0.05 * 0.05) / 12 + 0.25;

double angle_of(const Experiment& run) { return run.simulation->joint_states()[0].coordinate; }

}  // namespace

// T = 2 pi sqrt(I / m g d) (1 + a^2 / 16), measured between passages through the vertical; the step's own error is of first
// order.
TEST(Joint, PendulumHasItsPeriod) {
  const double a = 0.2, exact = 2 * M_PI * std::sqrt(inertia_at_end / (9.81 * 0.5)) * (1 + a * a / 16);
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(rod(a * 180 / M_PI) + settings(solver, 60, 0.0005)));
    std::vector<double> passages;
    double before = run.position(0).x();
    for (int k = 1; passages.size() < 3; ++k) {
      run.step();
      const double x = run.position(0).x();
      if (before * x < 0) passages.push_back((k - x / (x - before)) * run.h());
      before = x;
      ASSERT_LT(k, 10000) << solver;
    }
    EXPECT_NEAR((passages[2] - passages[0]) / exact, 1, 1e-4) << solver;
  }
}

// A rod that hangs on a fixed box swings through it as it does where there is no box: what a joint ties does not touch.
TEST(Joint, ARodSwingsThroughTheBoxThatHoldsIt) {
  for (const char* solver : solver_list) {
    std::string held = rod(80);
    held.replace(held.find("joints:"), 7,
                 "  - {name: box, shape: {box: {size: [0.3, 0.3, 0.3]}}, motion: fixed, position: [0, 0, -0.5]}\njoints:");
    held.replace(held.find("[rod, world]"), 12, "[rod, box]");
    held.replace(held.find("[0, 0, 0]]"), 10, "[0, 0, 0.5]]");
    Experiment alone(scene_from_text(rod(80) + settings(solver, 30, 0.016))),
        through(scene_from_text(held + settings(solver, 30, 0.016)));
    double largest = 0;
    for (int k = 0; k < 120; ++k) {
      alone.step(), through.step();
      EXPECT_EQ(through.last.held_bodies, 0) << solver << ", step " << k;
      largest = std::max(largest, (alone.position(0) - through.position(0)).norm());
    }
    EXPECT_LT(largest, 1e-6) << solver;
  }
}

// In a plane a hinge says what a ball joint does, whatever the solver, of boxes and of discs. (Its rows that would tilt a body
// out of the plane are nought but for round-off, by which nothing may be divided.) From the horizontal all of m g d becomes
// motion.
TEST(Joint, InAPlaneAHingeIsABall) {
  const auto links = [](const std::string& type) {
    return "planar: true\nbodies:\n  - {shape: {box: {size: [0.09, 0.03, 0.02]}}, mass: 0.1, chain: {count: 12, from: [0, 0, 0], "
           "to: [0.8, 0, -0.8], held: start, joint: {type: " +
           type +
           "}, ball: {radius: 0.1, mass: 2}}}\n  - {name: rod, shape: {box: {size: [1, 0.05, 0.05]}}, mass: 1, position: " +
           "[3.5, 0, 0]}\njoints:\n  - {type: " + type + ", bodies: [rod, world], anchor: [3, 0, 0]" +
           (type == "hinge" ? ", axis: [0, 1, 0]}\n" : "}\n");
  };
  for (const std::string solver : solver_list)
    for (const char* joints : {"iterative", "direct"}) {
      const auto scene = [&](const char* type) {
        return scene_from_text(links(type) + settings(solver + ", joints: " + joints, 60, 0.004));
      };
      Experiment hinges(scene("hinge")), balls(scene("ball"));
      double fastest = 0;
      for (int k = 0; k < 150; ++k) {
        hinges.step(), balls.step();
        fastest = std::max(fastest, std::abs(hinges.world().angular_velocity[13].y()));
      }
      for (Id i = 0; i < 14; ++i)
        EXPECT_LT((hinges.position(i) - balls.position(i)).norm(), 1e-8) << solver << ' ' << joints << " body " << i;
      EXPECT_NEAR(0.5 * inertia_at_end * fastest * fastest / (9.81 * 0.5), 1, 0.02) << solver << ' ' << joints;
    }
}

// Two rods, the second on the first: against the Lagrange equations by Runge and Kutta, with an error that falls with the step.
TEST(Joint, DoublePendulumFollowsAFineReference) {
  const double I = (1 + 0.05 * 0.05) / 12, g = 9.81;
  using State = Eigen::Vector4d;  // angles, rates
  const auto rate = [&](const State& s) {
    const double c = std::cos(s[0] - s[1]), n = std::sin(s[0] - s[1]);
    Eigen::Matrix2d M;
    M << I + 0.25 + 1, 0.5 * c, 0.5 * c, I + 0.25;
    const Eigen::Vector2d f(-0.5 * n * s[3] * s[3] - 1.5 * g * std::sin(s[0]), 0.5 * n * s[2] * s[2] - 0.5 * g * std::sin(s[1]));
    const Eigen::Vector2d w = M.inverse() * f;
    return State(s[2], s[3], w[0], w[1]);
  };
  State exact(M_PI / 2, M_PI / 2, 0, 0);
  const double dt = 1e-4;
  for (int k = 0; k < 5000; ++k) {
    const State a = rate(exact), b = rate(exact + dt / 2 * a), c = rate(exact + dt / 2 * b), d = rate(exact + dt * c);
    exact += dt / 6 * (a + 2 * b + 2 * c + d);
  }
  const Vec3 elbow(std::sin(exact[0]), 0, -std::cos(exact[0]));
  const Vec3 end = elbow + 0.5 * Vec3(std::sin(exact[1]), 0, -std::cos(exact[1]));
  const auto error = [&](const std::string& solver, double h) {
    Experiment run(scene_from_text(R"(
bodies:
  - shape: {box: {size: [1, 0.05, 0.05]}}
    mass: 1
    chain: {count: 2, from: [0, 0, 0], to: [2, 0, 0], held: start, joint: {type: hinge, axis: [0, 1, 0]}}
)" + settings(solver, 150, h)));
    run.seconds(0.5);
    return (run.position(1) - end).norm();
  };
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const char* joints : {"iterative", "direct"}) {
      const std::string what = solver + ", joints: " + joints;
      const double coarse = error(what, 0.004), fine = error(what, 0.001);
      EXPECT_LT(fine, 0.02) << what;
      EXPECT_GT(coarse / fine, 3) << what << ' ' << coarse << ' ' << fine;
    }
}

TEST(Joint, AHingeKeepsItsAxis) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(rod(80) + settings(solver, 400, 0.016)));
    run.world().angular_velocity[0] = Vec3(0, 3, 0);
    run.simulation->world.properties.set(0, [&] {
      BodyProperties p = run.world().properties[0];
      p.torque = Vec3(2, 0, 1);  // N m, against the axis
      return p;
    }());
    for (int k = 0; k < 100; ++k) {
      run.step();
      const JointState s = run.simulation->joint_states()[0];
      ASSERT_LT(s.turn, 1e-6) << solver << ' ' << k;
      ASSERT_LT(s.drift, 1e-6) << solver << ' ' << k;
    }
    EXPECT_LT(run.last.residual_of<JointBatch>(), 1e-6);
  }
}

// Two bodies that turn about each other, free: neither momentum changes in steps up to the default, however few the iterations;
// in steps three times as long neither angular momentum nor energy comes from nowhere. In steps in which they turn by more than
// half a radian linear momentum stays all the same, the rest only as far as docs/scene-joints.md says (What joints can't).
TEST(Joint, MomentumStaysAndEnergyDoesNotGrow) {
  struct Type {
    const char* text;
    double share, growth;  // of angular momentum and energy in steps of 0.1 s
  };
  constexpr double any = std::numeric_limits<double>::infinity();
  for (const char* solver : solver_list)
    for (const Type& type : {Type{"ball", 0.5, 2}, Type{"fixed", 0.1, 1.001}, Type{"hinge, axis: [0, 0, 1]", 0.5, 2},
                             Type{"universal, axis: [0, 0, 1]", 0.5, 2}, Type{"slider, axis: [1, 0, 0]", 0.1, 1.02}}) {
      const auto check = [&](double h, int iterations, double share, double growth) {
        Experiment run(scene_from_text(std::string(R"(
gravity: [0, 0, 0]
bodies:
  - {name: a, shape: {box: {size: [1, 0.2, 0.3]}}, mass: 2, position: [0, 0, 0], velocity: [0, 1, 0.5]}
  - {name: b, shape: {sphere: {radius: 0.2}}, mass: 1, position: [1, 0, 0], velocity: [0, -2, 1], angular_velocity: [0, 3, 0]}
joints: [{type: )") + type.text + ", bodies: [a, b], anchor: [0.5, 0, 0]}]\n" +
                                       settings(solver, iterations, h)));
        const Vec3 p = run.momentum(), l = run.angular_momentum();
        const double energy = run.kinetic_energy();
        for (int k = 0; k < 100; ++k) {
          run.step();
          EXPECT_LT((run.momentum() - p).norm(), 1e-12) << solver << ' ' << type.text << ' ' << h << ' ' << k;
          EXPECT_LT((run.angular_momentum() - l).norm(), share * l.norm()) << solver << ' ' << type.text << ' ' << h << ' ' << k;
          EXPECT_LT(run.kinetic_energy(), growth * energy) << solver << ' ' << type.text << ' ' << h;
        }
      };
      check(0.004, 5, 1e-12, 1.001), check(0.016, 3, 1e-12, 1.001), check(0.05, 3, 1e-3, 1.001);
      check(0.1, 50, type.share, type.growth);
      for (const double h : {0.15, 0.2, 0.25, 0.3}) check(h, 50, any, 1.15);
    }
}

// Ten levels of links hit a bar and the floor in steps of 16 ms.
TEST(Joint, ATreeThatIsHitHardGainsNoEnergy) {
  Experiment run(scene_from_text(R"(
materials: {wood: {friction: 0.4}}
bodies:
  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}
  - {name: bar, shape: {box: {size: [0.3, 6, 0.3]}}, motion: fixed, position: [0, 0, 1.6], orientation: {axis: [0, 1, 0], angle: 45}}
  - tree: {levels: 10, branches: 2, length: 1.2, width: 0.12, ratio: 0.8, spread: 50, joint: {type: ball, damping: 0.02}}
    density: 600
    position: [0, 0, 6]
    orientation: {axis: [0, 1, 0], angle: 70}
)" + settings("accelerated_jacobi", 20, 0.016)));
  const double energy = run.energy();
  for (int k = 0; k < 90; ++k) {
    run.step();
    ASSERT_LT(run.energy(), 1.0001 * energy) << k;
  }
  EXPECT_LT(run.energy(), 0.5 * energy);  // it has been hit
}

// The force in joint i of a chain at rest carries all that hangs below it.
TEST(Joint, AChainCarriesWhatHangsOnIt) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment run(scene_from_text(R"(
bodies:
  - shape: {box: {size: [0.1, 0.02, 0.02]}}
    mass: 0.1
    chain: {count: 8, from: [0, 0, 0], to: [0, 0, -0.8], held: start, joint: {type: ball}, ball: {radius: 0.1, mass: 1}}
)" + settings(solver, 3000, 0.016)));
    run.steps(40);
    const auto states = run.simulation->joint_states();
    ASSERT_EQ(states.size(), 9u);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const double below = 1 + 0.1 * (8 - static_cast<double>(i));
      EXPECT_NEAR(states[i].force.z() / (below * 9.81), 1, 1e-3) << solver << ' ' << i;
      EXPECT_LT(states[i].drift, 1e-6) << solver << ' ' << i;
    }
  }
}

TEST(Joint, MoreIterationsLeaveLessDrift) {
  for (const char* solver : solver_list) {
    double last = 1e9;
    for (const int iterations : {10, 40, 160, 640}) {
      Experiment run(scene_from_text(R"(
bodies:
  - shape: {box: {size: [0.1, 0.02, 0.02]}}
    mass: 0.1
    chain: {count: 12, from: [0, 0, 0], to: [1.2, 0, 0], held: start, joint: {type: ball}, ball: {radius: 0.1, mass: 5}}
)" + settings(solver, iterations, 0.016)));
      double drift = 0;
      for (int k = 0; k < 30; ++k) {
        run.step();
        for (const JointState& s : run.simulation->joint_states()) drift = std::max(drift, s.drift);
      }
      EXPECT_LT(drift, last) << solver << ' ' << iterations;
      last = drift;
    }
  }
}

// A wheel on its hinge, driven without gravity: w = M t / I up to the spin that turns it in a step as far as the motor's speed
// does; never more than its torque.
TEST(Joint, AMotorReachesItsSpeedWithItsTorque) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(R"(
gravity: [0, 0, 0]
bodies: [{name: wheel, shape: {box: {size: [1, 0.1, 1]}}, mass: 3}]
joints: [{type: hinge, bodies: [wheel, world], anchor: [0, 0, 0], axis: [0, 1, 0], motor: {speed: 2, max_torque: 0.5}}]
)" + settings(solver, 100, 0.01)));
    for (int k = 1; k <= 250; ++k) {
      run.step();
      const double w = std::min(2 / 0.01 * std::tan(0.5 * 0.01 * 2), 0.5 * 0.01 * k / 0.5);  // I = 3 (1 + 1) / 12
      ASSERT_NEAR(run.state(0).angular_velocity.y(), w, 1e-9) << solver << ' ' << k;
      ASSERT_LE(std::abs(run.simulation->joint_states()[0].motor), 0.5 * (1 + 1e-12)) << solver;
    }
    EXPECT_NEAR(run.simulation->joint_states()[0].motor, 0, 1e-6) << "nothing to do at its speed";
  }
}

// A servo that is strong enough holds its angle, and gives what holds it there; one that is too weak gives all that it has.
TEST(Joint, AMotorHoldsItsAngle) {
  for (const char* solver : solver_list) {
    Experiment strong(scene_from_text(rod(0, ", motor: {angle: 30, max_torque: 5}") + settings(solver, 800, 0.01)));
    double most = 0;
    for (int k = 0; k < 200; ++k) strong.step(), most = std::max(most, angle_of(strong));
    EXPECT_LT(most, M_PI / 6 + 1e-3) << solver << ": it brakes in time";
    EXPECT_NEAR(angle_of(strong), M_PI / 6, 1e-6) << solver;
    EXPECT_NEAR(std::abs(strong.simulation->joint_states()[0].motor), 9.81 * 0.5 * 0.5, 1e-4) << solver;
    Experiment weak(scene_from_text(rod(0, ", motor: {angle: 90, max_torque: 2}") + settings(solver, 100, 0.01)));
    weak.steps(20);
    EXPECT_NEAR(std::abs(weak.simulation->joint_states()[0].motor), 2, 1e-12) << solver;
  }
}

TEST(Joint, LimitsHold) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(rod(0, ", limits: [-20, 30]") + settings(solver, 400, 0.01)));
    run.world().angular_velocity[0] = Vec3(0, 6, 0), run.world().velocity[0] = Vec3(-3, 0, 0);
    double least = 0, most = 0;
    for (int k = 0; k < 300; ++k) {
      run.step();
      least = std::min(least, angle_of(run)), most = std::max(most, angle_of(run));
    }
    EXPECT_NEAR(most, M_PI / 6, 1e-6) << solver << ": it swings as far as it may";
    EXPECT_GT(least, -M_PI / 9 - 1e-6) << solver;
  }
}

// A slider on a slope: limits stop it, and dry friction holds it up to its strength, then gives just that.
TEST(Joint, ASliderSlidesStopsAndRubs) {
  const auto slider = [](const std::string& more) {
    return "bodies:\n  - {name: cart, shape: {box: {size: [0.2, 0.1, 0.3]}}, mass: 2}\njoints:\n"
           "  - {type: slider, bodies: [cart, world], anchor: [0.1, 0, 0], axis: [0.6, 0, -0.8]" +
           more + "}\n";
  };
  const double pull = 2 * 9.81 * 0.8;
  for (const char* solver : solver_list) {
    Experiment sliding(scene_from_text(slider(", friction: 5") + settings(solver, 100, 0.01)));
    sliding.steps(50);
    EXPECT_NEAR(sliding.velocity(0).norm(), (pull - 5) / 2 * 0.5, 1e-6) << solver;
    EXPECT_NEAR(sliding.simulation->joint_states()[0].friction, -5, 1e-9) << solver;
    EXPECT_LT(sliding.simulation->joint_states()[0].turn, 1e-6) << solver;
    Experiment held(scene_from_text(slider(", friction: 16") + settings(solver, 100, 0.01)));
    held.steps(50);
    EXPECT_NEAR(held.position(0).norm(), 0, 1e-6) << solver;
    EXPECT_NEAR(held.simulation->joint_states()[0].friction, -pull, 1e-3) << solver;
    Experiment stopped(scene_from_text(slider(", limits: [-1, 0.2]") + settings(solver, 100, 0.01)));
    stopped.steps(100);
    EXPECT_NEAR(stopped.simulation->joint_states()[0].coordinate, 0.2, 1e-6) << solver;
    EXPECT_NEAR(std::abs(stopped.simulation->joint_states()[0].limit), pull, 1e-3) << solver;
  }
}

// Slack it does nothing; taut it carries the weight.
TEST(Joint, ARopePullsAndNeverPushes) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(R"(
bodies: [{name: bob, shape: {sphere: {radius: 0.1}}, mass: 3, position: [0, 0, -0.5]}]
joints: [{type: rope, bodies: [bob, world], points: [[0, 0, -0.4], [0, 0, 0]], length: 1}]
)" + settings(solver, 50, 0.01)));
    for (int k = 0; k < 10; ++k) {
      run.step();
      ASSERT_EQ(run.simulation->joint_states()[0].force, Vec3(Vec3::Zero())) << solver;
    }
    EXPECT_NEAR(run.velocity(0).z(), -9.81 * 0.1, 1e-12);
    run.steps(100);
    EXPECT_NEAR(run.position(0).z(), -1.1, 1e-6) << solver;
    EXPECT_NEAR(run.simulation->joint_states()[0].force.z(), 3 * 9.81, 1e-4) << solver;
  }
}

// Thirteen rows for one degree of freedom: the door turns as on one hinge, and nothing grows.
TEST(Joint, ADoorOnThreeHingesSwings) {
  const auto door = [](int hinges, const char* solver) {
    std::string text = R"(
gravity: [0, 1, -9.81]
bodies: [{name: door, shape: {box: {size: [0.9, 0.04, 2]}}, mass: 20, position: [0.45, 0, 1]}]
joints:
)";
    for (int i = 0; i < hinges; ++i)
      text += "  - {type: hinge, bodies: [door, world], anchor: [0, 0, " + std::to_string(hinges == 1 ? 1 : i + 0.0) +
              "], axis: [0, 0, 1]}\n";
    return text + settings(solver, 300, 0.01);
  };
  for (const char* solver : solver_list) {
    Experiment one(scene_from_text(door(1, solver))), three(scene_from_text(door(3, solver)));
    one.steps(150), three.steps(150);
    EXPECT_LT((one.position(0) - three.position(0)).norm(), 1e-4) << solver;
    EXPECT_GT((three.position(0) - Vec3(0.45, 0, 1)).norm(), 0.3) << solver;
    Vec3 force = Vec3::Zero();
    for (const JointState& s : three.simulation->joint_states()) force += s.force;
    EXPECT_NEAR(force.z(), 20 * 9.81, 0.1) << solver;
  }
}

// Compliance is a spring's: at rest the joint is open by E times its force, and a damped one creeps there.
TEST(Joint, ComplianceIsASpring) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(R"(
bodies: [{name: bob, shape: {sphere: {radius: 0.1}}, mass: 2}]
joints: [{type: ball, bodies: [bob, world], anchor: [0, 0, 0], compliance: 1e-3, damping: 0.2}]
)" + settings(solver, 50, 0.01)));
    run.steps(400);
    EXPECT_NEAR(run.simulation->joint_states()[0].drift, 1e-3 * 2 * 9.81, 1e-8) << solver;
  }
}

TEST(Joint, ItsBodiesPassThroughEachOtherUnlessAsked) {
  for (const bool collide : {false, true}) {
    Experiment run(scene_from_text(std::string(R"(
bodies:
  - {name: a, shape: {sphere: {radius: 0.2}}, mass: 1}
  - {name: b, shape: {sphere: {radius: 0.2}}, mass: 1, position: [0.3, 0, 0]}
gravity: [0, 0, 0]
joints: [{type: rope, bodies: [a, b], points: [[0, 0, 0], [0.3, 0, 0]], length: 2, collide: )") +
                                   (collide ? "true" : "false") + "}]\n"));
    run.simulation->detect();
    EXPECT_EQ(run.simulation->contacts.manifolds.size(), collide ? 1u : 0u);
  }
}

// A joint to a body that moves by itself carries the other along.
TEST(Joint, AKinematicBodyDrags) {
  Experiment run(scene_from_text(R"(
gravity: [0, 0, 0]
bodies:
  - {name: arm, shape: {box: {size: [1, 0.1, 0.1]}}, motion: kinematic, angular_velocity: [0, 0, 1]}
  - {name: load, shape: {sphere: {radius: 0.1}}, mass: 1, position: [1, 0, 0]}
joints: [{type: fixed, bodies: [load, arm], anchor: [0.5, 0, 0]}]
)" + settings("accelerated_jacobi", 200, 0.01)));
  run.seconds(1);
  EXPECT_NEAR(run.position(1).norm(), 1, 1e-5);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), 1, 1e-2);
}

}  // namespace unibody::small_worlds::joints_test
