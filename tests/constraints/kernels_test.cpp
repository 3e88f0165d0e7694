// The contact kernels against a plain scalar implementation on dense matrices, and against finite differences.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "constraints/dense_system.hpp"
#include "constraints/friction.hpp"
#include "constraints/random_bench.hpp"

namespace unibody::small_worlds::kernels_test {

namespace {

constexpr FrictionModel models[] = {FrictionModel::disc, FrictionModel::cone, FrictionModel::saxce, FrictionModel::box,
                                    FrictionModel::none};
constexpr std::uint64_t seeds[] = {1, 2, 3, 4, 5};

// The projections, written once more, for one point.
Vec3 project_plain(FrictionModel model, const Vec3& y, double mu) {
  const double length = std::hypot(y[1], y[2]);
  if (model == FrictionModel::cone || model == FrictionModel::saxce) {
    if (y[0] >= 0 && length <= mu * y[0]) return y;
    if (mu * length <= -y[0]) return Vec3::Zero();
    const double n = (y[0] + mu * length) / (1 + mu * mu);
    return {n, mu * n * y[1] / length, mu * n * y[2] / length};
  }
  Vec3 p(std::max(0.0, y[0]), y[1], y[2]);
  const double limit = mu * p[0];
  if (model == FrictionModel::none) p.tail<2>().setZero();
  if (model == FrictionModel::disc && length > limit) p.tail<2>() *= limit / length;
  if (model == FrictionModel::box) p[1] = std::clamp(y[1], -limit, limit), p[2] = std::clamp(y[2], -limit, limit);
  return p;
}

double mu_of(const Bench& bench, std::size_t point) {
  for (const Manifold& m : bench.contacts.manifolds)
    if (point >= m.first && point < m.first + m.count) return m.friction;
  return 0;
}

const Stage stage{Stage::Kind::position, 0.016, 0.016, 0.25};

double bias_plain(double gap) { return gap >= 0 ? gap / 0.016 : -std::min(-gap / 0.032, 0.25); }

// A plain step of a point's three multipliers from y, at row velocities u.
Vec3 step_plain(FrictionModel model, const Vec3& y, const Vec3& u, double bias, double mu, double inverse_n, double inverse_t) {
  double r = bias + u[0];
  if (model == FrictionModel::saxce) r += mu * std::hypot(u[1], u[2]);
  return project_plain(model, {y[0] - inverse_n * r, y[1] - inverse_t * u[1], y[2] - inverse_t * u[2]}, mu);
}

void expect_close(const Eigen::VectorXd& found, const Eigen::VectorXd& expected, double tolerance) {
  EXPECT_LT((found - expected).lpNorm<Eigen::Infinity>(), tolerance * (1 + expected.lpNorm<Eigen::Infinity>()));
}

}  // namespace

// D u is the rate at which the two bodies' material points move apart: central differences of the points' places.
TEST(ContactRows, AreTheRatesOfMotionOfTheBodiesPoints) {
  const auto bench = random_bench(1, FrictionModel::disc);
  bench->build_for_jacobi();
  const Dense dense(*bench);
  const double dt = 1e-5;
  for (const Manifold& m : bench->contacts.manifolds)
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      const auto moved = [&](Slot slot, double t) {
        const auto s = static_cast<std::size_t>(slot);
        const Vec3 v = Eigen::Map<const Vec3>(bench->system.bodies[s].v), w = Eigen::Map<const Vec3>(bench->system.bodies[s].w);
        const Vec3 arm = arm_to(*bench, m, bench->contacts.points[k], slot);
        const Mat3 turn =
            w.norm() > 0 ? Eigen::AngleAxisd(w.norm() * t, w.normalized()).toRotationMatrix() : Mat3(Mat3::Identity());
        return Vec3(bench->world.position[s] + t * v + turn * arm);
      };
      const Vec3 rate = (moved(m.slot_a, dt) - moved(m.slot_a, -dt) - moved(m.slot_b, dt) + moved(m.slot_b, -dt)) / (2 * dt);
      const Vec3 s = first_tangent_of(m.normal), axes[3] = {m.normal, s, m.normal.cross(s)};
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(dense.D.row(3 * static_cast<Eigen::Index>(k) + d).dot(dense.u), rate.dot(axes[d]), 1e-7);
    }
}

