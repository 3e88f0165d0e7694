// Continuous tests: whether a moving point meets a moving triangle, or a moving edge another, between two moments. All nodes move
// along straight lines at constant speed, so that triangles may stretch and turn on the way. Pure functions of their arguments.
//
// No contact is ever missed, grazing ones, degenerate shapes and rounding included: "no hit" is said only with proof. The two
// meet where the origin lies in the convex hull of the differences of their nodes, and each difference moves along a straight
// line. A direction along which all of them stay further than the thickness from the origin at two moments proves that they do
// so in between; so does one that turns evenly from one moment to the other, by three numbers a difference. From the first moment
// on, the direction of the closest points is followed as far as it proves anything; then it is found anew. Proofs are compared
// against a bound of their rounding, while the closest points need no bound at all: with a poor direction a proof is shorter,
// never wrong.
//
// (The question and the wish for proof are those of B. Wang, Z. Ferguson, T. Schneider, X. Jiang, M. Attene, D. Panozzo, A large
// scale benchmark and an inclusion-based algorithm for continuous collision detection, 2021; the answer is another one.)
#pragma once

#include <array>

#include "core/types.hpp"

namespace unibody {

// A node's place at time 0 and at time 1 of the motion; m.
struct MovingPoint {
  Vec3 start, end;
};

struct ContinuousSettings {
  double thickness = 0;       // m, >= 0: they meet where their distance is this or less
  double tolerance = 1e-6;    // m: hits may be reported while they are further apart than the thickness by up to this
  int most_directions = 200;  // directions tried; where these don't do, a hit is reported (`proven` is false)
};

// The outcome. If there is a hit, there is none before `time`: the distance is proven larger than the thickness from 0 on up to
// then. `time` 0 means that they touch from the start, or nearly.
struct ContinuousHit {
  bool hit = false;
  // True: the distance at `time` is at most thickness + tolerance, within rounding of 1e-14 of the largest difference of nodes.
  // False: it may be more; the tolerance was below the rounding, most_directions was reached, or a length is beyond 1e145 m.
  bool proven = true;
  int directions = 0;               // tried; what the answer cost
  double time = 1;                  // of the hit
  double distance = 0;              // m, at `time`
  std::array<double, 4> weights{};  // at `time`, of the closest points: those of one side sum to 1, in the order of arguments
};

// Weights: 1 for the point, then those of a, b, c.
ContinuousHit point_meets_triangle(const MovingPoint& p, const MovingPoint& a, const MovingPoint& b, const MovingPoint& c,
                                   const ContinuousSettings& settings);

// Weights: those of p0 and p1, then of q0 and q1.
ContinuousHit edge_meets_edge(const MovingPoint& p0, const MovingPoint& p1, const MovingPoint& q0, const MovingPoint& q1,
                              const ContinuousSettings& settings);

}  // namespace unibody
