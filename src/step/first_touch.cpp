#include "step/first_touch.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

// Newton's method, from the left. Of a convex gap its steps never pass the root; where a gap is not convex and a step does pass
// it, the root lies between two known times, and the interval is halved instead.
double first_touch_of_spheres(const Vec3& apart, const Vec3& velocity, const Vec3& acceleration, double step, double reach,
                              double from, double to) {
  const auto place = [&](double t) -> Vec3 { return apart + t * velocity + 0.5 * t * (t - step) * acceleration; };
  const auto speed = [&](double t) -> Vec3 { return velocity + (t - 0.5 * step) * acceleration; };
  const double close = 1e-12 * reach;
  double t = from, apart_at = from, within = never;  // times at which they are apart, and at which they are in each other
  for (int i = 0; i < 100; ++i) {
    const Vec3 x = place(t);
    const double distance = x.norm(), gap = distance - reach;
    const double closing = distance > 0 ? -x.dot(speed(t)) / distance : 0;
    if (std::abs(gap) <= close || (gap < 0 && t == from)) return closing > 0 ? t : never;
    double next = never;
    if (gap < 0) {
      within = t;
    } else {
      apart_at = t;
      if (closing > 0) next = t + gap / closing;
      if (within == never && !(closing > 0)) return never;
    }
    if (within == never && !(next <= to)) {
      if (!(place(to).norm() < reach)) return never;
      within = to;
    }
    t = next < within ? next : 0.5 * (apart_at + within);
  }
  return t;
}

double first_touch_of_plane(double gap, double velocity, double acceleration, double step, double from, double to) {
  const auto height = [&](double t) { return gap + t * velocity + 0.5 * t * (t - step) * acceleration; };
  const auto speed = [&](double t) { return velocity + (t - 0.5 * step) * acceleration; };
  if (height(from) <= 0) return speed(from) < 0 ? from : never;
  const double a = 0.5 * acceleration, b = velocity - 0.5 * step * acceleration, discriminant = b * b - 4 * a * gap;
  if (!(discriminant >= 0)) return never;
  // the roots without cancellation
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  double first = never;
  for (const double t : {a != 0 ? q / a : never, q != 0 ? gap / q : never})
    if (t >= from && t <= to && speed(t) < 0) first = std::min(first, t);
  return first;
}

}  // namespace unibody
