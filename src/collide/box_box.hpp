// Two boxes: which of the 15 axes separates them best, and the points of contact across that axis. Two steps, so that a
// swept test can choose the axis itself (sweep.cpp).
#pragma once

#include "collide/narrowphase.hpp"

namespace unibody {

// Box b as seen from box a.
struct BoxRelation {
  double turn[3][3];    // turn[i][j] = a's axis i . b's axis j
  double cosine[3][3];  // their absolute values
  double offset[3];     // b's centre in a's frame, m
};
BoxRelation relate_boxes(const Proxy& a, const Proxy& b);

// An axis of the separating axis test.
struct BoxAxis {
  int code;           // 0..2 a's faces, 3..5 b's faces, 6 + 3 i + j: a's edge i x b's edge j
  double separation;  // m, negative when they overlap
};

// The axis of largest separation; false if that exceeds `margin`. An edge axis must be better than the best face axis by
// 0.1 % of the smallest half edge + 2 % of the separation, since a face gives a steadier manifold.
bool find_axis(const BoxRelation& relation, const Vec3& half_a, const Vec3& half_b, double margin, BoxAxis& axis);

// Normal and points for a given axis.
void box_manifold(const Proxy& a, const Proxy& b, const BoxRelation& relation, const BoxAxis& axis, double margin,
                  PairManifold& out);

}  // namespace unibody
