#include "collide/continuous.hpp"

#include <algorithm>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

constexpr double roundoff = 0x1p-53;
constexpr double too_large = 1e130;  // m times `roundoff`: beyond, squares may overflow

// Closest points at one moment, as the difference of the two.
struct Closest {
  Vec3 between;  // m
  std::array<double, 4> weights;
};

// Differences of nodes: three of a point and a triangle, four of two edges. Each is the rounded difference of the exact
// coordinates, so its error is relative to itself, however far from the origin the scene lies.
template <std::size_t n>
struct Differences {
  std::array<Vec3, n> start, end;

  std::array<Vec3, n> at(double t) const {
    std::array<Vec3, n> now;
    for (std::size_t i = 0; i < n; ++i) now[i] = (1 - t) * start[i] + t * end[i];
    return now;
  }

  // The largest sum of absolute coordinates (m).
  double size() const {
    double largest = 0;
    for (const auto* moment : {&start, &end})
      for (const Vec3& y : *moment) {
        const double length = y.lpNorm<1>();
        if (!(length <= largest)) largest = length;  // a NaN stays
      }
    return largest;
  }
};

Closest closest(const std::array<Vec3, 3>& y) {
  const TrianglePoint nearest = closest_on_triangle(Vec3::Zero(), y[0], y[1], y[2]);
  return {nearest.point, {1, nearest.weights[0], nearest.weights[1], nearest.weights[2]}};
}

// y[2 i + j] is p_i - q_j; seen from q0, one edge goes from y[0] to y[2] and the other from 0 to y[0] - y[1].
Closest closest(const std::array<Vec3, 4>& y) {
  const SegmentPoints nearest = closest_of_segments(y[0], y[2], Vec3::Zero(), y[0] - y[1]);
  return {nearest.first - nearest.second, {1 - nearest.s, nearest.s, 1 - nearest.t, nearest.t}};
}

// Directions across the feature that the closest points lie on. They stay right where the points are so close that the direction
// from one to the other is lost in rounding.
Vec3 across(const Vec3& between, const Vec3& edge) {
  const double squared = edge.squaredNorm();
  return squared > 0 ? Vec3(between - edge * (edge.dot(between) / squared)) : between;
}
Vec3 across(const Vec3& between, const Vec3& u, const Vec3& v) {
  const Vec3 normal = u.cross(v);
  return normal.dot(between) < 0 ? Vec3(-normal) : normal;
}
Vec3 across_feature(const std::array<Vec3, 3>& y, const Closest& c) {
  for (std::size_t k = 0; k < 3; ++k)
    if (c.weights[1 + k] == 0) return across(c.between, y[(k + 2) % 3] - y[(k + 1) % 3]);
  return across(c.between, y[1] - y[0], y[2] - y[0]);
}
Vec3 across_feature(const std::array<Vec3, 4>& y, const Closest& c) {
  const Vec3 first = y[2] - y[0], second = y[1] - y[0];
  const bool in_first = c.weights[0] > 0 && c.weights[1] > 0, in_second = c.weights[2] > 0 && c.weights[3] > 0;
  if (in_first && in_second) return across(c.between, first, second);
  return across(c.between, in_first ? first : second);
}

// The point of the convex hull that has these weights.
Vec3 mean(const std::array<Vec3, 3>& y, const std::array<double, 4>& w) { return w[1] * y[0] + w[2] * y[1] + w[3] * y[2]; }
Vec3 mean(const std::array<Vec3, 4>& y, const std::array<double, 4>& w) {
  return w[0] * (w[2] * y[0] + w[3] * y[1]) + w[1] * (w[2] * y[2] + w[3] * y[3]);
}

// Projections of all differences on a direction of length 1: linear functions of time.
template <std::size_t n>
struct Projections {
  std::array<double, n> start, end;

  Projections(const Differences<n>& differences, const Vec3& direction) {
    for (std::size_t i = 0; i < n; ++i) {
      start[i] = direction.dot(differences.start[i]);
      end[i] = direction.dot(differences.end[i]);
    }
  }

  double at(std::size_t i, double t) const { return (1 - t) * start[i] + t * end[i]; }

  double smallest_at(double t) const {
    double smallest = HUGE_VAL;
    for (std::size_t i = 0; i < n; ++i)
      if (!(at(i, t) >= smallest)) smallest = at(i, t);  // a NaN stays
    return smallest;
  }

  // The moment after t at which the first of them falls to `level`; 1 if none does. All are above it at t.
  double falls_to(double level, double t) const {
    double first = 1;
    for (std::size_t i = 0; i < n; ++i)
      if (!(end[i] >= level)) first = std::min(first, t + (1 - t) * ((at(i, t) - level) / (at(i, t) - end[i])));
    return first;
  }
};

// What is known of one moment.
template <std::size_t n>
struct Moment {
  double time;
  Closest nearest;
  double distance;             // m
  Vec3 direction;              // of length 1 within 4 units: about that of the closest points
  Projections<n> projections;  // on it
  double smallest;             // m, of them: a lower bound of the distance, and close to it if the direction is good

  Moment(const Differences<n>& differences, double t)
      : time(t), nearest(), distance(), direction(Vec3::Zero()), projections(differences, direction), smallest(0) {
    const auto now = differences.at(t);
    nearest = closest(now);
    distance = nearest.between.norm();
    try_direction(differences, nearest.between);
    if (!(smallest > 0.9999 * distance)) try_direction(differences, across_feature(now, nearest));
  }

