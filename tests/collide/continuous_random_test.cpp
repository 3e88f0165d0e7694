// Continuous tests of random motions against small steps and the times of coplanarity in 113 bits; near misses; cost.
#include <chrono>
#include <iostream>
#include <vector>

#include "collide/moving_query.hpp"

namespace unibody::continuous_random_test {
namespace {

using namespace samples;

TEST(ContinuousRandom, RandomMotionsAgreeWithSmallSteps) {
  Random random(2);
  int hits = 0, misses = 0, between = 0;
  for (int k = 0; k < 4000; ++k) {
    const Query q = random_query(random, k % 2 == 0, random(0.1, 4));
    const ContinuousSettings settings{k % 3 == 0 ? 0 : random(0, 0.2), std::pow(10, random(-10, -2))};
    const ContinuousHit hit = q.ask(settings);
    ASSERT_TRUE(hit.proven) << k;
    expect_sound(q, settings, hit, 200);
    // and a hit is found no later than by small steps
    Long first = 2;
    for (int i = 0; i <= 400; ++i) {
      if (q.distance(i / Long{400}) > settings.thickness) continue;
      first = i / Long{400};
      break;
    }
    if (first <= 1) {
      ++hits;
      ASSERT_TRUE(hit.hit) << k;
      ASSERT_LE(hit.time, first) << k;
    } else if (!hit.hit) {
      ++misses;
    } else {
      ++between;  // within the tolerance, or within one small step
    }
  }
  EXPECT_GT(hits, 400);
  EXPECT_GT(misses, 1000);
  std::cout << hits << " hits, " << misses << " misses, " << between << " that small steps don't see\n";
}

// Volume spanned by the four nodes: cubic in time.
Quad volume_at(const Query& q, Quad t) {
  const auto a = q.node(0, t);
  return (q.node(1, t) - a).cross(q.node(2, t) - a).dot(q.node(3, t) - a);
}

// At a time of coplanarity: do they meet? By the signs of areas along the common normal.
bool meets_at(const Query& q, Quad t) {
  const auto a = q.node(0, t), b = q.node(1, t), c = q.node(2, t), d = q.node(3, t);
  if (!q.edges) {
    const Wide<Quad> n = (c - b).cross(d - b);
    return (c - b).cross(a - b).dot(n) >= 0 && (d - c).cross(a - c).dot(n) >= 0 && (b - d).cross(a - d).dot(n) >= 0;
  }
  const Wide<Quad> n = (b - a).cross(d - c);
  const auto apart = [&](const Wide<Quad>& e, const Wide<Quad>& from, const Wide<Quad>& x, const Wide<Quad>& y) {
    return e.cross(x - from).dot(n) * e.cross(y - from).dot(n) > 0;
  };
  return !apart(b - a, a, c, d) && !apart(d - c, c, a, b);
}

// Times in [0, 1] at which the volume changes sign: one at most between 0, 1 and the extrema.
std::vector<Quad> coplanar_times(const Query& q) {
  const auto f = [&](double t) { return static_cast<double>(volume_at(q, t)); };
  const double even = (f(1) + f(-1)) / 2 - f(0), odd = (f(1) - f(-1)) / 2;  // f(t) = f(0) + (odd - c) t + even t^2 + c t^3
  const double c = (f(2) - f(0) - 2 * odd - 4 * even) / 6, discriminant = even * even - 3 * c * (odd - c);
  std::vector<Quad> cuts{0};
  if (discriminant > 0) {
    const double r = std::sqrt(discriminant), x = (-even - r) / (3 * c), y = (-even + r) / (3 * c);
    for (const double t : {std::min(x, y), std::max(x, y)})
      if (t > 0 && t < 1) cuts.push_back(t);
  }
  cuts.push_back(1);
  std::vector<Quad> times;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    Quad low = cuts[i], high = cuts[i + 1];
    const bool up = volume_at(q, high) > 0;
    if ((volume_at(q, low) > 0) == up) continue;
    for (int k = 0; k < 110; ++k) {
      const Quad middle = (low + high) / 2;
      ((volume_at(q, middle) > 0) == up ? high : low) = middle;
    }
    times.push_back(high);
  }
  return times;
}

TEST(ContinuousRandom, FirstContactAgreesWithTheCubic) {
  Random random(3);
  int hits = 0, only_ours = 0;
  double latest = 0;
  for (int k = 0; k < 3000; ++k) {
    const Query q = random_query(random, k % 2 == 0, 2);
    const ContinuousSettings settings{0, 1e-10};
    const ContinuousHit hit = q.ask(settings);
    ASSERT_TRUE(hit.proven) << k;
    double first = 2;
    for (const Quad t : coplanar_times(q))
      if (meets_at(q, t)) {
        first = static_cast<double>(t);
        break;
      }
    if (first > 1) {
      only_ours += hit.hit;
      continue;
    }
    ++hits;
    ASSERT_TRUE(hit.hit) << k;
    ASSERT_LE(hit.time, first + 1e-15) << k;
    latest = std::max(latest, first - hit.time);
    EXPECT_LT(first - hit.time, 1e-5) << k;
  }
  EXPECT_GT(hits, 200);
  EXPECT_LE(only_ours, 1);  // a pass within 1e-10
  std::cout << hits << " hits, at most " << latest << " before the root; " << only_ours << " that the cubic doesn't have\n";
}

// Passes that come near and turn away in the same moment, at a distance of the thickness and about a clearance: the hardest to
// tell from contacts. The tolerance is a hundredth of the clearance.
TEST(ContinuousRandom, NearMissesAreToldWithProof) {
  Random random(4);
  for (const double clearance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    const ContinuousSettings settings{0.05, clearance * 0.01};
    int misses = 0, most = 0;
    double directions = 0;
    for (int k = 0; k < 20000;) {
      Query q = random_query(random, random(0, 1) < 0.5, random(0.1, 3));
      const double turn = q.ask({settings.thickness + clearance, 1e-3 * clearance}).time;
      if (turn == 0 || turn == 1) continue;
      for (auto& node : q.nodes) {
        const Vec3 there = (1 - turn) * node.start + turn * node.end;
        node.end = there + (there - node.start) * 1e-3 + random.vector(-0.5, 0.5) * clearance;
      }
      const ContinuousHit answer = q.ask(settings);
      ASSERT_TRUE(answer.proven) << k;
      if (k % 100 == 0) expect_sound(q, settings, answer, 20);
      misses += !answer.hit, most = std::max(most, answer.directions), directions += answer.directions;
      ++k;
    }
    EXPECT_GT(misses, 100);
    std::cout << "clearance " << clearance << ": " << misses << " of 20000 miss; directions: mean " << directions / 20000
              << ", most " << most << "\n";
  }
}

template <class Make>
void measure(const char* name, Make make) {
  std::vector<Query> queries;
  for (int k = 0; k < 20000; ++k) queries.push_back(make(k % 2 == 0));
  int hits = 0, directions = 0, most = 0;
  const auto start = std::chrono::steady_clock::now();
  for (const Query& q : queries) {
    const ContinuousHit hit = q.ask({1e-3, 1e-6});
    hits += hit.hit, directions += hit.directions, most = std::max(most, hit.directions);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::cout << name << ": " << seconds / 20000 * 1e9 << " ns a query; directions: mean " << directions / 20000.0 << ", most "
            << most << "; " << hits / 200.0 << " % hits\n";
}

TEST(ContinuousRandom, CostPerQuery) {
  Random random(5);
  measure("far apart", [&](bool edges) {
    Query q = random_query(random, edges, 0.5);
    q.nodes[0].start.x() += 3, q.nodes[0].end.x() += 3;
    if (edges) q.nodes[1].start.x() += 3, q.nodes[1].end.x() += 3;
    return q;
  });
  measure("any motion in a box", [&](bool edges) { return random_query(random, edges, 1); });
  measure("two layers that slide, 0.01 apart", [&](bool edges) {
    Query q = random_query(random, edges, 0);
    const Vec3 slide(random(-1, 1), random(-1, 1), 0);
    const Quat turn = random.turn();
    for (std::size_t i = 0; i < 4; ++i) {
      auto& node = q.nodes[i];
      node.start.z() = random(0, 1e-3) + (i < (edges ? 2 : 1) ? 1e-2 : 0);
      node.end = node.start + random.vector(-1e-3, 1e-3) + (i < (edges ? 2 : 1) ? slide : Vec3(Vec3::Zero()));
      node = {turn * node.start, turn * node.end};
    }
    return q;
  });
}

}  // namespace
}  // namespace unibody::continuous_random_test