// Applying multipliers changes the velocities by W D^T lambda; a static body's stay.
TEST(ContactKernels, ApplyImpulses) {
  for (const std::uint64_t seed : seeds) {
    const auto bench = random_bench(seed, FrictionModel::disc);
    bench->build_for_jacobi();
    const Dense dense(*bench);
    unibody::samples::Random random(seed);
    std::vector<ContactBatch::Impulse> impulses;
    Eigen::VectorXd lambda(3 * static_cast<Eigen::Index>(bench->contacts.points.size()));
    for (std::size_t p = 0; p < bench->contacts.points.size(); ++p) {
      impulses.push_back({random(0, 1), random(-1, 1), random(-1, 1)});
      lambda.segment<3>(3 * static_cast<Eigen::Index>(p)) = Vec3(impulses[p].n, impulses[p].s, impulses[p].t);
    }
    bench->start(stage);
    bench->system.contacts().set_impulses(impulses);
    // A block without friction carries normal impulses only.
    const auto carried = impulses_of(*bench);
    for (std::size_t p = 0; p < carried.size(); ++p) {
      EXPECT_EQ(carried[p].n, impulses[p].n);
      lambda.segment<2>(3 * static_cast<Eigen::Index>(p) + 1) = Eigen::Vector2d(carried[p].s, carried[p].t);
    }
    EXPECT_GT(lambda.norm(), 0);
    bench->system.contacts().add_impulses(bench->system.wrenches);
    bench->system.apply_wrenches();
    expect_close(Dense::velocities(*bench), dense.u + dense.W * dense.D.transpose() * lambda, 1e-13);
  }
}

TEST(ContactKernels, JacobiSweepIsThePlainOne) {
  for (const FrictionModel model : models)
    for (const std::uint64_t seed : seeds) {
      const auto bench = random_bench(seed, model);
      bench->build_for_jacobi();
      const Dense dense(*bench);
      const Eigen::VectorXd inverse = inverse_scales(*bench);
      bench->start(stage);
      const auto points = bench->contacts.points.size();
      std::vector<Vec3> lambda(points, Vec3::Zero()), y = lambda;
      Eigen::VectorXd u = dense.u;
      for (const Extrapolation extrapolation : {Extrapolation{}, {0.3}, {0.7, 0.6}, {}}) {
        const Eigen::VectorXd rows = dense.D * u;
        Eigen::VectorXd dy(3 * static_cast<Eigen::Index>(points));
        double gradient = 0, progress = 0;
        for (std::size_t p = 0; p < points; ++p) {
          const auto row = 3 * static_cast<Eigen::Index>(p);
          const double bias = bias_plain(bench->contacts.points[p].gap);
          const Vec3 next = step_plain(model, y[p], rows.segment<3>(row), bias, mu_of(*bench, p), inverse[row], inverse[row + 1]);
          const Vec3 next_y = next + extrapolation.momentum * (next - lambda[p]) + extrapolation.overshoot * (next - y[p]);
          gradient += (rows.segment<3>(row) + Vec3(bias, 0, 0)).dot(next - lambda[p]);
          for (int d = 0; d < 3; ++d)
            if (inverse[row + d] > 0) progress += std::pow(next[d] - y[p][d], 2) / inverse[row + d];
          dy.segment<3>(row) = next_y - y[p];
          lambda[p] = next, y[p] = next_y;
        }
        u += dense.W * dense.D.transpose() * dy;

        SweepSums sums;
        sums.unit = 0x1p-30;
        bench->system.contacts().sweep(bench->system, extrapolation, sums);
        bench->system.apply_wrenches();
        EXPECT_NEAR(static_cast<double>(sums.progress) * sums.unit, progress, 1e-8 + 1e-12 * progress);
        EXPECT_NEAR(static_cast<double>(sums.gradient) * sums.unit, gradient, 1e-8 + 1e-12 * std::abs(gradient));
      }
      expect_close(Dense::velocities(*bench), u, 1e-13);
      const auto found = impulses_of(*bench);
      for (std::size_t p = 0; p < points; ++p)
        EXPECT_LT((Vec3(found[p].n, found[p].s, found[p].t) - lambda[p]).norm(), 1e-13 * (1 + lambda[p].norm()));
    }
}

