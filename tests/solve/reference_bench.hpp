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
  scene.time.frame = step;
  return scene;
}

// Velocities (m/s) and displacements (m) of up to these sizes along each axis; what is pinned stays.
inline void shake(World& world, double speed, double displacement, std::uint64_t seed) {
  samples::Random random(seed);
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
  const ConstraintSet& constraints;
  const Solver& solver;

  IterativeStep(const World& world, const ConstraintSet& set, const Vec3& gravity, double h, const char* name,
                const SolverSettings& settings = {})
      : constraints(set), solver(find_solver(name)) {
    bench.world = world, bench.gravity = gravity, bench.step = h;
    bench.build_for_jacobi();
    ConstraintColours colours{};
    for_each_type(set, [&](auto type, const auto& list) {
      for (const auto& c : list) colours[type.value] = std::max(colours[type.value], c.colour + 1);
    });
    bench.settings = settings;
    BuildContext context = bench.context();
    context.elements.constraints = &set, context.constraint_colours = colours, context.by_colour = solver.sweeps_by_colour;
    std::vector<std::int32_t> counts(world.size() + 1, 0);
    for_each_constraint_batch(bench.system.batches, [&]<class B>(auto, B& batch) {
      batch.build(context);
      B::count(context, counts);
    });
    bench.system.acceleration = settings.acceleration;
    bench.system.homes = world.homes, bench.system.step = h, bench.system.keeps_places = true;
    bench.system.places.resize(world.size() + 1, Vec4d{});
    for (std::size_t i = 0; i < world.size(); ++i) {
      const Vec3& x = world.position[i];
      const double sharers = solver.sweeps_by_colour ? 1 : counts[i];
      bench.system.places[i] = Vec4d{x.x(), x.y(), x.z(), sharers * bench.system.bodies[i].inverse_mass};
    }
    bench.system.impulses.assign(world.size() + 1, Vec4d{});
    predicted.assign(bench.system.bodies.begin(), bench.system.bodies.end());
  }

  void iterate(int iterations) { solver.solve(bench.system, bench.exchange, iterations, 0); }

  // v = v~ + W D lambda with D at the present places, instead of the impulses along the older directions in which they were
  // applied; of each body (slot) a share of the way, where shares are given.
  void reapply(const std::vector<double>& share = {}) {
    System& s = bench.system;
    const ConstraintMultipliers lambda = multipliers();
    for_each_constraint_batch(s.batches, [&](auto, auto& batch) { batch.add_impulses(s.start(), s.bodies, s.impulses); });
    for (std::size_t i = 0; i < s.homes; ++i) {
      const Vec4d impulse = s.impulses[i];
      s.impulses[i] = Vec4d{};
      for (int k = 0; k < 3; ++k) {
        const double change = predicted[i].v[k] + predicted[i].inverse_mass * impulse[k] - s.bodies[i].v[k];
        s.bodies[i].v[k] += (share.empty() ? 1 : share[i]) * change;
      }
    }
    set_multipliers(lambda);
  }

  // Of each slot d: h / m times the row sums, at most, of all |lambda d2c/dx2|: how far the turn of directions feeds back into
  // the velocities when the impulses are re-applied.
  std::vector<double> feedback() const {
    const ReferenceProblem problem(bench.world, constraints, bench.gravity, bench.step);
    Eigen::VectorXd u = problem.start();
    std::vector<std::size_t> slot;  // of each velocity
    for (std::size_t i = 0; i < bench.world.size(); ++i)
      if (predicted[i].inverse_mass > 0) {
        u.segment<3>(static_cast<Eigen::Index>(slot.size())) = Vec3(bench.system.bodies[i].v);
        slot.insert(slot.end(), 3, i);
      }
    auto row = static_cast<Eigen::Index>(slot.size());
    const ConstraintMultipliers all = multipliers();
    for_each_type(all, [&](auto, const auto& list) {
      for (const auto& one : list)
        for (const double lambda : one) u[row++] = lambda;
    });
    std::vector<PetscInt> rows, columns;
    std::vector<double> values, sum(slot.size(), 0), result(bench.world.size(), 0);
    problem.pattern(rows, columns);
    problem.jacobian(u, values);
    const auto n = static_cast<PetscInt>(slot.size());
    for (std::size_t i = slot.size(); i < values.size(); ++i)  // past the identity
      if (rows[i] >= 0 && columns[i] >= 0 && rows[i] < n && columns[i] < n)
        sum[static_cast<std::size_t>(rows[i])] += std::abs(values[i]);
    for (std::size_t i = 0; i < slot.size(); ++i) result[slot[i]] = std::max(result[slot[i]], sum[i]);
    return result;
  }

  ConstraintMultipliers multipliers() const {
    ConstraintMultipliers lambda;
    for_each_constraint_batch(bench.system.batches, [&](auto type, const auto& batch) {
      auto& list = std::get<decltype(type)::value>(lambda);
      list.resize(std::get<decltype(type)::value>(constraints).size());
      batch.get_multipliers(list);
    });
    return lambda;
  }
  void set_multipliers(const ConstraintMultipliers& lambda) {
    for_each_constraint_batch(bench.system.batches,
                              [&](auto type, auto& batch) { batch.set_multipliers(std::get<decltype(type)::value>(lambda), 1); });
  }

  // m, of all types
  double residual() const {
    double worst = 0;
    for (const double r : residuals(bench.system)) worst = std::max(worst, r);
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