  void try_direction(const Differences<n>& differences, const Vec3& towards) {
    const double length = towards.norm();
    if (!(length > 1e-150 && length < 1e150)) return;
    const Vec3 candidate = towards / length;
    const Projections<n> along(differences, candidate);
    const double bound = along.smallest_at(time);
    if (bound > smallest) direction = candidate, projections = along, smallest = bound;
  }
};

template <std::size_t n>
class Search {
 public:
  Search(const Differences<n>& differences, const ContinuousSettings& settings) : differences_(differences), settings_(settings) {
    // Rounding of a projection at any time: 4 units of the dot product, 4 of the interpolation, each of |y|_1 at most. A
    // direction of length 1 is longer by 4 units at most. Underflow adds less than 1e-300.
    proof_ = settings.thickness * (1 + 16 * roundoff) + 16 * roundoff * differences.size() + 1e-300;
    // Short of the tolerance, so that where a search along one direction stops, there is room left for rounding.
    aim_ = proof_ + std::max(0.5 * settings.tolerance, 16 * roundoff * (differences.size() + settings.thickness));
  }

  ContinuousHit run() {
    if (!(proof_ < too_large)) return touches(Moment<n>(differences_, 0), false);
    if (apart_along_an_axis()) return {};
    Moment<n> now = moment(0);
    for (;;) {
      if (now.distance <= settings_.thickness + settings_.tolerance) return touches(now, true);
      if (directions_ >= settings_.most_directions || !(now.smallest > aim_)) return touches(now, false);
      const double sure = now.projections.falls_to(aim_, now.time);
      if (!(sure > now.time) || !(now.projections.smallest_at(sure) > proof_)) return touches(now, false);
      if (sure == 1 || (now = later(now, sure)).time == 1) return misses();
    }
  }

 private:
  const Differences<n>& differences_;
  const ContinuousSettings& settings_;
  double proof_;  // m: projections above this prove the distance above the thickness
  double aim_;    // m, a little more: each direction is followed until a projection falls to this
  int directions_ = 0;

  Moment<n> moment(double t) {
    ++directions_;
    return Moment<n>(differences_, t);
  }

  ContinuousHit touches(const Moment<n>& now, bool proven) const {
    return {true, proven, directions_, now.time, now.distance, now.nearest.weights};
  }
  ContinuousHit misses() const {
    ContinuousHit miss;
    miss.directions = directions_;
    return miss;
  }

  // Boxes about the two motions don't come near each other.
  bool apart_along_an_axis() const {
    for (Eigen::Index k = 0; k < 3; ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const auto* ends : {&differences_.start, &differences_.end})
        for (const Vec3& y : *ends) low = std::min(low, y[k]), high = std::max(high, y[k]);
      if (low > proof_ || -high > proof_) return true;
    }
    return false;
  }

  // A moment up to which the two are proven apart, if they are up to `sure` along the present direction. First tried is when the
  // closest points of now would touch, then half way there and so on; each with a direction that turns from the present one to
  // that of then. Without it, two that turn about each other would take many small steps.
  Moment<n> later(const Moment<n>& now, double sure) {
    const auto& w = now.nearest.weights;
    const double rate = now.direction.dot(mean(differences_.end, w) - mean(differences_.start, w));
    double span = 1 - now.time;
    if (rate < 0) span = std::min(span, (now.smallest - aim_) / -rate);
    for (; span > 2 * (sure - now.time) && directions_ < settings_.most_directions; span /= 2) {
      Moment<n> then = moment(now.time + span >= 1 ? 1 : now.time + span);
      if (apart_between(now, then)) return then;
    }
    return moment(sure);
  }

  // Along a direction that turns evenly, and so is never longer than 1, projections are quadratic in time: they stay above what
  // their three Bernstein coefficients do.
  bool apart_between(const Moment<n>& now, const Moment<n>& then) const {
    for (std::size_t i = 0; i < n; ++i) {
      const double middle = 0.5 * (now.projections.at(i, then.time) + then.projections.at(i, now.time));
      if (!(now.projections.at(i, now.time) > proof_ && middle > proof_ && then.projections.at(i, then.time) > proof_))
        return false;
    }
    return true;
  }
};

}  // namespace

ContinuousHit point_meets_triangle(const MovingPoint& p, const MovingPoint& a, const MovingPoint& b, const MovingPoint& c,
                                   const ContinuousSettings& settings) {
  const Differences<3> differences{{p.start - a.start, p.start - b.start, p.start - c.start},
                                   {p.end - a.end, p.end - b.end, p.end - c.end}};
  return Search<3>(differences, settings).run();
}

ContinuousHit edge_meets_edge(const MovingPoint& p0, const MovingPoint& p1, const MovingPoint& q0, const MovingPoint& q1,
                              const ContinuousSettings& settings) {
  const Differences<4> differences{{p0.start - q0.start, p0.start - q1.start, p1.start - q0.start, p1.start - q1.start},
                                   {p0.end - q0.end, p0.end - q1.end, p1.end - q0.end, p1.end - q1.end}};
  return Search<4>(differences, settings).run();
}

}  // namespace unibody
