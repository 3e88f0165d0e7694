// Every constraint type of the list: gradients against central differences, and what no rigid motion may change.
#include "constraints/constraint_types.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"
#include "constraints/sweep.hpp"

namespace unibody::constraint_types_test {

namespace {

using samples::Random;

template <class C>
struct Case {
  std::array<Vec4d, C::parameter_names.size()> parameters;
  std::array<std::array<Vec3, C::stencil>, lanes> x;

  Rows<C::stencil, C::rows> evaluate() const {
    std::array<Vec3x4, C::stencil> packed;
    for (std::size_t e = 0; e < C::stencil; ++e) {
      const auto along = [&](int axis) { return Vec4d{x[0][e][axis], x[1][e][axis], x[2][e][axis], x[3][e][axis]}; };
      packed[e] = {along(0), along(1), along(2)};
    }
    Rows<C::stencil, C::rows> rows{};
    C::evaluate(parameters, packed, rows);
    return rows;
  }
  static Vec3 lane(const Vec3x4& v, std::size_t l) { return {v.x[l], v.y[l], v.z[l]}; }
};

// Bodies some way apart, about the origin, and parameters of the size that they have in scenes.
template <class C>
Case<C> random_case(Random& random) {
  Case<C> c;
  for (auto& stencil : c.x)
    for (std::size_t e = 0; e < C::stencil; ++e)
      stencil[e] = Vec3(std::cos(2.0 * double(e)), std::sin(2.0 * double(e)), 0.3 * double(e)) + random.vector(-.3, .3);
  for (Vec4d& p : c.parameters)
    for (std::size_t l = 0; l < lanes; ++l) p[l] = random(0.5, 1.5);
  return c;
}

template <class C>
class ConstraintTypeTest : public ::testing::Test {};

template <class List>
struct AsTestTypes;
template <class... C>
struct AsTestTypes<TypeList<C...>> {
  using type = ::testing::Types<C...>;
};
struct Names {
  template <class C>
  static std::string GetName(int) {
    return std::string(C::name);
  }
};
TYPED_TEST_SUITE(ConstraintTypeTest, AsTestTypes<ConstraintTypes>::type, Names);

}  // namespace

TYPED_TEST(ConstraintTypeTest, GradientsAreThoseOfFiniteDifferences) {
  using C = TypeParam;
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Case<C> c = random_case<C>(random);
    const auto rows = c.evaluate();
    constexpr double step = 1e-6;
    for (std::size_t e = 0; e < C::stencil; ++e)
      for (int axis = 0; axis < 3; ++axis) {
        Case<C> up = c, down = c;
        for (std::size_t l = 0; l < lanes; ++l) up.x[l][e][axis] += step, down.x[l][e][axis] -= step;
        const auto above = up.evaluate(), below = down.evaluate();
        for (std::size_t k = 0; k < C::rows; ++k)
          for (std::size_t l = 0; l < lanes; ++l) {
            const double slope = (above.value[k][l] - below.value[k][l]) / (2 * step);
            ASSERT_NEAR(Case<C>::lane(rows.gradient[k][e], l)[axis], slope, 1e-7 * (1 + std::abs(slope)))
                << "row " << k << ", body " << e << ", axis " << axis;
          }
      }
  }
}

// A constraint pushes with no net force and no net torque, and sees no rigid motion.
TYPED_TEST(ConstraintTypeTest, RigidMotionsChangeNothing) {
  using C = TypeParam;
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Case<C> c = random_case<C>(random);
    const auto rows = c.evaluate();
    for (std::size_t k = 0; k < C::rows; ++k)
      for (std::size_t l = 0; l < lanes; ++l) {
        Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
        double size = 0;
        for (std::size_t e = 0; e < C::stencil; ++e) {
          const Vec3 g = Case<C>::lane(rows.gradient[k][e], l);
          force += g, torque += c.x[l][e].cross(g), size += g.norm();
        }
        ASSERT_GT(size, 0.1);
        ASSERT_LT(force.norm(), 1e-13 * size);
        ASSERT_LT(torque.norm(), 1e-13 * size);
      }
    Case<C> moved = c;
    const Quat turn = random.turn();
    const Vec3 shift = random.vector(-2, 2);
    for (auto& stencil : moved.x)
      for (Vec3& x : stencil) x = turn * x + shift;
    const auto after = moved.evaluate();
    for (std::size_t k = 0; k < C::rows; ++k)
      for (std::size_t l = 0; l < lanes; ++l) ASSERT_NEAR(after.value[k][l], rows.value[k][l], 1e-13);
  }
}

