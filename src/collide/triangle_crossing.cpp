#include "collide/triangle_crossing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace unibody {

namespace {

constexpr double roundoff = 0x1p-53;

int sign(double x) { return (x > 0) - (x < 0); }

// high + low without error, high being the rounded result.
struct Pair {
  double high, low;
};
Pair sum(double a, double b) {
  const double high = a + b, of_b = high - a;
  return {high, (a - (high - of_b)) + (b - of_b)};
}
Pair product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}
Pair difference(double a, double b) { return sum(a, -b); }

// A sum of doubles without rounding: parts that don't overlap, ascending in size (Shewchuk's expansions).
class Expansion {
 public:
  void add(double x) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const Pair s = sum(x, parts_[static_cast<std::size_t>(i)]);
      x = s.high;
      if (s.low != 0) parts_[static_cast<std::size_t>(kept++)] = s.low;
    }
    if (x != 0) parts_[static_cast<std::size_t>(kept++)] = x;
    count_ = kept;
  }
  void add_product(double a, double b) {
    if (a == 0 || b == 0) return;
    const Pair ab = product(a, b);
    add(ab.low), add(ab.high);
  }
  void add_product(const Pair& a, const Pair& b, const Pair& c) {
    for (const double x : {a.low, a.high})
      for (const double y : {b.low, b.high}) {
        if (x == 0 || y == 0) continue;
        const Pair xy = product(x, y);
        for (const double z : {c.low, c.high}) add_product(xy.low, z), add_product(xy.high, z);
      }
  }
  int sign_of() const { return count_ == 0 ? 0 : sign(parts_[static_cast<std::size_t>(count_ - 1)]); }

 private:
  std::array<double, 200> parts_;  // 6 products of 3 differences: 6 * 2^3 * 4 = 192 at most
  int count_ = 0;
};

Pair negated(const Pair& x) { return {-x.high, -x.low}; }

int exact_orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<Pair, 3> u, v, w;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    u[i] = difference(b[k], a[k]), v[i] = difference(c[k], a[k]), w[i] = difference(d[k], a[k]);
  }
  Expansion det;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det.add_product(u[i], v[j], w[k]);
    det.add_product(negated(u[k]), v[j], w[i]);
  }
  return det.sign_of();
}

// Sign of (b - a) x (c - a) in the plane of the coordinates x and y.
int orient2d(const Vec3& a, const Vec3& b, const Vec3& c, Eigen::Index x, Eigen::Index y) {
  const double left = (b[x] - a[x]) * (c[y] - a[y]), right = (b[y] - a[y]) * (c[x] - a[x]);
  const double det = left - right;
  if (std::abs(det) > 4 * roundoff * (std::abs(left) + std::abs(right))) return sign(det);
  Expansion exact;
  exact.add_product(difference(b[x], a[x]), difference(c[y], a[y]), {1, 0});
  exact.add_product(negated(difference(b[y], a[y])), difference(c[x], a[x]), {1, 0});
  return exact.sign_of();
}

// Five points on one line: the coordinate along which they differ tells.
bool overlap_on_line(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax({a[k], b[k], c[k]});
    if (std::max(p[k], q[k]) < low || std::min(p[k], q[k]) > high) return false;
  }
  return true;
}

// Five points in one plane, not on one line as seen along the third axis: two convex sets are apart where the line of some side
// has all of one set strictly on one side and none of the other there.
bool overlap_in_plane(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& nodes, Eigen::Index x, Eigen::Index y) {
  const int of_a = orient2d(p, q, nodes[0], x, y);
  if (of_a != 0 && of_a == orient2d(p, q, nodes[1], x, y) && of_a == orient2d(p, q, nodes[2], x, y)) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = nodes[i], &b = nodes[(i + 1) % 3], &c = nodes[(i + 2) % 3];
    const int of_p = orient2d(a, b, p, x, y);
    if (of_p != 0 && of_p == orient2d(a, b, q, x, y) && of_p != orient2d(a, b, c, x, y)) return false;
  }
  return true;
}

bool crosses_in_plane(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 5> all{a, b, c, p, q};
  for (Eigen::Index x = 0; x < 3; ++x) {
    const Eigen::Index y = (x + 1) % 3;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = i + 1; j < 5; ++j)
        for (std::size_t k = j + 1; k < 5; ++k)
          if (orient2d(all[i], all[j], all[k], x, y) != 0) return overlap_in_plane(p, q, {a, b, c}, x, y);
  }
  return overlap_on_line(p, q, a, b, c);
}

}  // namespace

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double xy = u.x() * v.y(), yx = u.y() * v.x(), yz = u.y() * v.z(), zy = u.z() * v.y(), zx = u.z() * v.x(),
               xz = u.x() * v.z();
  const double det = w.x() * (yz - zy) + w.y() * (zx - xz) + w.z() * (xy - yx);
  const double size = std::abs(w.x()) * (std::abs(yz) + std::abs(zy)) + std::abs(w.y()) * (std::abs(zx) + std::abs(xz)) +
                      std::abs(w.z()) * (std::abs(xy) + std::abs(yx));
  if (std::abs(det) > 8 * roundoff * size) return sign(det);  // Shewchuk: 7 u + 56 u^2
  return exact_orient3d(a, b, c, d);
}

bool edge_crosses_face(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int of_p = orient3d(a, b, c, p), of_q = orient3d(a, b, c, q);
  if (of_p == 0 && of_q == 0) {
    // A triangle without area has no plane of its own: the five points may still span space.
    if (orient3d(p, q, a, b) != 0 || orient3d(p, q, b, c) != 0 || orient3d(p, q, c, a) != 0) return false;
    return crosses_in_plane(p, q, a, b, c);
  }
  if (of_p == of_q) return false;
  const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c), ca = orient3d(p, q, c, a);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

}  // namespace unibody
