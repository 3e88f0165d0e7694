// Moduli of cloths in their plane, from the forces that a stretched patch takes: of link grids against those of the lattice, of
// membranes against the law they are given; and how far they depend on the direction.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::moduli_test {

namespace {

constexpr int cells = 6;
constexpr double k = 200, k_area = 100, thickness = 0.01, youngs_modulus = 3e4, poissons_ratio = 0.25;  // N/m, N/m; m, Pa

struct Model {
  std::string text;
  double c11, c12, c66;  // N/m, with x and y alike
};

// Of a lattice with links of stiffness k, one each way in a cell and a share d of both diagonals, of which each strains by
// (e11 + e22) / 2 -+ e12: energy k/2 (e11^2 + e22^2 + d ((e11 + e22)^2 + 4 e12^2)) per area.
Model links(const std::string& diagonals, double d) {
  return {"links: {diagonals: " + diagonals + ", stiffness: 200}", k * (1 + d), k * d, k * d};
}

// Areas add k_A/2 (e11 + e22)^2 to the energy per area.
Model links_and_area() {
  Model model = links("alternating", 0.5);
  model.text += "\n    area: {stiffness: 100}";
  model.c11 += k_area, model.c12 += k_area;
  return model;
}

std::vector<Model> models() {
  const double plane = youngs_modulus * thickness / (1 - poissons_ratio * poissons_ratio);
  return {links("both", 1),
          links("alternating", 0.5),
          links("none", 0),
          {"membrane: {youngs_modulus: 3.0e4, poissons_ratio: 0.25}", plane, plane * poissons_ratio,
           plane * (1 - poissons_ratio) / 2},
          links_and_area()};
}

bool at_rim(double x) { return std::abs(x) > 0.5 - 0.25 / cells; }

// Mean stress (N/m) of a patch of 1 m x 1 m whose rim is strained by e while the inner nodes, shaken, come to rest. Each
// constraint counts with sum lambda D x; a link of the rim belongs to the patch by half.
Eigen::Matrix2d stress(const Model& model, const Eigen::Matrix2d& e) {
  std::string pins;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      if (std::min({i, j, cells - i, cells - j}) == 0)
        pins += (pins.empty() ? "{node: [" : ", {node: [") + std::to_string(i) + ", " + std::to_string(j) + "]}";
  Scene scene =
      scene_from_text("gravity: [0, 0, 0]\ncloths:\n  - grid: {size: [1, 1], nodes: [7, 7]}\n    mass: 1\n    thickness: " +
                      std::to_string(thickness) + "\n    " + model.text + "\n    pins: [" + pins + "]\n");
  scene.time.frame = 0.02, scene.solver.iterations = 300, scene.solver.tolerance = 0;
  Experiment run(std::move(scene));
  World& world = run.world();
  for (std::size_t i = 0; i < world.homes; ++i) {
    Vec3& x = world.position[i];
    if (at_rim(x.x()) || at_rim(x.y()))
      x.head<2>() += Eigen::Vector2d(e * x.head<2>());
    else
      x.x() += 1e-6 * std::sin(7.0 * static_cast<double>(i));
  }
  run.steps(100);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for_each_type(run.simulation->ties.constraints, [&]<class C>(auto, const ConstraintList<C>& list) {
    const auto& impulses = run.simulation->history.of<ConstraintBatch<C>>();
    for (std::size_t n = 0; n < list.size(); ++n) {
      std::array<Vec4d, C::parameter_names.size()> parameters;
      std::array<Vec3x4, C::stencil> x;
      Vec3 middle = Vec3::Zero();
      for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(list[n].parameters[p]);
      for (std::size_t b = 0; b < C::stencil; ++b) {
        const Vec3 at = run.position(list[n].ids[b]);
        x[b] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())}, middle += at / C::stencil;
      }
      Rows<C::stencil, C::rows> rows;
      C::evaluate(parameters, x, rows);
      const double share = C::stencil == 2 && (at_rim(middle.x()) || at_rim(middle.y())) ? 0.5 : 1;
      for (std::size_t r = 0; r < C::rows; ++r)
        for (std::size_t b = 0; b < C::stencil; ++b) {
          const Vec3x4& D = rows.gradient[r][b];
          sum -= share * impulses[n][r] / run.h() * Eigen::Vector2d(D.x[0], D.y[0]) * Eigen::RowVector2d(x[b].x[0], x[b].y[0]);
        }
    }
  });
  return sum;
}

