// One step of 100 discs, solver by solver: errors after k iterations as an independent double-precision code found them.
// The discs fall as a block, 2 mm too deep in each other here and there: 200 candidate contacts, no friction, cold.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "small_worlds.hpp"

namespace unibody::small_worlds {

namespace {

constexpr double h = 0.016, g = 9.8;
constexpr double radius = 0.1;

struct Discs : Bench {
  Discs() {
    planar = true, gravity = Vec3(0, 0, -g), step = h;
    settings.friction = FrictionModel::disc;
    world.resize(103);
    world.homes = 100;
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i) {
        const int k = 10 * j + i;
        Body b =
            disc(1, radius, Vec3(.1 + .19 * i + .01 * std::sin(7 * j + 3 * i), 0, .1 + .19 * j + .01 * std::cos(5 * i + 2 * j)));
        b.id = k;
        b.state.velocity = Vec3(.1 * std::sin(i), 0, -1);  // by column
        world.set(static_cast<std::size_t>(k), b);
      }
    const Vec3 at[3] = {Vec3::Zero(), Vec3::Zero(), Vec3(3, 0, 0)}, up[3] = {Vec3::UnitZ(), Vec3::UnitX(), -Vec3::UnitX()};
    for (int p = 0; p < 3; ++p) {
      Body b = ground(at[p], up[p]);
      b.id = 100 + p;
      world.set(static_cast<std::size_t>(100 + p), b);
    }
    find_candidates();
  }

  // Pairs with gap < h (|v_i| + |v_j| + 0.2), walls with gap < h (|v_i| + 0.2).
  void find_candidates() {
    for (Slot i = 0; i < 100; ++i)
      for (Slot j = i + 1; j < 103; ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        Vec3 normal = world.position[a] - world.position[b];
        double gap = 0, reach = world.velocity[a].norm() + 0.2;
        if (j < 100) {
          gap = normal.norm() - 2 * radius, reach += world.velocity[b].norm();
          normal.normalize();
        } else {
          normal = world.orientation[b] * Vec3::UnitZ();
          gap = normal.dot(world.position[a] - world.position[b]) - radius;
        }
        if (gap >= h * reach) continue;
        contacts.manifolds.push_back(
            {world.id[a], world.id[b], i, j, normal, 0, static_cast<std::uint32_t>(contacts.points.size()), 1});
        contacts.points.push_back({world.position[a] - (radius + 0.5 * gap) * normal, gap, 0});
      }
  }

  // Euclidean norm of all penetrations at the predicted positions q + h v of the present velocities.
  double error() const {
    double sum = 0;
    for (const Manifold& m : contacts.manifolds) {
      const auto place = [&](Slot s) {
        return Vec3(world.position[static_cast<std::size_t>(s)] +
                    h * Eigen::Map<const Vec3>(system.bodies[static_cast<std::size_t>(s)].v));
      };
      const double gap = m.slot_b < 100
                             ? (place(m.slot_a) - place(m.slot_b)).norm() - 2 * radius
                             : m.normal.dot(place(m.slot_a) - world.position[static_cast<std::size_t>(m.slot_b)]) - radius;
      sum += std::pow(std::min(0.0, gap), 2);
    }
    return std::sqrt(sum);
  }

  double sum_of_forces() const {
    std::vector<ContactBatch::Impulse> all(contacts.points.size());
    system.contacts.get_impulses(all);
    double sum = 0;
    for (const auto& i : all) sum += i.n / h;
    return sum;
  }

  // Errors of the applied state after k = 0..50 iterations of one solve of 50.
  std::vector<double> errors(SolveFunction solve) {
    const Stage stage{Stage::Kind::position, h, 0, 0};
    build_for_jacobi();
    start(stage);
    std::vector<double> list;
    system.before_iteration = [&] {
      list.push_back(error());
      system.contacts.reevaluate(world, system.bodies, stage);
    };
    solve(system, cut, 50, 0);
    list.push_back(error());
    return list;
  }
};

struct Row {
  double k1, k2, k5, k10, k20, k50, sum;
};

void expect_row(const std::vector<double>& found, double sum, const Row& expected) {
  ASSERT_EQ(found.size(), 51u);
  EXPECT_NEAR(found[0], 2.213426378e-1, 1e-8 * 2.2e-1);
  const std::map<std::size_t, double> rows{{1, expected.k1},   {2, expected.k2},   {5, expected.k5},
                                           {10, expected.k10}, {20, expected.k20}, {50, expected.k50}};
  for (const auto& [k, value] : rows) EXPECT_NEAR(found[k], value, 1e-8 * value) << "after " << k << " iterations";
  EXPECT_NEAR(sum, expected.sum, 1e-8 * expected.sum);
}

}  // namespace

TEST(OneStep, HasTwoHundredCandidates) { EXPECT_EQ(Discs().contacts.manifolds.size(), 200u); }

TEST(OneStep, Jacobi) {
  Discs discs;
  const auto errors = discs.errors(jacobi);
  expect_row(errors, discs.sum_of_forces(),
             {1.806929385e-1, 1.565684391e-1, 1.380978735e-1, 1.330365960e-1, 1.271096716e-1, 1.140499065e-1, 4.564418285e4});
}

TEST(OneStep, AcceleratedJacobi) {
  Discs discs;
  const auto errors = discs.errors(accelerated_jacobi);
  expect_row(errors, discs.sum_of_forces(),
             {1.806929385e-1, 1.514097685e-1, 1.349644916e-1, 1.258213182e-1, 1.056729766e-1, 3.094319073e-2, 2.251563284e5});
}

// Each disc in turn: floor, left wall, right wall, then its later neighbours; never backwards.
TEST(OneStep, GaussSeidel) {
  Discs discs;
  std::vector<std::uint32_t> order(discs.contacts.manifolds.size());
  for (std::uint32_t m = 0; m < order.size(); ++m) order[m] = m;
  const auto place = [&](std::uint32_t m) {
    const Manifold& c = discs.contacts.manifolds[m];
    return std::pair(c.slot_a, c.slot_b >= 100 ? c.slot_b - 200 : c.slot_b);
  };
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return place(a) < place(b); });
  const Stage stage{Stage::Kind::position, h, 0, 0};
  discs.build_sequential(order);
  discs.start(stage);
  std::vector<double> errors{discs.error()};
  for (int k = 0; k < 50; ++k) {
    for (std::size_t m = 0; m < order.size(); ++m) {
      discs.system.contacts.reevaluate(discs.world, discs.system.bodies, stage);
      discs.system.contacts.relax(m, false, discs.system.bodies);
    }
    errors.push_back(discs.error());
  }
  expect_row(errors, discs.sum_of_forces(),
             {1.505463902e-1, 1.311665912e-1, 1.167830407e-1, 1.029419297e-1, 8.074531198e-2, 3.809218850e-2, 2.103641405e5});
}

}  // namespace unibody::small_worlds
