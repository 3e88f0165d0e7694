#include "step/first_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace unibody::first_touch_test {
namespace {

constexpr double step = 0.1;
const Vec3 still = Vec3::Zero();

}  // namespace

TEST(FirstTouch, SpheresHeadOnAndAside) {
  const auto touch = [](const Vec3& apart, const Vec3& velocity, double from = 0) {
    return first_touch_of_spheres(apart, velocity, still, step, 0.5, from, step);
  };
  EXPECT_NEAR(touch({1, 0, 0}, {-10, 0, 0}), 0.05, 1e-12);
  EXPECT_NEAR(touch({1, 0.3, 0}, {-10, 0, 0}), (1 - 0.4) / 10, 1e-10);  // where x^2 + 0.3^2 = 0.5^2
  EXPECT_EQ(touch({1, 0.51, 0}, {-10, 0, 0}), never);                   // past it
  EXPECT_EQ(touch({1, 0, 0}, {10, 0, 0}), never);                       // away
  EXPECT_EQ(touch({2, 0, 0}, {-10, 0, 0}), never);                      // after the step
  EXPECT_EQ(touch({0.4, 0, 0}, {-1, 0, 0}, 0.02), 0.02);                // in each other already
  EXPECT_EQ(touch({0.4, 0, 0}, {1, 0, 0}, 0.02), never);                // and on their way out
}

// x(t) = x + t v + t (t - h) a / 2.
TEST(FirstTouch, OfAParabolaItIsTheRoot) {
  for (const double a : {-40.0, 0.0, 15.0}) {
    const double gap = 0.3, v = -4;
    const double time = first_touch_of_plane(gap, v, a, step, 0, step);
    ASSERT_LT(time, step) << a;
    EXPECT_NEAR(gap + time * v + 0.5 * time * (time - step) * a, 0, 1e-14) << a;
    EXPECT_NEAR(first_touch_of_spheres(Vec3(0.5 + gap, 0, 0), Vec3(v, 0, 0), Vec3(a, 0, 0), step, 0.5, 0, step), time, 1e-10)
        << a;
  }
  EXPECT_EQ(first_touch_of_plane(0.3, 4, 0, step, 0, step), never);
  EXPECT_EQ(first_touch_of_plane(0, 1, 0, step, 0, step), never);  // touches, and opens
  EXPECT_EQ(first_touch_of_plane(0, -1, 0, step, 0.03, step), 0.03);
}

}  // namespace unibody::first_touch_test
