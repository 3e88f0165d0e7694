#include "collide/box_edges.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

constexpr double along_each_other = 1 - 1e-6;  // cosine between edges
constexpr double lying_flat = 0.996;           // cosine above which two faces count as lying on each other: 5 degrees
constexpr double closeness = 0.3;              // of the smallest half edge
constexpr double roundness = 0.05;             // the radius by which edges count as rounded, of the smallest half edge

// Edges of a box that run along its axis `along`, seen across it: by the signs of their places along the other two axes.
struct Edge {
  int along, signs;
  Vec3 place(const Vec3& half) const {  // in the box's axes, the middle of the edge
    Vec3 p = Vec3::Zero();
    p[(along + 1) % 3] = signs & 1 ? half[(along + 1) % 3] : -half[(along + 1) % 3];
    p[(along + 2) % 3] = signs & 2 ? half[(along + 2) % 3] : -half[(along + 2) % 3];
    return p;
  }
  Vec3 outwards() const { return place(Vec3::Constant(std::sqrt(0.5))); }  // unit
};

bool lies_between(const Vec3& n, const Edge& edge) {
  const Vec3 o = edge.outwards();
  return n[(edge.along + 1) % 3] * o[(edge.along + 1) % 3] > 0 && n[(edge.along + 2) % 3] * o[(edge.along + 2) % 3] > 0;
}

// The normal of two edges that are rounded by `radius`, from the way from one sharp edge to the other: half way between their
// own directions where they meet, and along the way from edge to edge where that is long against the radius.
Vec3 rounded_normal(const Vec3& between, const Vec3& middle, double radius) {
  const double apart = between.dot(middle);
  return (between + (std::max(0.0, -apart) + radius) * middle).normalized();
}

}  // namespace

bool manifold_of_meeting_edges(const Proxy& a, const Proxy& b, const BoxRelation& r, bool planar, double margin,
                               PairManifold& out) {
  const Vec3 offset(r.offset[0], r.offset[1], r.offset[2]);
  Mat3 turn;  // from b's axes to a's
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) turn(i, j) = r.turn[i][j];
  const double smallest = std::min(a.half.minCoeff(), b.half.minCoeff());
  for (int i = planar ? 1 : 0; i < (planar ? 2 : 3); ++i)
    for (int j = planar ? 1 : 0; j < (planar ? 2 : 3); ++j) {
      const int i1 = (i + 1) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      if (r.cosine[i][j] < along_each_other || std::max(r.cosine[i1][j1], r.cosine[i1][j2]) > lying_flat) continue;
      const double low = std::max(-a.half[i], offset[i] - b.half[j]), high = std::min(a.half[i], offset[i] + b.half[j]);
      if (!planar && !(low < high)) continue;
      for (int s = 0; s < 16; ++s) {
        const Edge of_a{i, s & 3}, of_b{j, s >> 2};
        Vec3 on_a = of_a.place(a.half), on_b = offset + turn * of_b.place(b.half);
        on_a[i] = on_b[i] = 0;
        const Vec3 between = on_b - on_a;
        if (between.norm() > closeness * smallest) continue;
        Vec3 middle = of_a.outwards() - turn * of_b.outwards();
        middle[i] = 0;
        if (!(middle.norm() > 0.1)) continue;
        middle.normalize();
        const Vec3 n = rounded_normal(between, middle, roundness * smallest);
        if (!lies_between(n, of_a) || !lies_between(-(turn.transpose() * n), of_b)) continue;
        const double gap = n.dot(between);
        if (gap > margin) continue;
        out.normal = -(a.rotation * n);
        const std::uint32_t feature = 1u << 15 | static_cast<std::uint32_t>((3 * i + j) * 16 + s) << 1;
        for (std::uint32_t end = 0; end < (planar ? 1u : 2u); ++end) {
          Vec3 point = 0.5 * (on_a + on_b);
          point[i] = planar ? 0 : end ? high : low;
          out.add(a.rotation * point, gap, feature | end);
        }
        return true;
      }
    }
  return false;
}

}  // namespace unibody
