// Bodies of many parts lie on many points at once; few of them carry.
#pragma once

#include <vector>

#include "collide/narrowphase.hpp"

namespace unibody {

// Makes one of all manifolds of a pair (of bodies at the step's start) that share a normal, with at most PairManifold::kept
// points: those that are lowest when the body is tilted, in eight directions, by so much that it sinks by the margin (m) at its
// reach, by an eighth of that, or not at all. Gaps along one normal are affine in place, and so is their change: while those
// points hold, the others do at these tilts, to a thousandth of the margin. For solvers that split a body's mass among its
// manifolds.
// Inner rings (face_patch.hpp) stay as they are.
void merge_supports(std::vector<PairManifold>& manifolds, double margin);

// The manifold of such points alone.
PairManifold support_of(const std::vector<ContactPoint>& points, const Vec3& normal, double margin);

inline constexpr double same_normal = 1 - 1e-8;  // the cosine from which on two manifolds share a normal

// Whether the two may be made one.
bool share_normal(const PairManifold& a, const PairManifold& b);

}  // namespace unibody
