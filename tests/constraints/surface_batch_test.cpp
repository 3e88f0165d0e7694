// Contacts between means of bodies: the batch against closed forms, direct solves and its own matrix, written out in full.
#include "constraints/surface_batch.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "collide/bodies.hpp"
#include "constraints/dense_system.hpp"

namespace unibody::small_worlds::surface_batch_test {

namespace {

using unibody::samples::Random;

constexpr double h = 0.016;

Body node(double mass, const Vec3& position, Motion motion = Motion::dynamic) {
  Body b;
  b.properties.shape = {ShapeKind::particle, Vec3(0.005, 0, 0)};
  b.properties.mass = mass, b.properties.inertia = Vec3::Ones(), b.properties.motion = motion;  // nothing turns it
  b.state.position = position;
  return b;
}

struct SurfaceBench : Bench {
  std::vector<std::int32_t> counts;

  void set(const std::vector<Body>& bodies) {
    world.resize(bodies.size());
    world.homes = bodies.size();  // what is pinned as well
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Body numbered = bodies[i];
      numbered.id = static_cast<Id>(i);
      world.set(i, numbered);
    }
  }
  void build() {
    build_for_jacobi();
    counts.assign(world.size() + 1, 0);
    for (const SurfaceContact& c : contacts.surface)
      for (const Slot s : c.slots)
        if (s >= 0) ++counts[static_cast<std::size_t>(s)];
    build_list(contacts.surface);
  }
  void build_list(std::vector<SurfaceContact> list) {
    std::swap(contacts.surface, list);
    system.counts.assign(counts.begin(), counts.end());
    BuildContext input = context();
    input.has_surfaces = true;
    system.batch<SurfaceBatch>().build(input);
    std::swap(contacts.surface, list);
  }
  void solve(const Stage& stage, int iterations) {
    start(stage);
    system.batch<SurfaceBatch>().start_stage(stage);
    system.step = step;
    accelerated_jacobi(system, exchange, iterations, 0);
  }
};

Stage unbounded(Stage::Kind kind) { return {kind, h, h, 0}; }

SurfaceContact contact(std::array<Slot, 4> slots, std::array<double, 4> weights, const Vec3& arm, const Vec3& normal, double gap,
                       double friction) {
  SurfaceContact c{{-1, -1, -1, -1}, 0, slots, weights, arm, normal, gap, friction, 0};
  for (std::size_t k = 0; k < 4; ++k) c.ids[k] = slots[k];
  return c;
}

// D of one contact's rows n, s, t: velocities of all bodies, 6 a body, to that at which the sides part.
Eigen::MatrixXd rows_of(const SurfaceContact& c, std::size_t bodies) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(3, 6 * static_cast<Eigen::Index>(bodies));
  const Vec3 s = first_tangent_of(c.normal), axes[3] = {c.normal, s, c.normal.cross(s)};
  for (int d = 0; d < 3; ++d) {
    for (std::size_t k = 0; k < 4; ++k)
      if (c.slots[k] >= 0) D.block<1, 3>(d, 6 * c.slots[k]) += c.weights[k] * axes[d].transpose();
    D.block<1, 3>(d, 6 * c.slots[0] + 3) = c.arm.cross(axes[d]).transpose();
  }
  return D;
}

struct DenseSurface {
  Eigen::MatrixXd D, W;
  explicit DenseSurface(const SurfaceBench& bench) : W(Dense(bench).W) {
    const std::size_t n = bench.contacts.surface.size();
    D.resize(3 * static_cast<Eigen::Index>(n), W.rows());
    for (std::size_t i = 0; i < n; ++i)
      D.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = rows_of(bench.contacts.surface[i], bench.world.size());
  }
  Eigen::MatrixXd N() const { return D * W * D.transpose(); }
};

