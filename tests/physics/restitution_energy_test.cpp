// Impacts with restitution and friction give no energy.
//
// A step is v' = v + h g + W D lambda, x' = x + h v'. So E + h g.P / 2, with E the energy and P the momentum, changes by just the
// work lambda.(u + u')/2 of the contacts, u and u' the velocities at which their sides part before and after it; of bodies that
// have the same inertia about all axes. What may be above zero there is what the solver leaves undone, at most its residual over
// h in u', the speed at which penetration is taken out, and what two bodies do who would give energy without any bounce: that
// part and are pressed on each other nevertheless, by weight or by others' impacts in the same step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "small_worlds.hpp"
#include "step/contact_problem.hpp"

namespace unibody::small_worlds::restitution_energy_test {

namespace {

const std::string solvers[] = {"gauss_seidel", "accelerated_jacobi"};

std::string head(const std::string& solver, int iterations, double friction, double restitution,
                 const std::string& stages = "two") {
  return "solver: {name: " + solver + ", iterations: " + std::to_string(iterations) + ", tolerance: 0, stages: " + stages +
         "}\nmaterials: {m: {friction: " + std::to_string(friction) + ", restitution: " + std::to_string(restitution) + "}}\n";
}

std::string list(const Vec3& p) {
  return "[" + std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " + std::to_string(p.z()) + "]";
}

double kept_energy(const Experiment& run) { return run.energy() + 0.5 * run.h() * run.scene->gravity.dot(run.momentum()); }

// J, what the last step may have given; `before`: the bodies' states at its start.
double most_gain(const Experiment& run, const ContactProblem& problem, const std::vector<BodyState>& before) {
  const Contacts& contacts = run.simulation->contacts;
  double impulses = 0, deepest = 0, pressed = 0;
  for (const auto& c : problem.contacts) impulses += std::hypot(c.impulse[0], c.impulse[1], c.impulse[2]);
  for (const ContactPoint& p : contacts.points) deepest = std::max(deepest, -p.gap);
  for (const Manifold& m : contacts.manifolds) {
    const Vec3 s = first_tangent_of(m.normal), t = m.normal.cross(s);
    double work = 0;
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const auto [along, sideways, forward] = problem.contacts[p].impulse;
      const auto velocity = [&](const BodyState& body, const Vec3& centre) -> Vec3 {
        return body.velocity + body.angular_velocity.cross(contacts.points[p].position - centre);
      };
      const BodyState &a = before[static_cast<std::size_t>(m.id_a)], &b = before[static_cast<std::size_t>(m.id_b)];
      const Vec3 u = velocity(a, a.position) - velocity(b, b.position);
      const Vec3 parted = velocity(run.state(m.id_a), a.position) - velocity(run.state(m.id_b), b.position);
      work += 0.5 * (along * m.normal.dot(u) + (sideways * s + forward * t).dot(u + parted));
    }
    pressed += std::max(0.0, work);
  }
  return impulses * (run.last.residual / run.h() + deepest / (run.h() + run.scene->time.frame)) + pressed;
}

// Steps, each of which must not gain; returns the sum of what the steps might have (J).
double expect_no_gain(Experiment& run, int steps, const std::string& what) {
  const double start = kept_energy(run);
  double before = start, all = 0;
  ContactProblem problem;
  std::vector<BodyState> states(run.world().size());
  for (int k = 0; k < steps; ++k) {
    for (std::size_t id = 0; id < states.size(); ++id) states[id] = run.state(static_cast<Id>(id));
    run.last = run.simulation->step({.problem = &problem});
    const double now = kept_energy(run), most = most_gain(run, problem, states);
    if (now - before > most + 1e-12 * start) {
      ADD_FAILURE() << what << ", step " << k << ": " << now - before << " J, at most " << most;
      return all;
    }
    before = now, all += most;
  }
  return all;
}

}  // namespace

TEST(RestitutionEnergy, BoxOnRoughGroundGainsNone) {
  for (const std::string& solver : solvers)
    for (const double e : {0.5, 0.9, 1.0})
      for (const double mu : {0.0, 0.4, 0.8, 1.0}) {
        Scene scene = scene_from_text(head(solver, 100, mu, e) +
                                      "time: {substeps: 16}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                      "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 1], "
                                      "orientation: {axis: [0.6, 0.8, 0], angle: 30}}\n");
        Experiment run(std::move(scene));
        const double start = kept_energy(run);
        const std::string what = solver + ", e " + std::to_string(e) + ", mu " + std::to_string(mu);
        const double most = expect_no_gain(run, 2500, what);
        EXPECT_LT(most, 0.01 * start) << what << ": the bound says nothing";
        // Without friction nothing is lost either, but in impacts too slow to bounce, of 2 g h = 0.02 m/s.
        if (mu == 0 && e == 1) {
          EXPECT_NEAR(kept_energy(run), start, 0.01 * start) << what;
        }
      }
}