// Gauss-Seidel: normal first, then both tangents with the velocities that it leaves; cone models take all three at once.
TEST(ContactKernels, RelaxationIsThePlainOne) {
  for (const FrictionModel model : models)
    for (const std::uint64_t seed : seeds) {
      const auto bench = random_bench(seed, model);
      std::vector<std::uint32_t> order(bench->contacts.manifolds.size());
      std::iota(order.begin(), order.end(), 0);
      std::shuffle(order.begin(), order.end(), std::mt19937_64(seed));
      bench->build_sequential(order);
      const Dense dense(*bench);
      const Eigen::VectorXd inverse = inverse_scales(*bench);
      bench->start(stage);
      const auto points = bench->contacts.points.size();
      std::vector<Vec3> lambda(points, Vec3::Zero());
      Eigen::VectorXd u = dense.u;
      const auto apply = [&](Eigen::Index row, const Vec3& change) {
        u += dense.W * dense.D.middleRows<3>(row).transpose() * change;
      };
      for (const bool backwards : {false, true, false}) {
        for (std::size_t i = 0; i < order.size(); ++i) {
          const std::size_t g = backwards ? order.size() - 1 - i : i;
          const Manifold& m = bench->contacts.manifolds[order[g]];
          for (std::uint32_t j = 0; j < m.count; ++j) {
            const std::uint32_t p = m.first + (backwards ? m.count - 1 - j : j);
            const auto row = 3 * static_cast<Eigen::Index>(p);
            const double bias = bias_plain(bench->contacts.points[p].gap);
            const Vec3 old = lambda[p];
            Vec3 rows = dense.D.middleRows<3>(row) * u;
            if (uses_cone_projection(model) && inverse[row + 1] > 0) {
              lambda[p] = step_plain(model, old, rows, bias, m.friction, inverse[row], inverse[row + 1]);
              apply(row, lambda[p] - old);
              continue;
            }
            const double n = std::max(0.0, old[0] - inverse[row] * (bias + rows[0]));
            apply(row, Vec3(n - old[0], 0, 0));
            rows = dense.D.middleRows<3>(row) * u;
            lambda[p] =
                project_plain(model, {n, old[1] - inverse[row + 1] * rows[1], old[2] - inverse[row + 1] * rows[2]}, m.friction);
            apply(row, Vec3(0, lambda[p][1] - old[1], lambda[p][2] - old[2]));
          }
          bench->system.contacts().relax(g, backwards, bench->system.bodies);
        }
      }
      expect_close(Dense::velocities(*bench), u, 1e-13);
      const auto found = impulses_of(*bench);
      for (std::size_t p = 0; p < points; ++p)
        EXPECT_LT((Vec3(found[p].n, found[p].s, found[p].t) - lambda[p]).norm(), 1e-13 * (1 + lambda[p].norm()));
    }
}

// The residual is the largest step that a projected gradient of step 1/K of the point alone would take.
TEST(ContactKernels, ResidualIsThePlainOne) {
  for (const FrictionModel model : {FrictionModel::disc, FrictionModel::none})
    for (const std::uint64_t seed : seeds) {
      const auto bench = random_bench(seed, model);
      bench->build_for_jacobi();
      bench->start(stage);
      jacobi(bench->system, bench->exchange, 3, 0);
      const Dense dense(*bench);  // with the velocities as they are now
      const Eigen::MatrixXd N = dense.N();
      const auto lambda = impulses_of(*bench);
      double worst = 0;
      for (std::size_t p = 0; p < lambda.size(); ++p) {
        const auto row = 3 * static_cast<Eigen::Index>(p);
        const double K_n = N(row, row), coupling = std::abs(N(row + 1, row + 2));
        const double K_t = std::max(N(row + 1, row + 1), N(row + 2, row + 2)) + coupling;
        const Vec3 from(lambda[p].n, lambda[p].s, lambda[p].t);
        const Vec3 next = step_plain(model, from, dense.D.middleRows<3>(row) * dense.u, bias_plain(bench->contacts.points[p].gap),
                                     mu_of(*bench, p), 1 / K_n, 1 / K_t);
        worst = std::max({worst, K_n * std::abs(next[0] - from[0]), K_t * (next - from).tail<2>().norm()});
      }
      EXPECT_GT(worst, 1e-3);
      EXPECT_NEAR(bench->system.contacts().residual(bench->system.bodies), 0.016 * worst, 1e-12);
    }
}

