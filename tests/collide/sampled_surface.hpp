// Surfaces as patches that can be sampled as densely as one likes, and what samples say of two of them, with its error: the
// distance of the surfaces, and by how much a direction separates what lies between them.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/types.hpp"

namespace unibody::samples {

struct Patch {
  std::function<Vec3(double u, double v)> at;  // m, of the unit square
  double reach_u, reach_v;                     // m, bounds of the first derivatives
  double bend_u = 0, bend_v = 0;               // m, bounds of the second, but for the mixed one
};
using Patches = std::vector<Patch>;

inline Patch quad(const Vec3& from, const Vec3& a, const Vec3& b) {
  return {[=](double u, double v) -> Vec3 { return from + u * a + v * b; }, a.norm(), b.norm()};
}
inline Patch triangle(const Vec3& p, const Vec3& q, const Vec3& r) {
  return {[=](double u, double v) -> Vec3 { return p + u * (q - p + v * (r - q)); }, std::max((q - p).norm(), (r - p).norm()),
          (r - q).norm()};
}
constexpr double around = 2 * std::numbers::pi;
inline Vec3 on_circle(double radius, double turns, double z) {
  return {radius * std::cos(around * turns), radius * std::sin(around * turns), z};
}
inline Patch tube(double radius, double low, double high) {
  return {[=](double u, double v) { return on_circle(radius, v, low + u * (high - low)); }, high - low, around * radius, 0,
          around * around * radius};
}
inline Patch lid(double radius, double z) {
  return {[=](double u, double v) { return on_circle(u * radius, v, z); }, radius, around * radius, 0, around * around * radius};
}
inline Patch dome(double radius, double z, double from, double to) {  // between two angles to the z axis
  const double angle = to - from;
  return {[=](double u, double v) {
            const double polar = from + u * angle;
            return on_circle(radius * std::sin(polar), v, z + radius * std::cos(polar));
          },
          radius * angle, around * radius, radius * angle * angle, around * around * radius};
}
inline Patch ring(double radius) {  // in the x-z plane
  return {[=](double u, double) { return Vec3(radius * std::cos(around * u), 0, radius * std::sin(around * u)); },
          around * radius, 0, around * around * radius};
}

inline Patches moved(const Patches& patches, const Vec3& place, const Mat3& turn) {
  Patches result = patches;
  for (Patch& p : result) p.at = [at = p.at, place, turn](double u, double v) -> Vec3 { return place + turn * at(u, v); };
  return result;
}

// All of a patch within the square lies within the radius of its middle.
struct PatchCell {
  const Patch* patch;
  double u, v, half_u, half_v;
  Vec3 middle = patch->at(u, v);
  double radius = patch->reach_u * half_u + patch->reach_v * half_v;  // m