// Spheres, boxes and nodes of all masses, some nodes pinned, and contacts of all kinds of weights where chance puts them. The two
// points of a contact are at the same place.
std::unique_ptr<SurfaceBench> random_surface(std::uint64_t seed, FrictionModel model, int count, double friction = -1) {
  Random random(seed);
  auto bench = std::make_unique<SurfaceBench>();
  bench->settings.friction = model;
  std::vector<Body> bodies;
  const auto mass = [&] { return std::pow(10, random(-1, 1)); };
  for (int k = 0; k < 3; ++k) bodies.push_back(ball(mass(), random(0.1, 0.3), random.vector(-1, 1)));
  for (int k = 0; k < 3; ++k)
    bodies.push_back(block(mass(), Vec3(random(.1, .5), random(.1, .5), random(.1, .5)), random.vector(-1, 1), random.turn()));
  for (int k = 0; k < 10; ++k)
    bodies.push_back(node(mass(), random.vector(-1, 1), random(0, 1) < 0.2 ? Motion::pinned : Motion::dynamic));
  for (Body& b : bodies)
    if (b.properties.is_dynamic()) b.state.velocity = random.vector(-1, 1);
  for (int k = 0; k < count; ++k) {
    std::vector<Slot> nodes;
    while (nodes.size() < 4) {
      const auto s = static_cast<Slot>(random(6, 16));
      if (std::find(nodes.begin(), nodes.end(), s) == nodes.end()) nodes.push_back(s);
    }
    const double a = random(0.05, 0.95), b = random(0.05, 0.95) * (1 - a);
    const Vec3 normal = random.vector(-1, 1).normalized();
    const double mu = friction >= 0 ? friction : random(0, 1) < 0.2 ? 0 : random(0.1, 1), gap = random(-.01, .02);
    const auto place = [&](Slot s) { return bodies[static_cast<std::size_t>(s)].state.position; };
    SurfaceContact c;
    if (k % 3 == 0) {  // two edges
      c = contact({nodes[0], nodes[1], nodes[2], nodes[3]}, {a, 1 - a, -b, b - 1}, Vec3::Zero(), normal, gap, mu);
    } else {
      const auto first = k % 3 == 1 ? static_cast<Slot>(random(0, 6)) : nodes[0];
      c = contact({first, nodes[1], nodes[2], nodes[3]}, {1, -a, -b, a + b - 1}, Vec3::Zero(), normal, gap, mu);
      if (k % 2) c.slots[3] = c.ids[3] = -1, c.weights = {1, -a, a - 1, 0};
      Vec3 point = Vec3::Zero();
      for (std::size_t i = 1; i < 4; ++i)
        if (c.slots[i] >= 0) point -= c.weights[i] * place(c.slots[i]);
      if (k % 3 == 1) c.arm = point - place(first);
    }
    bench->contacts.surface.push_back(c);
  }
  bench->set(bodies);
  bench->build();
  return bench;
}

// 1/P of a contact's rows, from what one sweep makes of a push along each: alone in a batch, but with the counts of all.
Eigen::Vector3d inverse_scale_of(SurfaceBench& bench, SurfaceContact c) {
  const bool rough = c.friction > 0 && bench.settings.friction != FrictionModel::none;
  if (rough) c.friction = 1e12;  // its size plays no part in the scale
  c.gap = -2 * h;
  const std::vector<SolverBody> kept(bench.system.bodies.begin(), bench.system.bodies.end());
  const Vec3 s = first_tangent_of(c.normal);
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (const bool tangential : {false, true}) {
    if (tangential && !rough) continue;
    for (SolverBody& b : bench.system.bodies) std::fill(b.v, b.v + 3, 0), std::fill(b.w, b.w + 3, 0);
    bench.build_list({c});
    bench.system.batch<SurfaceBatch>().start_stage(unbounded(Stage::Kind::position));  // bias gap / 2h = -1 m/s
    for (int d = 0; d < 3 && tangential; ++d)
      bench.system.bodies[static_cast<std::size_t>(c.slots[0])].v[d] = -s[d] / c.weights[0];
    SweepSums sums;
    bench.system.batch<SurfaceBatch>().sweep(bench.system, {}, sums);
    const Vec4d f = bench.system.wrenches[static_cast<std::size_t>(c.slots[0])].force;
    const Vec3 impulse = Vec3(f[0], f[1], f[2]) / c.weights[0];
    if (tangential)
      inverse[1] = inverse[2] = impulse.dot(s);
    else
      inverse[0] = impulse.dot(c.normal);
    bench.system.wrenches.assign(bench.world.size() + 1, Wrench{});
  }
  std::copy(kept.begin(), kept.end(), bench.system.bodies.begin());
  return inverse;
}

}  // namespace