// An edge hits ground that holds it, at u along the ground and v into it. From the edge's mobility G, H = G^-1: impulses
// H (b + v, -u) do the work (H_nn (b^2 - v^2) + 2 H_nt u v - H_tt u^2) / 2, which is none at one speed b; e v if that is less.
TEST(RestitutionEnergy, EdgeBouncesAtTheSpeedThatGivesNone) {
  const double a = 0.2, mass = 1, inertia = mass * a * a / 6, tilt = 20 * M_PI / 180, v = 2, mu = 4;
  const double x = a * std::sqrt(0.5) * std::sin(M_PI / 4 - tilt), z = -a * std::sqrt(0.5) * std::cos(M_PI / 4 - tilt);
  const double nn = 1 / mass + x * x / inertia, tt = 1 / mass + z * z / inertia, nt = -x * z / inertia;
  const double det = nn * tt - nt * nt, Hnn = tt / det, Htt = nn / det, Hnt = -nt / det;
  int limited = 0, whole = 0;
  for (const std::string& solver : solvers)
    for (const double e : {0.5, 0.9, 1.0})
      for (const double u : {-1.0, -0.5, 0.5, 1.0}) {
        Experiment run(scene_from_text("gravity: [0, 0, 0]\ntime: {frame: 0.001}\n" + head(solver, 2000, mu, e) +
                                       "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                       "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, "
                                       "orientation: {axis: [0, 1, 0], angle: 20}}\n"));
        run.world().position[run.slot(1)] = Vec3(0, 0, -z);
        run.world().velocity[run.slot(1)] = Vec3(u, 0, -v);
        run.step();
        const double none = std::sqrt(v * v - (2 * Hnt * u * v - Htt * u * u) / Hnn), b = std::min(e * v, none);
        ASSERT_LT(std::abs(Hnt * (b + v) - Htt * u), mu * (Hnn * (b + v) - Hnt * u)) << "the ground does not hold it";
        const double spin = run.state(1).angular_velocity.y();
        EXPECT_NEAR(run.velocity(1).z() - x * spin, b, 1e-6) << solver << ' ' << e << ' ' << u;
        EXPECT_NEAR(run.velocity(1).x() + z * spin, 0, 1e-6) << solver << ' ' << e << ' ' << u;
        ++(b < e * v ? limited : whole);
      }
  EXPECT_GT(limited, 0);
  EXPECT_GT(whole, 0);
}

// With stages whose multipliers are the same, so that the residual is that of both: balls, boxes, cylinders and capsules, of the
// same inertia about all axes, fly about in a closed box.
TEST(RestitutionEnergy, BodiesInABoxGainNone) {
  const char* shapes[] = {"sphere: {radius: 0.08}", "box: {size: [0.14, 0.14, 0.14]}", "cylinder: {radius: 0.06, length: 0.12}",
                          "capsule: {radius: 0.05, length: 0.1}"};
  std::string bodies = "gravity: [0, 0, 0]\ntime: {substeps: 16}\nbodies:\n";
  for (const std::string axis : {"1, 0, 0", "0, 1, 0", "0, 0, 1"})
    for (const double side : {-0.5, 0.5}) {
      const Vec3 n(axis[0] - '0', axis[3] - '0', axis[6] - '0');
      bodies += "  - {shape: {plane: {normal: " + list(-2 * side * n) + "}}, position: " + list(side * n) + "}\n";
    }
  for (int k = 0; k < 12; ++k)
    bodies += std::string("  - {shape: {") + shapes[k % 4] + "}, mass: 1, inertia: [0.003, 0.003, 0.003], position: " +
              list({0.3 * (k / 4 - 1), k % 4 < 2 ? -0.25 : 0.25, k % 2 ? 0.25 : -0.25}) +
              ", velocity: " + list(Vec3(7 * k % 5 - 2, (7 * k + 3) % 5 - 2, (7 * k + 1) % 5 - 2)) +
              ", angular_velocity: " + list(Vec3(k % 3, k % 5 - 2, 1)) + "}\n";
  for (const std::string& solver : solvers)
    for (const double e : {0.5, 0.9, 1.0})
      for (const double mu : {0.4, 0.8}) {
        Experiment run(scene_from_text(head(solver, 400, mu, e, "together") + bodies));
        const double start = kept_energy(run);
        const std::string what = solver + ", e " + std::to_string(e) + ", mu " + std::to_string(mu);
        EXPECT_LT(expect_no_gain(run, 800, what), 0.01 * start) << what << ": the bound says nothing";
        EXPECT_LT(kept_energy(run), 0.9 * start) << what << ": friction takes nothing";
      }
}

}  // namespace unibody::small_worlds::restitution_energy_test