constexpr double strain = 1e-5;

// C11, C12 and C66 (N/m) of the patch.
struct Measured {
  double c11, c12, c66;
};
Measured measure(const Model& model) {
  const Eigen::Matrix2d stretched = stress(model, strain * Eigen::Vector2d(1, 0).asDiagonal().toDenseMatrix());
  const Eigen::Matrix2d sheared = stress(model, strain * (Eigen::Matrix2d() << 0, 0.5, 0.5, 0).finished());
  return {stretched(0, 0) / strain, stretched(1, 1) / strain, sheared(0, 1) / strain};
}

// Young's modulus (N/m) under tension along a direction at an angle to x, and the shear modulus across it.
template <class Stiffness>
std::pair<double, double> moduli(const Stiffness& c, double degrees) {
  Eigen::Matrix3d C;
  C << c.c11, c.c12, 0, c.c12, c.c11, 0, 0, 0, c.c66;
  const Eigen::Matrix3d S = C.inverse();
  const double cosine = std::cos(degrees * M_PI / 180), sine = std::sin(degrees * M_PI / 180);
  const Eigen::Vector3d tension(cosine * cosine, sine * sine, sine * cosine),
      shear(-2 * sine * cosine, 2 * sine * cosine, cosine * cosine - sine * sine);
  return {1 / tension.dot(S * tension), 1 / shear.dot(S * shear)};
}

}  // namespace

// To the first order in the strain, 1e-5: links turn, and the membrane's strain is quadratic.
constexpr double tolerance = 5 * strain;

TEST(Moduli, AreThoseOfTheLatticeAndOfTheLaw) {
  for (const Model& model : models()) {
    const Measured is = measure(model);
    EXPECT_NEAR(is.c11, model.c11, tolerance * k) << model.text;
    EXPECT_NEAR(is.c12, model.c12, tolerance * k) << model.text;
    EXPECT_NEAR(is.c66, model.c66, tolerance * k) << model.text;
  }
}

// Links along both diagonals of all cells are 1.6 times stiffer along the diagonals than along the rows; one diagonal of each
// cell, alternating, is as isotropic as the membrane, with E = 4/3 k and Poisson's ratio 1/3.
TEST(Moduli, DependOnTheDirectionWithBothDiagonalsOnly) {
  const Measured both = measure(links("both", 1)), alternating = measure(links("alternating", 0.5));
  EXPECT_NEAR(moduli(both, 0).first, 1.5 * k, tolerance * k);
  EXPECT_NEAR(moduli(both, 45).first, 2.4 * k, tolerance * k);
  EXPECT_NEAR(moduli(both, 0).second, k, tolerance * k);
  EXPECT_NEAR(moduli(both, 45).second, 0.5 * k, tolerance * k);
  const Measured membrane = measure(models()[3]);
  const double E = youngs_modulus * thickness;
  for (const double degrees : {0.0, 15.0, 30.0, 45.0}) {
    EXPECT_NEAR(moduli(alternating, degrees).first, 4.0 / 3 * k, tolerance * k) << degrees;
    EXPECT_NEAR(moduli(alternating, degrees).second, 0.5 * k, tolerance * k) << degrees;
    EXPECT_NEAR(moduli(membrane, degrees).first, E, tolerance * E) << degrees;
    EXPECT_NEAR(moduli(membrane, degrees).second, E / (2 * (1 + poissons_ratio)), tolerance * E) << degrees;
  }
  EXPECT_NEAR(alternating.c12 / alternating.c11, 1.0 / 3, tolerance);
  const Measured area = measure(links_and_area());
  for (const double degrees : {0.0, 15.0, 30.0, 45.0})
    EXPECT_NEAR(moduli(area, degrees).second, 0.5 * k, tolerance * k) << degrees;
  EXPECT_NEAR(area.c12 / area.c11, (k + 2 * k_area) / (3 * k + 2 * k_area), tolerance);
}

}  // namespace unibody::small_worlds::moduli_test
