// Step lengths of the Jacobi solvers: no eigenvalue of P^-1 N above 1, on boxes in the arrangements that are worst for it. N is
// written out in full; the plain diagonal, which the literature suggests, is the control: far above 1.
#include <gtest/gtest.h>

#include "constraints/dense_system.hpp"
#include "constraints/random_bench.hpp"
#include "solve/elastic_bench.hpp"
#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::scaling_test {

namespace {

// Unit boxes on a kinematic ground; every touching pair of faces has its four corners as contact points.
std::unique_ptr<Bench> grid(int nx, int ny, int nz, const std::function<double(int)>& mass, FrictionModel model) {
  auto bench = std::make_unique<Bench>();
  bench->settings.friction = model;
  const int n = nx * ny * nz;
  bench->world.homes = static_cast<std::size_t>(n);
  bench->world.resize(static_cast<std::size_t>(n) + 1);
  for (int k = 0; k < n; ++k) {
    Body b = block(mass(k), Vec3(1, 1, 1), Vec3(k % nx, k / nx % ny, k / (nx * ny) + 0.5));
    b.id = k;
    bench->world.set(static_cast<std::size_t>(k), b);
  }
  Body floor = ground();
  floor.id = n;
  bench->world.set(static_cast<std::size_t>(n), floor);
  const auto face = [&](Slot a, Slot b, int axis) {  // b beyond a along the axis, or the ground below a
    Contacts& c = bench->contacts;
    const Vec3 normal = b == n ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::Unit(axis));
    c.manifolds.push_back({a, b, a, b, normal, 0.5, static_cast<std::uint32_t>(c.points.size()), 4});
    for (std::uint32_t k = 0; k < 4; ++k) {
      Vec3 corner = -0.5 * normal;
      corner[(axis + 1) % 3] = k & 1 ? 0.5 : -0.5, corner[(axis + 2) % 3] = k & 2 ? 0.5 : -0.5;
      c.points.push_back({bench->world.position[static_cast<std::size_t>(a)] + corner, 0, k});
    }
  };
  const int stride[3] = {1, nx, nx * ny}, size[3] = {nx, ny, nz};
  for (int k = 0; k < n; ++k) {
    const int at[3] = {k % nx, k / nx % ny, k / (nx * ny)};
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] + 1 < size[axis]) face(k, k + stride[axis], axis);
    if (at[2] == 0) face(k, n, 2);
  }
  bench->build_for_jacobi();
  return bench;
}

double rho_scaled(const Bench& bench) { return spectral_radius(Dense(bench).N(), inverse_scales(bench)); }
double rho_diagonal(const Bench& bench) {
  const Eigen::MatrixXd N = Dense(bench).N();
  return spectral_radius(N, N.diagonal().cwiseInverse());
}

constexpr FrictionModel models[] = {FrictionModel::disc, FrictionModel::cone};

}  // namespace

TEST(Scaling, ColumnOfTenBoxes) {
  for (const auto model : models) {
    const auto bench = grid(
        1, 1, 10, [](int) { return 1.0; }, model);
    EXPECT_LE(rho_scaled(*bench), 1 + 1e-12);
    EXPECT_GT(rho_scaled(*bench), 0.3);              // and not needlessly short
    EXPECT_NEAR(rho_diagonal(*bench), 5.96, 0.005);  // as an independent code found it
  }
}

TEST(Scaling, GridOfBoxesOfMixedMasses) {
  unibody::samples::Random random(3);
  std::vector<double> mixed;
  for (int k = 0; k < 27; ++k) mixed.push_back(std::pow(10, random(-1.5, 1.5)));
  for (const auto model : models)
    for (const bool equal : {true, false}) {
      const auto bench = grid(
          3, 3, 3, [&](int k) { return equal ? 1.0 : mixed[static_cast<std::size_t>(k)]; }, model);
      EXPECT_LE(rho_scaled(*bench), 1 + 1e-12);
      EXPECT_GT(rho_scaled(*bench), 0.3);
      EXPECT_GT(rho_diagonal(*bench), 5);
    }
}

