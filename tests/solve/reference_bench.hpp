// Cloths of the kinds that scenes have, in random motion, and the iterative solvers on one step of them without contacts.
#pragma once

#include "collide/bodies.hpp"
#include "small_worlds.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds {

struct ClothCase {
  const char* name;
  const char* model;  // of the scene's text
};
inline constexpr ClothCase stiff_links{"stiff links", "links: {diagonals: none}"};
inline constexpr ClothCase braced_links{"stiff links with diagonals", "links: {diagonals: alternating}"};
inline constexpr ClothCase springs{"springs", "links: {stiffness: 2000, damping: 0.02}"};
inline constexpr ClothCase membrane{"membrane",
                                    "membrane: {youngs_modulus: 1.0e5, poissons_ratio: 0.3, damping: 0.01}\n"
                                    "    bending: {model: dihedral, stiffness: 0.01}"};

// 1 m x 1 m, at rest in the plane z = 0, held at opposite corners: pins at the ends of a row of stiff links would leave that row
// no slack, and a straight stiff row between two pins has no regular solution.
inline Scene cloth(const ClothCase& of, int nodes, double step) {
  const std::string n = std::to_string(nodes), last = std::to_string(nodes - 1);
  Scene scene =
      scene_from_text("cloths:\n  - grid: {size: [1, 1], nodes: [" + n + ", " + n + "]}\n    mass: 2\n    thickness: 0.01\n    " +
                      of.model + "\n    pins: [{node: [0, 0]}, {node: [" + last + ", " + last + "]}]\n");
  scene.solver.tolerance = 0, scene.solver.stages = Stages::position;
  scene.time.step = step;
  return scene;
}

// Velocities (m/s) and displacements (m) of up to these sizes along each axis; what is pinned stays.
inline void shake(World& world, double speed, double displacement, std::uint64_t seed) {
  testing::Random random(seed);
  for (std::size_t i = 0; i < world.homes; ++i) {
    const Vec3 v = random.vector(-speed, speed), d = random.vector(-displacement, displacement);
    if (world.properties[i].motion == Motion::dynamic) world.velocity[i] += v, world.position[i] += d;
  }
}

// x_l + h v with the velocities of a step.
inline void advance(World& world, const ReferenceStep& step, double h) {
  for (std::size_t i = 0; i < world.size(); ++i) world.velocity[i] = step.velocity[i], world.position[i] += h * step.velocity[i];
}

inline double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}
inline double largest(const std::vector<Vec3>& a) { return largest_difference(a, std::vector<Vec3>(a.size(), Vec3::Zero())); }

// One step's solve by an iterative solver, that can be taken further.
struct IterativeStep {
  Bench bench;
  ConstraintBatches batches;
  const ConstraintSet& constraints;
  const Solver& solver;

  IterativeStep(const World& world, const ConstraintSet& set, const Vec3& gravity, double h, const char* name)
      : constraints(set), solver(find_solver(name)) {
    bench.world = world, bench.gravity = gravity, bench.step = h;
    bench.build_for_jacobi();
    ConstraintBatches::Colours colours{};
    for_each_type(set, [&](auto type, const auto& list) {
      for (const auto& c : list) colours[type.value] = std::max(colours[type.value], c.colour + 1);
    });
    batches.build(set, world, static_cast<Slot>(world.size()), solver.sweeps_by_colour, Order::coloured, colours);
    std::vector<std::int32_t> counts(world.size() + 1, 0);
    batches.count(counts);
    bench.system.homes = world.homes, bench.system.step = h, bench.system.constraints = &batches;
    bench.system.places.resize(world.size() + 1, Vec4d{});
    for (std::size_t i = 0; i < world.size(); ++i) {
      const Vec3& x = world.position[i];
      bench.system.places[i] = Vec4d{x.x(), x.y(), x.z(), counts[i] * bench.system.bodies[i].inverse_mass};
    }
    predicted.assign(bench.system.bodies.begin(), bench.system.bodies.end());
  }

  void iterate(int iterations) { solver.solve(bench.system, bench.cut, iterations, 0); }

  // v = v~ + W D lambda with D at the present places, a share of the way: instead of the impulses along the older directions in
  // which they were applied. Returns the largest change (m/s).
  double reapply(double share = 1) {
    System& s = bench.system;
    ConstraintMultipliers lambda;
    batches.get_multipliers(lambda, constraints);
    batches.add_impulses(s.start(), s.bodies, s.wrenches);
    double worst = 0;
    for (std::size_t i = 0; i < s.homes; ++i) {
      const Vec4d impulse = s.wrenches[i].force;
      s.wrenches[i] = Wrench{};
      Vec3 change;
      for (int k = 0; k < 3; ++k) change[k] = predicted[i].v[k] + predicted[i].inverse_mass * impulse[k] - s.bodies[i].v[k];
      for (int k = 0; k < 3; ++k) s.bodies[i].v[k] += share * change[k];
      worst = std::max(worst, change.norm());
    }
    batches.set_multipliers(lambda, 1);
    return worst;
  }

  // m, of all types
  double residual() const {
    double worst = 0;
    for (const double r : batches.residuals(bench.system.start(), bench.system.bodies)) worst = std::max(worst, r);
    return worst;
  }
  std::vector<Vec3> velocity() const {
    std::vector<Vec3> v;
    for (std::size_t i = 0; i < bench.world.size(); ++i) v.emplace_back(bench.system.bodies[i].v);
    return v;
  }

  std::vector<SolverBody> predicted;
};

}  // namespace unibody::small_worlds