// Which lane a constraint is in changes no bit.
TYPED_TEST(ConstraintTypeTest, LanesAreIndependent) {
  using C = TypeParam;
  Random random(7);
  const Case<C> c = random_case<C>(random);
  Case<C> turned = c;
  for (std::size_t l = 0; l < lanes; ++l) {
    turned.x[l] = c.x[(l + 1) % lanes];
    for (std::size_t p = 0; p < c.parameters.size(); ++p) turned.parameters[p][l] = c.parameters[p][(l + 1) % lanes];
  }
  const auto a = c.evaluate(), b = turned.evaluate();
  for (std::size_t k = 0; k < C::rows; ++k)
    for (std::size_t l = 0; l < lanes; ++l) {
      EXPECT_EQ(b.value[k][l], a.value[k][(l + 1) % lanes]);
      for (std::size_t e = 0; e < C::stencil; ++e)
        EXPECT_EQ(Case<C>::lane(b.gradient[k][e], l), Case<C>::lane(a.gradient[k][e], (l + 1) % lanes));
    }
}

TYPED_TEST(ConstraintTypeTest, CollapsedStencilsAreFinite) {
  using C = TypeParam;
  Random random(9);
  Case<C> c = random_case<C>(random);
  for (std::size_t l = 0; l < lanes; ++l)
    for (std::size_t e = 1; e < C::stencil; ++e)
      if (l != 1 || e > 1) c.x[l][e] = c.x[l][0];
  const auto rows = c.evaluate();
  for (std::size_t k = 0; k < C::rows; ++k)
    for (std::size_t l = 0; l < lanes; ++l) {
      EXPECT_TRUE(std::isfinite(rows.value[k][l]));
      for (std::size_t e = 0; e < C::stencil; ++e) EXPECT_TRUE(Case<C>::lane(rows.gradient[k][e], l).allFinite());
    }
}

// Closed forms: a triangle stretched by s1 along its first edge and s2 across, and sheared.
TEST(Membrane, StrainsOfAnAffineMap) {
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 a(random(-1, 1), random(-1, 1), 0), b = a + Vec3(1, 0.2, 0), c = a + Vec3(0.3, 0.8, 0);
    const double s1 = random(0.8, 1.2), s2 = random(0.8, 1.2), shear = random(-.2, .2);
    const Vec3 along = (b - a).normalized(), across = Vec3::UnitZ().cross(along);
    const auto map = [&](const Vec3& x) -> Vec3 {
      const double u = along.dot(x - a), v = across.dot(x - a);
      return Vec3(u * s1 + shear * v, v * s2, 0);
    };
    Case<Membrane> one;
    const auto rest = Membrane::at_rest(a, b, c);
    for (std::size_t p = 0; p < rest.size(); ++p) one.parameters[p] = broadcast(rest[p]);
    for (auto& stencil : one.x) stencil = {map(a), map(b), map(c)};
    const auto rows = one.evaluate();
    // F = [s1 shear; 0 s2] in the frame of the first edge; eps = (F^T F - 1) / 2.
    const double e11 = 0.5 * (s1 * s1 - 1), e22 = 0.5 * (s2 * s2 + shear * shear - 1), e12 = 0.5 * s1 * shear;
    const double L = std::sqrt((b - a).cross(c - a).norm());
    EXPECT_NEAR(rows.value[0][0], L * (e11 + e22) / std::sqrt(2.0), 1e-13);
    EXPECT_NEAR(rows.value[1][0], L * (e11 - e22) / std::sqrt(2.0), 1e-13);
    EXPECT_NEAR(rows.value[2][0], L * std::sqrt(2.0) * e12, 1e-13);
  }
}