TEST(Scaling, RandomContactsOfBoxesAndSpheres) {
  for (const auto model : models)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto bench = random_bench(seed, model, 9, 30);
      bench->build_for_jacobi();
      // Rows without friction have no tangential scale: they drop out of the product.
      EXPECT_LE(rho_scaled(*bench), 1 + 1e-12) << "seed " << seed;
      EXPECT_GT(rho_diagonal(*bench), 1);
    }
}

// The count may be cut by the scaling setting; half of it is beyond what is guaranteed, and the bound is then twice as weak.
TEST(Scaling, SettingScalesTheCounts) {
  const auto full = grid(
      1, 1, 10, [](int) { return 1.0; }, FrictionModel::disc);
  const double before = rho_scaled(*full);
  full->settings.scaling = 0.5;
  full->build_for_jacobi();
  EXPECT_LE(rho_scaled(*full), 2 * before + 1e-12);  // no count falls below 1: not quite twice
  EXPECT_GT(rho_scaled(*full), 1.5 * before);
}

namespace {

// Of tetrahedra, as Jacobi sweeps show it: from multipliers l at rest a sweep goes to (1 - P^-1 N) l, column after column. Their
// P holds the nodes' weights times the number of constraints that share them; `share`: of that number.
double rho_of_solid(double youngs_modulus, double share) {
  const double poissons_ratio = 0.3, unit = 1e-6;  // N s: so little that strains stay linear
  Scene scene = scene_from_text(
      block_text("[0.3, 0.1, 0.1]", "[3, 1, 1]", "density: 1000\n    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3"));
  Experiment run(scene);
  run.simulation->detect();
  const ElasticMesh mesh = mesh_of(run.simulation->ties.constraints, run.world().position, lame(youngs_modulus, poissons_ratio));
  EXPECT_EQ(mesh.cells.size(), 15u);
  const ConstraintSet set = constraints_of(mesh, youngs_modulus, poissons_ratio);
  IterativeStep step(run.world(), set, Vec3::Zero(), 0.016, "jacobi");
  const std::size_t n = 6 * mesh.cells.size();
  Eigen::MatrixXd map = Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  const auto tetrahedra = [](ConstraintMultipliers& all, const ConstraintSet& of, auto&& f) {
    for_each_type(of, [&](auto type, const auto& list) {
      for (std::size_t c = 0; c < list.size(); ++c)
        for (std::size_t k = 0; k < std::get<type.value>(all)[c].size(); ++k) f(6 * c + k, std::get<type.value>(all)[c][k]);
    });
  };
  for (Vec4d& place : step.bench.system.places) place[3] *= share;
  for (std::size_t j = 0; j < n; ++j) {
    ConstraintMultipliers lambda = step.multipliers();
    tetrahedra(lambda, set, [&](std::size_t row, double& value) { value = row == j ? unit : 0; });
    step.set_multipliers(lambda);
    step.reapply();
    step.iterate(1);
    lambda = step.multipliers();
    tetrahedra(lambda, set, [&](std::size_t row, double& value) {
      map(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(j)) -= value / unit;
    });
  }
  return map.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

// Nodes counted half are beyond what is guaranteed; of stiff solids, without compliance to speak of, just twice as far.
TEST(Scaling, SolidsSoftAndStiff) {
  for (const double youngs_modulus : {1e5, 5e8}) {
    const double rho = rho_of_solid(youngs_modulus, 1), half = rho_of_solid(youngs_modulus, 0.5);
    EXPECT_LE(rho, 1 + 1e-5) << youngs_modulus;
    EXPECT_GT(rho, 0.3) << youngs_modulus;
    EXPECT_GT(half, 1.5) << youngs_modulus;
    if (youngs_modulus > 1e8) {
      EXPECT_NEAR(half, 2 * rho, 1e-3);
    }
  }
}

}  // namespace unibody::small_worlds::scaling_test
