#include "collide/struck_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace unibody::struck_bodies_test {

// The grid finds what a look at all of them finds, for balls of any size, in whatever order and pieces they were added.
TEST(StruckBodies, FindsTheFastestThatReachesABall) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-5, 5), reach(0.01, 0.6), speed(0.1, 9);
  std::vector<Struck> all;
  for (int k = 0; k < 300; ++k) {
    Struck s{};
    s.way.setZero();
    s.centre = Vec3(place(random), place(random), place(random)), s.reach = reach(random), s.speed = speed(random), s.id = k;
    all.push_back(s);
  }
  StruckBodies found, reversed;
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(found.speed_at(Vec3::Zero(), 100), 0);
  found.add({all.begin(), all.begin() + 100}), found.add({all.begin() + 100, all.end()});
  reversed.add({all.rbegin(), all.rend()});
  int hits = 0;
  for (int k = 0; k < 500; ++k) {
    const Vec3 centre(place(random), place(random), place(random));
    const double radius = k % 10 == 0 ? 20 * reach(random) : reach(random);
    double expected = 0;
    for (const Struck& s : all)
      if ((s.centre - centre).norm() < s.reach + radius) expected = std::max(expected, s.speed);
    EXPECT_EQ(found.speed_at(centre, radius), expected);
    EXPECT_EQ(reversed.speed_at(centre, radius), expected);
    hits += expected > 0;
  }
  EXPECT_GT(hits, 50);
  EXPECT_LT(hits, 450);
  EXPECT_GT(found.speed_at(Vec3::Zero(), HUGE_VAL), 8);  // of all
  found.clear();
  EXPECT_TRUE(found.empty());
}

}  // namespace unibody::struck_bodies_test