// v' = -gap / h along the normal for an open gap, 0 for one that is closed in the velocity stage; the nodes are pinned.
TEST(SurfaceBatch, BallOnAPinnedTriangle) {
  for (const double gap : {0.004, 0.0, -0.004})
    for (const auto kind : {Stage::Kind::velocity, Stage::Kind::position})
      for (const double beyond : {0.0, 0.01}) {
        SurfaceBench bench;
        Body b = ball(2, 0.1, Vec3(0, 0, 0.1 + gap));
        b.state.velocity = Vec3(0, 0, -3);
        bench.set(
            {b, node(1, {1, 0, 0}, Motion::pinned), node(1, {-1, 1, 0}, Motion::pinned), node(1, {-1, -1, 0}, Motion::pinned)});
        bench.contacts.surface = {contact({0, 1, 2, 3}, {1, -.5, -.25, -.25}, Vec3(0, 0, -0.1 - gap), Vec3::UnitZ(), gap, 0)};
        bench.contacts.surface[0].beyond = beyond;
        bench.build();
        const Stage bounded{kind, h, h, 0.1};
        bench.solve(bounded, 20);
        const bool position = kind == Stage::Kind::position;
        double expected = gap > 0 ? -gap / h : position ? std::min(-gap / (2 * h), 0.1) : 0;
        if (position && beyond > 0) expected = beyond / h;  // in one step, whatever the bound
        EXPECT_NEAR(bench.system.bodies[0].v[2], expected, 1e-12) << gap << ' ' << position << ' ' << beyond;
        EXPECT_NEAR(bench.system.batch<SurfaceBatch>().residual(bench.system), 0, 1e-14);
      }
}

// Without friction: of all sets of contacts that may press, the one that satisfies Signorini's conditions.
TEST(SurfaceBatch, FrictionlessContactsConvergeToTheDirectSolve) {
  std::size_t pressing = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    constexpr int n = 6;
    const auto bench = random_surface(seed, FrictionModel::none, n);
    const DenseSurface dense(*bench);
    const Stage stage = unbounded(Stage::Kind::position);
    Eigen::MatrixXd D(n, dense.D.cols());
    Eigen::VectorXd r(n);
    const Eigen::VectorXd u = Dense::velocities(*bench);
    for (int i = 0; i < n; ++i) {
      D.row(i) = dense.D.row(3 * i);
      r[i] = D.row(i).dot(u) + stage.bias(bench->contacts.surface[static_cast<std::size_t>(i)].gap);
    }
    const Eigen::MatrixXd N = D * dense.W * D.transpose();
    Eigen::VectorXd exact;
    for (unsigned set = 0; set < 1u << n && exact.size() == 0; ++set) {
      Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
      Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
      for (int i = 0; i < n; ++i)
        if (set >> i & 1) A.row(i) = N.row(i), b[i] = -r[i];
      const Eigen::VectorXd lambda = A.fullPivLu().solve(b);
      if (lambda.minCoeff() < -1e-12 || (N * lambda + r).minCoeff() < -1e-9) continue;
      exact = u + dense.W * D.transpose() * lambda;
      pressing += static_cast<std::size_t>(std::popcount(set)), open += static_cast<std::size_t>(n - std::popcount(set));
    }
    ASSERT_GT(exact.size(), 0) << seed;
    bench->system.batch<SurfaceBatch>().start_stage(stage);
    const bool solved = r.minCoeff() >= 0;
    EXPECT_EQ(bench->system.batch<SurfaceBatch>().residual(bench->system) < 1e-12, solved) << seed;
    bench->solve(stage, 4000);
    EXPECT_LT((Dense::velocities(*bench) - exact).cwiseAbs().maxCoeff(), 1e-9) << seed;
    EXPECT_LT(bench->system.batch<SurfaceBatch>().residual(bench->system), 1e-11) << seed;
  }
  EXPECT_GT(pressing, 20u);
  EXPECT_GT(open, 20u);
}