// Where a manifold stands in a block, and with whom, changes no bit of a Gauss-Seidel pass over manifolds that share no body.
TEST(ContactKernels, GroupingChangesNoBit) {
  const auto pairs = [](const std::vector<std::uint32_t>& order, bool alone) {
    auto bench = random_bench(11, FrictionModel::disc, 12, 20);
    auto& manifolds = bench->contacts.manifolds;
    // Manifolds that share no moving body: 0-1, 2-3, ...
    const Contacts old = bench->contacts;
    bench->contacts.clear();
    for (std::uint32_t k = 0; k < 6; ++k) {
      Manifold m = old.manifolds[k];
      m.id_a = m.slot_a = static_cast<Slot>(2 * k), m.id_b = m.slot_b = static_cast<Slot>(2 * k + 1);
      const auto first = static_cast<std::uint32_t>(bench->contacts.points.size());
      for (std::uint32_t p = 0; p < m.count; ++p) bench->contacts.points.push_back(old.points[m.first + p]);
      m.first = first;
      manifolds.push_back(m);
    }
    bench->build_sequential(order);
    if (!alone) {
      const std::vector<std::uint32_t> one{static_cast<std::uint32_t>(order.size())};
      bench->build(order, one);
    }
    bench->start(stage);
    for (int k = 0; k < 5; ++k)
      for (std::size_t g = 0; g < bench->system.contacts().group_count(); ++g)
        bench->system.contacts().relax(g, k % 2 == 1, bench->system.bodies);
    std::vector<double> bits;
    for (std::size_t b = 0; b < 12; ++b)
      for (int i = 0; i < 3; ++i) bits.push_back(bench->system.bodies[b].v[i]), bits.push_back(bench->system.bodies[b].w[i]);
    return bits;
  };
  const auto reference = pairs({0, 1, 2, 3, 4, 5}, true);
  for (const std::vector<std::uint32_t>& order :
       {std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}, {5, 3, 1, 0, 2, 4}, {2, 0, 5, 4, 3, 1}}) {
    const auto found = pairs(order, false);
    EXPECT_EQ(std::memcmp(found.data(), reference.data(), found.size() * sizeof(double)), 0);
  }
}

// One row a point, in memory too: nothing is kept for tangents of blocks without friction. Beside blocks with it: theirs alone.
TEST(ContactRows, APointWithoutFrictionHasOne) {
  constexpr std::uint32_t pairs = 8;  // two blocks
  for (const std::uint32_t rough : {0u, 4u, 8u})
    for (const auto model : {FrictionModel::disc, FrictionModel::none})
      for (const bool gauss_seidel : {false, true}) {
        Bench bench;
        bench.settings.friction = model;
        bench.world.homes = pairs;
        bench.world.resize(pairs + 1);
        Body floor = ground();
        floor.id = pairs;
        bench.world.set(pairs, floor);
        for (std::uint32_t k = 0; k < pairs; ++k) {
          Body box = block(1, Vec3::Ones(), Vec3(2 * k, 0, 0.5));
          box.id = k;
          bench.world.set(k, box);
          const auto slot = static_cast<Slot>(k);
          bench.contacts.manifolds.push_back({k, pairs, slot, pairs, Vec3::UnitZ(), k < rough ? 0.5 : 0, 4 * k, 4});
          for (std::uint32_t p = 0; p < 4; ++p)
            bench.contacts.points.push_back({Vec3(2 * k + (p & 1 ? 0.5 : -0.5), p & 2 ? 0.5 : -0.5, 0), 0, p});
        }
        bench.build_for_jacobi();
        if (gauss_seidel) {
          const std::vector<std::uint32_t> order{0, 1, 2, 3, 4, 5, 6, 7}, groups{4, 8};
          bench.system.contacts() = ContactBatch();
          bench.system.counts.clear();
          bench.build(order, groups);
        }
        const ContactBatch& batch = bench.system.contacts();
        const std::size_t tangents = model == FrictionModel::none ? 0 : rough;  // 4 points in 4 lanes for 4 pairs
        EXPECT_EQ(batch.points.size(), pairs);
        EXPECT_EQ(batch.points.capacity(), pairs);
        EXPECT_EQ(batch.tangents.capacity(), tangents);
        EXPECT_EQ(batch.tangents.size(), tangents);
        EXPECT_EQ(batch.tangent_impulses.capacity(), tangents);
        EXPECT_EQ(batch.couplings.capacity(), gauss_seidel ? tangents : 0);
        EXPECT_EQ(batch.tangent_momenta.capacity(), gauss_seidel ? 0 : tangents);
      }
}

}  // namespace unibody::small_worlds::kernels_test
