// The five projections against brute force: the nearest of many points of the admissible set.
#include "constraints/friction.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"

namespace unibody::friction_test {

namespace {

struct Triple {
  double n, s, t;
};

template <FrictionModel model>
Triple projected(const Triple& y, double mu) {
  const ConeForce p = project<model>({broadcast(y.n), broadcast(y.s), broadcast(y.t)}, broadcast(mu));
  return {p.n[2], p.s[2], p.t[2]};
}

double distance(const Triple& a, const Triple& b) { return std::hypot(a.n - b.n, a.s - b.s, a.t - b.t); }

// Nearest point of |(s, t)| <= mu n by a search over direction and height: nested golden sections, since the distance is unimodal
// in the height along each ray of the cone.
Triple nearest_on_cone(const Triple& y, double mu) {
  const double size = std::hypot(y.n, y.s, y.t);
  Triple best{0, 0, 0};
  double least = size;
  if (std::hypot(y.s, y.t) <= mu * y.n) return y;
  for (int a = 0; a < 3600; ++a) {
    const double angle = a * 2 * M_PI / 3600;
    double low = 0, high = 2 * size;
    const auto at = [&](double n) { return Triple{n, mu * n * std::cos(angle), mu * n * std::sin(angle)}; };
    for (int i = 0; i < 60; ++i) {
      const double p = low + 0.382 * (high - low), q = low + 0.618 * (high - low);
      (distance(at(p), y) < distance(at(q), y) ? high : low) = distance(at(p), y) < distance(at(q), y) ? q : p;
    }
    if (distance(at(low), y) < least) least = distance(at(low), y), best = at(low);
  }
  return best;
}

}  // namespace

TEST(Friction, ConeIsTheNearestPoint) {
  samples::Random random(5);
  for (int k = 0; k < 60; ++k) {
    const double mu = random(0.05, 2);
    const Triple y{random(-1, 1), random(-1, 1), random(-1, 1)};
    const Triple p = projected<FrictionModel::cone>(y, mu), q = nearest_on_cone(y, mu);
    EXPECT_LE(std::hypot(p.s, p.t), mu * p.n + 1e-15);
    EXPECT_LE(distance(p, y), distance(q, y) + 1e-12);
    EXPECT_LT(distance(p, q), 2e-3);  // the search turns in steps of a tenth of a degree
  }
}

// The projected point lies on the border of the ellipse, and the line from it to the given point is square to the border. The
// given points lie up to a million limits away from the origin, and the flattest ellipses have the smallest ratio that a scene
// may ask for.
TEST(Friction, EllipseIsTheNearestPoint) {
  samples::Random random(7);
  for (int k = 0; k < 100000; ++k) {
    const double across = k % 10 == 0 ? 0.01 : std::pow(0.01, random(0, 1)), limit = std::pow(10, random(-6, 3));
    const double size = std::pow(10, random(-2, 6)) * limit, angle = random(0, 2 * M_PI);
    const double y_s = size * std::cos(angle), y_t = size * std::sin(angle);
    Vec4d s = broadcast(y_s), t = broadcast(y_t);
    clamp_ellipse(s, t, broadcast(limit), broadcast(across));
    if (std::hypot(y_s, y_t / across) <= limit) {
      EXPECT_EQ(s[1], y_s);
      EXPECT_EQ(t[1], y_t);
      continue;
    }
    EXPECT_NEAR(std::hypot(s[1], t[1] / across), limit, 1e-14 * limit);
    const double normal_s = s[1], normal_t = t[1] / (across * across), away_s = y_s - s[1], away_t = y_t - t[1];
    const double normal = std::hypot(normal_s, normal_t);
    EXPECT_LT(std::abs(normal_s * away_t - normal_t * away_s), 1e-12 * normal * size) << across << ' ' << y_s << ' ' << y_t;
    EXPECT_GE(normal_s * away_s + normal_t * away_t, 0);
  }
  Vec4d s = broadcast(3), t = broadcast(-4);
  clamp_ellipse(s, t, broadcast(0), broadcast(0.5));
  EXPECT_EQ(s[0], 0);
  EXPECT_EQ(t[0], 0);
}

// What a projection on a closed convex cone is, to round-off: p in K, p - y in the dual cone, (p - y) . p = 0.
TEST(Friction, ConeSatisfiesMoreausConditions) {
  samples::Random random(6);
  for (int k = 0; k < 1000; ++k) {
    const double mu = random(0, 2);
    const Triple y{random(-1, 1), random(-1, 1), random(-1, 1)};
    for (const Triple& p : {projected<FrictionModel::cone>(y, mu), projected<FrictionModel::saxce>(y, mu)}) {
      const Triple d{p.n - y.n, p.s - y.s, p.t - y.t};
      EXPECT_NEAR(d.n * p.n + d.s * p.s + d.t * p.t, 0, 1e-14);
      EXPECT_GE(d.n - mu * std::hypot(d.s, d.t), -1e-14);
      EXPECT_LE(std::hypot(p.s, p.t), mu * p.n + 1e-15);
    }
  }
}

TEST(Friction, ConeAtItsEdges) {
  const Triple inside = projected<FrictionModel::cone>({2, 0.3, 0.4}, 0.5);
  EXPECT_EQ(distance(inside, {2, 0.3, 0.4}), 0);
  EXPECT_EQ(distance(projected<FrictionModel::cone>({-1, 0.3, 0.4}, 0.5), {0, 0, 0}), 0);
  EXPECT_EQ(distance(projected<FrictionModel::cone>({-1, 0, 0}, 0.5), {0, 0, 0}), 0);
  EXPECT_EQ(distance(projected<FrictionModel::cone>({0, 0, 0}, 0.5), {0, 0, 0}), 0);
  EXPECT_LT(distance(projected<FrictionModel::cone>({0, 3, 4}, 0.5), {2, 0.6, 0.8}), 1e-15);  // (n + mu t) / (1 + mu^2) = 2
}

// Disc and box: the normal on its own, then the nearest tangent within mu n.
TEST(Friction, DiscIsTheNearestTangentWithinTheLimit) {
  samples::Random random(7);
  for (int k = 0; k < 1000; ++k) {
    const double mu = random(0, 2);
    const Triple y{random(-1, 1), random(-1, 1), random(-1, 1)};
    const Triple p = projected<FrictionModel::disc>(y, mu);
    const double limit = mu * std::max(0.0, y.n), length = std::hypot(y.s, y.t);
    EXPECT_EQ(p.n, std::max(0.0, y.n));
    const double scale = length > limit ? limit / length : 1;
    EXPECT_NEAR(p.s, scale * y.s, 1e-15);
    EXPECT_NEAR(p.t, scale * y.t, 1e-15);
  }
}

TEST(Friction, BoxClampsEachTangent) {
  samples::Random random(8);
  for (int k = 0; k < 1000; ++k) {
    const double mu = random(0, 2);
    const Triple y{random(-1, 1), random(-1, 1), random(-1, 1)};
    const Triple p = projected<FrictionModel::box>(y, mu);
    const double limit = mu * std::max(0.0, y.n);
    EXPECT_EQ(p.n, std::max(0.0, y.n));
    EXPECT_EQ(p.s, std::clamp(y.s, -limit, limit));
    EXPECT_EQ(p.t, std::clamp(y.t, -limit, limit));
  }
}

// Each lane on its own: four different triples give what each gives alone.
TEST(Friction, LanesAreIndependent) {
  samples::Random random(9);
  for (int k = 0; k < 200; ++k) {
    ConeForce y{};
    Vec4d mu{};
    for (std::size_t l = 0; l < lanes; ++l) {
      y.n[l] = random(-1, 1), y.s[l] = random(-1, 1), y.t[l] = random(-1, 1), mu[l] = random(0, 1);
    }
    const ConeForce all[2] = {project<FrictionModel::cone>(y, mu), project<FrictionModel::disc>(y, mu)};
    for (std::size_t l = 0; l < lanes; ++l) {
      const Triple one{y.n[l], y.s[l], y.t[l]};
      const Triple alone[2] = {projected<FrictionModel::cone>(one, mu[l]), projected<FrictionModel::disc>(one, mu[l])};
      for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(all[i].n[l], alone[i].n);
        EXPECT_EQ(all[i].s[l], alone[i].s);
        EXPECT_EQ(all[i].t[l], alone[i].t);
      }
    }
  }
}

}  // namespace unibody::friction_test
