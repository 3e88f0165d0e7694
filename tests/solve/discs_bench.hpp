// Discs of 0.1 m and 1 kg between a floor and two walls, 3 m apart: steps of the solvers as an independent code takes them, with
// its candidates, its order of Gauss-Seidel, and its error after each iteration.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "small_worlds.hpp"

namespace unibody::small_worlds {

struct Discs : Bench {
  static constexpr double h = 0.016, g = 9.8, radius = 0.1;
  static constexpr Slot count = 100;
  double friction;

  // place, velocity: of the disc in column i of row j (m, m/s), 10 of each.
  Discs(double mu, const std::function<Vec3(int i, int j)>& place, const std::function<Vec3(int i, int j)>& velocity)
      : friction(mu) {
    planar = true, gravity = Vec3(0, 0, -g), step = h;
    settings.friction = FrictionModel::disc;
    world.resize(count + 3);
    world.homes = count;
    for (int k = 0; k < count; ++k) {
      Body b = disc(1, radius, place(k % 10, k / 10));
      b.id = k;
      b.state.velocity = velocity(k % 10, k / 10);
      world.set(static_cast<std::size_t>(k), b);
    }
    const Vec3 at[3] = {Vec3::Zero(), Vec3::Zero(), Vec3(3, 0, 0)}, up[3] = {Vec3::UnitZ(), Vec3::UnitX(), -Vec3::UnitX()};
    for (int p = 0; p < 3; ++p) {
      Body b = ground(at[p], up[p]);
      b.id = count + p;
      world.set(static_cast<std::size_t>(count + p), b);
    }
    find_candidates();
  }

  // Pairs with gap < h (|v_i| + |v_j| + 0.2), walls with gap < h (|v_i| + 0.2).
  void find_candidates() {
    contacts.manifolds.clear(), contacts.points.clear();
    for (Slot i = 0; i < count; ++i)
      for (Slot j = i + 1; j < count + 3; ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        Vec3 normal = world.position[a] - world.position[b];
        double gap = 0, reach = world.velocity[a].norm() + 0.2;
        if (j < count) {
          gap = normal.norm() - 2 * radius, reach += world.velocity[b].norm();
          normal.normalize();
        } else {
          normal = world.orientation[b] * Vec3::UnitZ();
          gap = normal.dot(world.position[a] - world.position[b]) - radius;
        }
        if (gap >= h * reach) continue;
        contacts.manifolds.push_back(
            {world.id[a], world.id[b], i, j, normal, friction, static_cast<std::uint32_t>(contacts.points.size()), 1});
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
      const double gap = m.slot_b < count
                             ? (place(m.slot_a) - place(m.slot_b)).norm() - 2 * radius
                             : m.normal.dot(place(m.slot_a) - world.position[static_cast<std::size_t>(m.slot_b)]) - radius;
      sum += std::pow(std::min(0.0, gap), 2);
    }
    return std::sqrt(sum);
  }

  double sum_of_forces() const {
    std::vector<ContactBatch::Impulse> all(contacts.points.size());
    system.contacts().get_impulses(all);
    double sum = 0;
    for (const auto& i : all) sum += i.n / h;
    return sum;
  }

  // Errors of the applied state after k = 0..50 iterations of one solve of 50.
  std::vector<double> errors(SolveFunction solve) {
    Stage stage{Stage::Kind::position, h, 0, 0};
    stage.reevaluates = true;
    build_for_jacobi();
    start(stage);
    std::vector<double> list;
    system.renews = true;
    system.observer = [&] { list.push_back(error()); };
    system.acceleration = Acceleration::nesterov;  // of which the figures are
    solve(system, exchange, 50, 0);
    list.push_back(error());
    return list;
  }

  // The same of Gauss-Seidel: each disc in turn, its floor, left wall, right wall, then its later neighbours; never backwards.
  // `gaps`: when the gaps are evaluated anew, before each contact, or, much faster and all but the same, before each sweep.
  enum class Gaps { each_contact, each_sweep };
  std::vector<double> errors_of_gauss_seidel(Gaps gaps) {
    std::vector<std::uint32_t> order(contacts.manifolds.size());
    for (std::uint32_t m = 0; m < order.size(); ++m) order[m] = m;
    const auto place = [&](std::uint32_t m) {
      const Manifold& c = contacts.manifolds[m];
      return std::pair(c.slot_a, c.slot_b >= count ? c.slot_b - 2 * count : c.slot_b);
    };
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return place(a) < place(b); });
    const Stage stage{Stage::Kind::position, h, 0, 0};
    build_sequential(order);
    start(stage);
    std::vector<double> list{error()};
    for (int k = 0; k < 50; ++k) {
      for (std::size_t m = 0; m < order.size(); ++m) {
        if (m == 0 || gaps == Gaps::each_contact) system.contacts().reevaluate(system.bodies);
        system.contacts().relax(m, false, system.bodies);
      }
      list.push_back(error());
    }
    return list;
  }

  // Takes the bodies where the velocities just found lead, and finds the next step's candidates.
  void move() {
    for (std::size_t i = 0; i < world.homes; ++i)
      world.set_state(i, finish_motion(world.properties[i], world.state(i), system.bodies[i], Vec3::Zero(), h, true));
    find_candidates();
  }
};

}  // namespace unibody::small_worlds