  PatchCell half(bool second) const {
    PatchCell c = *this;
    const bool along_u = patch->reach_u * half_u >= patch->reach_v * half_v;
    double &middle_of = along_u ? c.u : c.v, &half_of = along_u ? c.half_u : c.half_v;
    half_of /= 2, middle_of += second ? half_of : -half_of;
    return {patch, c.u, c.v, c.half_u, c.half_v};
  }
};

inline std::vector<PatchCell> whole_cells(const Patches& patches) {
  std::vector<PatchCell> cells;
  for (const Patch& p : patches) cells.push_back({&p, 0.5, 0.5, 0.5, 0.5});
  return cells;
}

// Points of a surface, so that it has none further than `spacing` (m) from one of them.
inline std::vector<Vec3> spread_points(const Patches& patches, double spacing) {
  std::vector<PatchCell> open = whole_cells(patches);
  std::vector<Vec3> points;
  while (!open.empty()) {
    const PatchCell cell = open.back();
    open.pop_back();
    if (cell.radius <= spacing)
      points.push_back(cell.middle);
    else
      open.push_back(cell.half(false)), open.push_back(cell.half(true));
  }
  return points;
}

// A share by which a sampled distance may be too large, whatever its fineness.
constexpr double worst_share = 0.2;

// m, not less than the distance of the two surfaces, and not more by more than the larger of `fineness` (m) and that share: of
// samples that become denser where they may still be the nearest.
inline double sampled_distance(const Patches& a, const Patches& b, double fineness) {
  struct Two {
    PatchCell a, b;
    double distance() const { return (a.middle - b.middle).norm(); }
  };
  std::vector<Two> open, next;
  for (const PatchCell& x : whole_cells(a))
    for (const PatchCell& y : whole_cells(b)) open.push_back({x, y});
  double best = HUGE_VAL;
  while (!open.empty()) {
    for (const Two& t : open) best = std::min(best, t.distance());
    next.clear();
    for (const Two& t : open) {
      const double radii = t.a.radius + t.b.radius;
      const double error = std::max(fineness, worst_share * best);
      if (radii <= error || t.distance() - radii >= best - error) continue;
      for (const bool second : {false, true})
        next.push_back(t.a.radius >= t.b.radius ? Two{t.a.half(second), t.b} : Two{t.a, t.b.half(second)});
    }
    open.swap(next);
  }
  return best;
}
inline double sampled_distance(const Patches& a, const Vec3& x, double fineness) {
  return sampled_distance(a, Patches{{[x](double, double) { return x; }, 0, 0}}, fineness);
}

// Points of a convex piece's surface, so many that they reach as far as it in any direction but for `shortfall` (m): by the error
// of the bilinear interpolation between them, whose patches reach no further than their corners.
struct Cloud {
  static constexpr double shortfall = 2e-4;
  Eigen::Matrix3Xd points;
  Vec3 middle;
  double radius;  // m, about the middle

  explicit Cloud(const Patches& patches) {
    std::vector<Vec3> list;
    for (const Patch& p : patches) {
      const auto count = [](double bend) { return std::max(1, static_cast<int>(std::ceil(std::sqrt(bend / (4 * shortfall))))); };
      const int nu = count(p.bend_u), nv = count(p.bend_v);
      for (int i = 0; i <= nu; ++i)
        for (int j = 0; j <= nv; ++j) list.push_back(p.at(double(i) / nu, double(j) / nv));
    }
    points.resize(3, static_cast<Eigen::Index>(list.size()));
    for (std::size_t k = 0; k < list.size(); ++k) points.col(static_cast<Eigen::Index>(k)) = list[k];
    middle = points.rowwise().mean();
    radius = (points.colwise() - middle).colwise().norm().maxCoeff();
  }
};

// m, by which the clouds are apart across a direction (unit, from b to a): not less than the pieces are, and not more by more
// than twice the shortfall.
inline double sampled_separation(const Cloud& a, const Cloud& b, const Vec3& n) {
  return (n.transpose() * a.points).minCoeff() - (n.transpose() * b.points).maxCoeff();
}

// Whether any direction separates the clouds by more than `limit` (m); no says that none does by more than limit + fineness (m).
// Directions become denser where one may still do.
inline bool any_separates(const Cloud& a, const Cloud& b, double limit, double fineness) {
  struct Square {
    int face;
    double x, y, half;
  };
  const double furthest = (a.middle - b.middle).norm() + a.radius + b.radius;  // m, a separation's change per change of direction
  std::vector<Square> open;
  for (int face = 0; face < 6; ++face) open.push_back({face, 0, 0, 1});
  while (!open.empty()) {
    const Square s = open.back();
    open.pop_back();
    Vec3 n;
    n[s.face / 2] = s.face % 2 ? 1 : -1, n[(s.face / 2 + 1) % 3] = s.x, n[(s.face / 2 + 2) % 3] = s.y;
    const double here = sampled_separation(a, b, n.normalized());
    if (here > limit) return true;
    // onto the sphere no two points of the cube get further apart
    if (here + furthest * s.half * std::numbers::sqrt2 <= limit + fineness) continue;
    const double h = s.half / 2;
    for (const double x : {-h, h})
      for (const double y : {-h, h}) open.push_back({s.face, s.x + x, s.y + y, h});
  }
  return false;
}

}  // namespace unibody::samples
