#include "collide/broadphase.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "collide/bodies.hpp"

namespace unibody::broadphase_test {
namespace {

using samples::Random;

struct Input {
  std::vector<Bounds> bounds;
  std::vector<Role> roles;
};

// `spread`: the largest size over the smallest
Input random_input(std::uint64_t seed, int count, double side, double spread) {
  Random random(seed);
  Input in;
  for (int i = 0; i < count; ++i) {
    const double size = std::pow(spread, -random(0, 1));
    const Vec3 centre = random.vector(-side, side), half = size * random.vector(0.2, 1);
    in.bounds.push_back({centre - half, centre + half});
    const double u = random(0, 1);
    in.roles.push_back(u < 0.5 ? Role::home : u < 0.95 ? Role::other : Role::absent);
  }
  return in;
}

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

std::vector<std::pair<int, int>> brute_force(const Input& in) {
  std::vector<std::pair<int, int>> pairs;
  const int n = static_cast<int>(in.bounds.size());
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) {
      if (in.roles[i] == Role::absent || in.roles[j] == Role::absent) continue;
      if (in.roles[i] != Role::home && in.roles[j] != Role::home) continue;
      if (overlap(in.bounds[i], in.bounds[j])) pairs.emplace_back(i, j);
    }
  return pairs;
}

std::vector<std::pair<int, int>> found(BroadPhase& broad, const Input& in) {
  Pairs pairs;
  broad.find(in.bounds, in.roles, pairs);
  std::vector<std::pair<int, int>> result;
  for (const auto& p : broad.sort(pairs, in.bounds.size())) result.emplace_back(p.first, p.second);
  return result;
}

TEST(BroadPhase, FindsThePairsOfBruteForceInOrder) {
  BroadPhase broad;  // one object for all: nothing may be left over from the last call
  std::uint64_t seed = 1;
  for (const double spread : {1.0, 3.0, 100.0, 1e4})
    for (const int count : {0, 1, 2, 40, 700, 1500})
      for (const double side : {1.0, 5.0, 20.0}) {
        const Input in = random_input(seed++, count, side, spread);
        EXPECT_EQ(found(broad, in), brute_force(in)) << "spread " << spread << ", count " << count << ", side " << side;
      }
}

// Groups, kinds and who accepts whom; numbers that go on from the first.
TEST(BroadPhase, FiltersAreThoseOfBruteForce) {
  BroadPhase broad;
  std::size_t kept = 0, dropped = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const int count = seed % 3 == 0 ? 12 : 600;
    const Input in = random_input(seed, count, seed % 2 ? 3 : 6, seed % 4 ? 4 : 1000);
    Random random(100 + seed);
    std::vector<Filter> filters;
    for (int i = 0; i < count; ++i)
      filters.push_back({static_cast<std::int32_t>(random(-1, 4)), static_cast<std::uint8_t>(1 << static_cast<int>(random(0, 3))),
                         static_cast<std::uint8_t>(random(0, 8))});
    std::vector<std::pair<int, int>> expected;
    const int first = static_cast<int>(random(0, 1000));
    for (const auto& [i, j] : brute_force(in)) {
      const Filter &a = filters[static_cast<std::size_t>(i)], &b = filters[static_cast<std::size_t>(j)];
      const bool same = a.group == b.group && a.group != -1;
      if (!same && (a.accepts & b.kind) && (b.accepts & a.kind))
        expected.emplace_back(first + i, first + j);
      else
        ++dropped;
    }
    kept += expected.size();
    Pairs pairs;
    pairs.push_back({0, 1});  // what is there stays
    broad.find(in.bounds, in.roles, pairs, filters, first);
    ASSERT_EQ(pairs.front().first, 0);
    pairs.pop_front();
    std::vector<std::pair<int, int>> result;
    for (const auto& p : broad.sort(pairs, in.bounds.size() + static_cast<std::size_t>(first)))
      result.emplace_back(p.first, p.second);
    EXPECT_EQ(result, expected) << seed;
  }
  EXPECT_GT(kept, 1000u);
  EXPECT_GT(dropped, 1000u);
}

TEST(BroadPhase, EqualTouchingBoundsOnTheGrid) {
  Input in;
  for (int i = 0; i < 512; ++i) {  // cubes whose faces meet exactly: 26 neighbours each
    const Vec3 lower(i % 8 - 4, (i / 8) % 8 - 4, i / 64 - 4);
    in.bounds.push_back({lower, lower + Vec3::Ones()});
    in.roles.push_back(Role::home);
  }
  BroadPhase broad;
  EXPECT_EQ(found(broad, in), brute_force(in));
}

TEST(BroadPhase, FarAwayAndNotFiniteBoundsDoNoHarm) {
  Input in = random_input(5, 50, 2, 10);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  in.bounds[3].lower.x() = nan;
  in.bounds[4].upper.y() = inf;
  in.roles[3] = in.roles[4] = Role::absent;
  const auto expected = brute_force(in);
  in.roles[3] = in.roles[4] = Role::home;
  BroadPhase broad;
  EXPECT_EQ(found(broad, in), expected);

  Input far;
  for (int i = 0; i < 40; ++i) {
    const Vec3 centre = Vec3::Constant(1e17 * (i % 2 ? 1 : -1));
    far.bounds.push_back({centre - Vec3::Ones(), centre + Vec3::Ones()});
    far.roles.push_back(Role::home);
  }
  EXPECT_EQ(found(broad, far), brute_force(far));
}

// The number of bodies of either size times ten: the time must not grow by much more than ten.
TEST(BroadPhase, TimeIsLinearWithVeryDifferentSizes) {
  const auto seconds = [](int n) {
    Random random(9);
    Input in;
    for (int i = 0; i < n; ++i) {
      const double half = i % 50 == 0 ? 0.5 : 1e-4;
      const double side = std::cbrt(n / 50.0) * 1.5;
      const Vec3 centre = random.vector(-side, side);
      in.bounds.push_back({centre - Vec3::Constant(half), centre + Vec3::Constant(half)});
      in.roles.push_back(Role::home);
    }
    BroadPhase broad;
    Pairs pairs;
    double best = 1e9;
    for (int repeat = 0; repeat < 3; ++repeat) {
      pairs.clear();
      const auto start = std::chrono::steady_clock::now();
      broad.find(in.bounds, in.roles, pairs);
      best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return best;
  };
  const double small = seconds(4000), large = seconds(40000);
  EXPECT_LT(large, 40 * small);  // 100 times would be quadratic
}

}  // namespace
}  // namespace unibody::broadphase_test