// The energy sum of c_k^2 / (2 E_k) is V0 times the plane-stress density E / (2 (1 - nu^2)) (e11^2 + e22^2 + 2 nu e11 e22 +
// 2 (1 - nu) e12^2).
TEST(Membrane, ComplianceGivesThePlaneStressEnergy) {
  const double E = 3e5, nu = 0.3, area = 0.02, thickness = 1e-3, e11 = 0.01, e22 = -0.02, e12 = 0.005, L = std::sqrt(2 * area);
  const auto soft = Membrane::compliance(E, nu, area, thickness, L);
  const double c[3] = {L * (e11 + e22) / std::sqrt(2.0), L * (e11 - e22) / std::sqrt(2.0), L * std::sqrt(2.0) * e12};
  double energy = 0;
  for (std::size_t k = 0; k < 3; ++k) energy += 0.5 * c[k] * c[k] / soft[k];
  const double density = 0.5 * E / (1 - nu * nu) * (e11 * e11 + e22 * e22 + 2 * nu * e11 * e22 + 2 * (1 - nu) * e12 * e12);
  EXPECT_NEAR(energy, area * thickness * density, 1e-12 * energy);
}

// The pull of a bar without Poisson effect on node 1 of the unit tetrahedron, whose face across x has the area 1/2 and shares its
// force out by thirds: V0 P e1 = P / 6 at the nominal stress P of the stretch l.
template <class C>
double nominal_stress(double l, double youngs_modulus) {
  Case<C> one;
  const auto rest = Tetrahedron::at_rest(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ());
  const auto soft = Tetrahedron::compliance(youngs_modulus, 0, 1.0 / 6, rest[9]);
  for (std::size_t p = 0; p < rest.size(); ++p) one.parameters[p] = broadcast(rest[p]);
  for (auto& stencil : one.x) stencil = {Vec3::Zero(), l * Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const auto rows = one.evaluate();
  double slope = 0;  // of the energy by the place of node 1
  for (std::size_t k = 0; k < 6; ++k) slope += rows.value[k][0] / soft[k] * rows.gradient[k][1].x[0];
  return 6 * slope;
}

TEST(Tetrahedron, NominalStressOfBothWeights) {
  const double E = 2e5;
  for (const double l : {0.3, 0.45, 0.6, 0.8, 1.0, 1.3}) {
    EXPECT_NEAR(nominal_stress<Tetrahedron>(l, E), 0.5 * E * l * (l * l - 1), 1e-12 * E) << l;
    EXPECT_NEAR(nominal_stress<TetrahedronCurrentVolume>(l, E), E / 8 * (l * l - 1) * (5 * l * l - 1), 1e-12 * E) << l;
  }
  EXPECT_GT(nominal_stress<TetrahedronCurrentVolume>(0.44, E), 0);  // it draws what is pressed this far flat
}

TEST(Dihedral, IsTheAngleOfTheFold) {
  for (const double fold : {-3.0, -2.0, -0.5, 0.0, 0.7, 2.5, 3.1}) {
    Case<Dihedral> c;
    c.parameters = {broadcast(0.0), broadcast(2.0)};
    for (auto& x : c.x) x = {Vec3(0, 0, 0), Vec3(1.5, 0, 0), Vec3(0.4, 1, 0), Vec3(0.9, -std::cos(fold), -std::sin(fold))};
    EXPECT_NEAR(c.evaluate().value[0][0], 2 * fold, 1e-12) << fold;
  }
}

// The sums of a sweep: four at once are what one at a time are.
TEST(WholeUnits, FourAtOnceAreOneByOne) {
  Random random(13);
  for (int trial = 0; trial < 10000; ++trial) {
    const double per_unit = std::pow(10, random(-6, 20));
    Vec4d terms;
    for (std::size_t l = 0; l < lanes; ++l) terms[l] = random(-1, 1) * std::pow(10, random(-12, 3));
    terms[0] = 2.5 / per_unit;
    const Mask4 all = whole_units(terms, per_unit);
    for (std::size_t l = 0; l < lanes; ++l) ASSERT_EQ(all[l], whole_units(static_cast<double>(terms[l]), per_unit));
  }
}

}  // namespace unibody::constraint_types_test