// Where the two points coincide an impulse is a force and its opposite at one place: momentum and angular momentum stay, whether
// or not the solve has converged, but for what pinned nodes take; with all friction models.
TEST(SurfaceBatch, ImpulsesKeepMomentumAndAngularMomentum) {
  for (const auto model : {FrictionModel::disc, FrictionModel::cone, FrictionModel::saxce, FrictionModel::box})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      auto bench = random_surface(seed, model, 9);
      for (std::size_t i = 0; i < bench->world.size(); ++i)
        if (!bench->world.properties[i].is_dynamic()) {
          BodyProperties free = bench->world.properties[i];
          free.motion = Motion::dynamic;
          bench->world.properties.set(i, free);
        }
      bench->build();
      const auto momentum = [&] {
        Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
        for (std::size_t i = 0; i < bench->world.size(); ++i) {
          const BodyProperties& p = bench->world.properties[i];
          const Vec3 v(bench->system.bodies[i].v), w(bench->system.bodies[i].w);
          const Mat3 R = bench->world.orientation[i].toRotationMatrix();
          sum.head<3>() += p.mass * v;
          sum.tail<3>() += p.mass * bench->world.position[i].cross(v) + R * p.inertia.asDiagonal() * R.transpose() * w;
        }
        return sum;
      };
      // Two edges here cross at two different places: they keep momentum, and angular momentum along their normal's line only.
      auto& list = bench->contacts.surface;
      for (auto& c : list)
        if (c.weights[1] > 0 || (c.arm.isZero() && c.weights[0] == 1)) {
          Vec3 apart = Vec3::Zero();
          for (std::size_t k = 0; k < 4; ++k)
            if (c.slots[k] >= 0) apart += c.weights[k] * bench->world.position[static_cast<std::size_t>(c.slots[k])];
          c.normal = apart.normalized(), c.friction = 0;
        }
      bench->build();
      const auto before = momentum();
      bench->solve(unbounded(Stage::Kind::position), 7);
      EXPECT_LT((momentum() - before).cwiseAbs().maxCoeff(), 1e-12) << seed;
      EXPECT_GT(
          (Dense::velocities(*bench) - Dense(*bench).u).norm() + bench->system.batch<SurfaceBatch>().residual(bench->system), 0);
    }
}

// No eigenvalue of P^-1 N above 1, so that a sweep over all at once is safe; the plain diagonal, the control, is far above.
TEST(SurfaceBatch, StepLengthsAreSafe) {
  double largest = 0, diagonal = 0;
  for (const auto model : {FrictionModel::disc, FrictionModel::cone, FrictionModel::none})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto bench = random_surface(seed, model, 20);
      const Eigen::MatrixXd N = DenseSurface(*bench).N();
      Eigen::VectorXd inverse(N.rows());
      for (std::size_t i = 0; i < bench->contacts.surface.size(); ++i)
        inverse.segment<3>(3 * static_cast<Eigen::Index>(i)) = inverse_scale_of(*bench, bench->contacts.surface[i]);
      ASSERT_GT(inverse.maxCoeff(), 0);
      EXPECT_LE(spectral_radius(N, inverse), 1 + 1e-12) << "seed " << seed;
      largest = std::max(largest, spectral_radius(N, inverse));
      diagonal = std::max(diagonal, spectral_radius(N, N.diagonal().cwiseMax(1e-300).cwiseInverse()));
    }
  EXPECT_GT(largest, 0.3) << "and not needlessly short";
  EXPECT_GT(diagonal, 3);
}

// A grain pushed sideways on a free triangle: it sticks to it, or slides at the limit of friction; both stages together count.
TEST(SurfaceBatch, FrictionAndWhatCountsAsSliding) {
  for (const double mu : {0.2, 0.8})
    for (const bool joint : {false, true}) {
      SurfaceBench bench;
      const double m = 2, M = 3;  // of each node, at the centre of which the grain is: (1/m + 1/(3 M))
      Body grain = node(m, Vec3::Zero());
      grain.state.velocity = Vec3(0.5, 0, -1);
      bench.set({grain, node(M, {1, 0, 0}), node(M, {-1, 1, 0}), node(M, {-1, -1, 0})});
      bench.contacts.surface = {contact({0, 1, 2, 3}, {1, -1. / 3, -1. / 3, -1. / 3}, Vec3::Zero(), Vec3::UnitZ(), 0, mu)};
      bench.build();
      bench.solve(unbounded(Stage::Kind::velocity), 100);
      bench.system.batch<SurfaceBatch>().keep_impulses(joint);
      bench.system.batch<SurfaceBatch>().start_stage(unbounded(Stage::Kind::position));
      accelerated_jacobi(bench.system, bench.exchange, 100, 0);
      const double K = 1 / m + 1 / (3 * M), normal = 1 / K, stick = 0.5 / K, side = std::min(stick, mu * normal);
      EXPECT_NEAR(bench.system.bodies[0].v[0], 0.5 - side / m, 1e-10);
      EXPECT_NEAR(bench.system.bodies[0].v[2], -1 + normal / m, 1e-10);
      for (std::size_t k = 1; k < 4; ++k) {
        EXPECT_NEAR(bench.system.bodies[k].v[0], side / (3 * M), 1e-10);
        EXPECT_NEAR(bench.system.bodies[k].v[2], -normal / (3 * M), 1e-10);
      }
      EXPECT_EQ(bench.system.batch<SurfaceBatch>().sliding(), mu < 0.5 ? 1 : 0);
    }
}

}  // namespace unibody::small_worlds::surface_batch_test
