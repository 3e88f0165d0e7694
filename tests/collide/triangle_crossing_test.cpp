// Signs and crossings against whole-number arithmetic.
#include "collide/triangle_crossing.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "collide/bodies.hpp"

namespace unibody::triangle_crossing_test {
namespace {

using namespace samples;

__extension__ typedef __int128 Wide;
using Whole = std::array<std::int64_t, 3>;

Whole minus(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Whole& a, const Whole& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
bool is_zero(const Whole& a) { return a == Whole{0, 0, 0}; }
std::int64_t det(const Whole& a, const Whole& b, const Whole& c) { return dot(a, cross(b, c)); }
int sign(Wide x) { return (x > 0) - (x < 0); }
Vec3 real(const Whole& a) { return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])}; }

// Whether 0 is in the convex hull, where the points are independent; sums of others are made of these (Caratheodory).
bool holds_zero(const Whole& a) { return is_zero(a); }
bool holds_zero(const Whole& a, const Whole& b) { return is_zero(cross(a, b)) && dot(a, b) <= 0; }
bool holds_zero(const Whole& a, const Whole& b, const Whole& c) {
  const Whole normal = cross(minus(b, a), minus(c, a));
  return !is_zero(normal) && dot(normal, a) == 0 && dot(cross(a, b), normal) >= 0 && dot(cross(b, c), normal) >= 0 &&
         dot(cross(c, a), normal) >= 0;
}
bool holds_zero(const Whole& a, const Whole& b, const Whole& c, const Whole& d) {
  const int whole = sign(det(minus(b, a), minus(c, a), minus(d, a)));
  return whole != 0 && sign(det(b, c, d)) * whole >= 0 && -sign(det(a, c, d)) * whole >= 0 && sign(det(a, b, d)) * whole >= 0 &&
         -sign(det(a, b, c)) * whole >= 0;
}

// They meet where 0 is a mean of differences of their corners.
bool meets(const Whole& p, const Whole& q, const Whole& a, const Whole& b, const Whole& c) {
  std::vector<Whole> y;
  for (const Whole& end : {p, q})
    for (const Whole& node : {a, b, c}) y.push_back(minus(end, node));
  for (std::size_t i = 0; i < 6; ++i) {
    if (holds_zero(y[i])) return true;
    for (std::size_t j = i + 1; j < 6; ++j) {
      if (holds_zero(y[i], y[j])) return true;
      for (std::size_t k = j + 1; k < 6; ++k) {
        if (holds_zero(y[i], y[j], y[k])) return true;
        for (std::size_t l = k + 1; l < 6; ++l)
          if (holds_zero(y[i], y[j], y[k], y[l])) return true;
      }
    }
  }
  return false;
}

std::int64_t draw(Random& random, std::int64_t low, std::int64_t high) {
  return low + static_cast<std::int64_t>(random.engine() % static_cast<std::uint64_t>(high - low + 1));
}
Whole draw_point(Random& random, std::int64_t reach) {
  return {draw(random, -reach, reach), draw(random, -reach, reach), draw(random, -reach, reach)};
}

// Small numbers: most cases touch, lie in one plane or on one line, or have no area.
TEST(TriangleCrossing, EveryDegenerateCaseAsInWholeNumbers) {
  Random random(1);
  int met = 0, flat = 0;
  const double scales[] = {1, 0x1p-200, 0x1p200, 0x1p-3};
  for (int i = 0; i < 1000000; ++i) {
    const std::int64_t reach = 1 + i % 4;
    Whole n[5];
    for (Whole& v : n) v = draw_point(random, reach);
    if (i % 3 == 0)
      for (Whole& v : n) v[static_cast<std::size_t>(i / 3 % 3)] = 1;
    const bool expected = meets(n[0], n[1], n[2], n[3], n[4]);
    const double scale = scales[i % 4];
    const Vec3 offset = i % 5 == 0 ? Vec3(0x1p40, -0x1p41, 0x1p30) : Vec3(Vec3::Zero());
    const auto at = [&](int k) -> Vec3 { return scale * (real(n[k]) + offset); };
    ASSERT_EQ(edge_crosses_face(at(0), at(1), at(2), at(3), at(4)), expected) << i;
    ASSERT_EQ(edge_crosses_face(at(1), at(0), at(3), at(2), at(4)), expected) << i;
    met += expected;
    flat += det(minus(n[1], n[0]), minus(n[2], n[0]), minus(n[3], n[0])) == 0;
  }
  EXPECT_GT(met, 100000);
  EXPECT_LT(met, 900000);
  EXPECT_GT(flat, 300000);
  std::cout << met << " of 1000000 met\n";
}

