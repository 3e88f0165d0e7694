// Bodies of many parts lie on many points at once; few of them carry.
#pragma once

#include <vector>

#include "collide/narrowphase.hpp"

namespace unibody {

// How far the bodies of a pair may tilt against each other while their contact points stand for them.
struct Tilts {
  double margin;             // m
  double travel = 0;         // m: how far the bodies move against each other in the step, if nothing stops them
  Vec3 turn = Vec3::Zero();  // rad, world: and what the first turns by against the second
};

// Makes one of all manifolds of a pair (of bodies at the step's start) that share a normal, with at most PairManifold::kept
// points: those that are lowest when the body is tilted, in eight directions, by so much that it sinks by the margin at its
// reach, by an eighth of that, or not at all; of bodies that move also by 8, 64, ... times the margin, as far as the step may
// take them, and those that are lowest on the way that the bodies turn. Gaps along one normal are affine in place, and so is
// their change: while those points hold, the others do at these tilts, to a thousandth of the margin. For solvers that split a
// body's mass among its manifolds.
// Inner rings (face_patch.hpp) stay as they are.
void merge_supports(std::vector<PairManifold>& manifolds, const Tilts& tilts);

// The manifold of such points alone.
PairManifold support_of(const std::vector<ContactPoint>& points, const Vec3& normal, const Tilts& tilts);

inline constexpr double same_normal = 1 - 1e-8;  // the cosine from which on two manifolds share a normal

// Whether the two may be made one.
bool share_normal(const PairManifold& a, const PairManifold& b);

}  // namespace unibody