// Points within a unit of a plane whose coordinates have 40 bits: the determinant has 120, a double 53.
TEST(TriangleCrossing, OrientationNextToThePlaneAsInWholeNumbers) {
  Random random(2);
  const std::int64_t reach = std::int64_t{1} << 38;
  int zeros = 0, wrong_in_double = 0;
  for (int i = 0; i < 300000; ++i) {
    const Whole a = draw_point(random, reach);
    const Whole u = draw_point(random, reach >> 2), v = draw_point(random, reach >> 2);
    const std::int64_t j = draw(random, -1, 1), k = draw(random, -1, 1);
    const Whole nudge = draw_point(random, 1);
    Whole b = a, c = a, d = a;
    for (std::size_t m = 0; m < 3; ++m) b[m] += u[m], c[m] += v[m], d[m] += j * u[m] + k * v[m] + (i % 3 ? nudge[m] : 0);
    const Whole w = minus(d, a);
    Wide exact = 0;
    for (std::size_t m = 0; m < 3; ++m) {
      const std::size_t m1 = (m + 1) % 3, m2 = (m + 2) % 3;
      exact += (Wide{u[m1]} * v[m2] - Wide{u[m2]} * v[m1]) * w[m];
    }
    // an offset that the differences lose in double, but that the sums don't
    const Vec3 offset = i % 2 ? Vec3(0x1p52, -0x1p51, 0) : Vec3(Vec3::Zero());
    const Vec3 ra = real(a) + offset, rb = real(b) + offset, rc = real(c) + offset, rd = real(d) + offset;
    ASSERT_EQ(orient3d(ra, rb, rc, rd), sign(exact)) << i;
    ASSERT_EQ(orient3d(rb, ra, rc, rd), -sign(exact)) << i;
    const double rounded = (rb - ra).cross(rc - ra).dot(rd - ra);
    wrong_in_double += (rounded > 0) - (rounded < 0) != sign(exact);
    zeros += exact == 0;
  }
  EXPECT_GT(zeros, 90000);
  EXPECT_GT(wrong_in_double, 1000);
  std::cout << "of 300000 signs, plain doubles had " << wrong_in_double << " wrong\n";
}

// Differences that don't fit a double: coordinates of very different size.
TEST(TriangleCrossing, DifferencesThatDontFitADouble) {
  const double tiny = 0x1p-250, huge = 0x1p250;
  const Vec3 a(huge, 0, 0), b(0, huge, 0), c(0, 0, huge);  // x + y + z = huge
  EXPECT_EQ(orient3d(a, b, c, Vec3(huge, tiny, 0)), 1);
  EXPECT_EQ(orient3d(a, b, c, Vec3(huge, -tiny, 0)), -1);
  EXPECT_EQ(orient3d(a, b, c, Vec3(huge, tiny, -tiny)), 0);
  EXPECT_TRUE(edge_crosses_face(Vec3(huge, tiny, -tiny), Vec3(0, 0, 0), a, b, Vec3(0, 0, -huge)));
  EXPECT_FALSE(edge_crosses_face(Vec3(huge, tiny, 0), Vec3(2 * huge, 0, 0), a, b, c));
  EXPECT_TRUE(edge_crosses_face(Vec3(huge, tiny, -tiny), Vec3(huge, -tiny, tiny), a, b, c));
}

}  // namespace
}  // namespace unibody::triangle_crossing_test
