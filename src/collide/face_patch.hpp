// Two faces that lie on each other press on their whole area, while their manifold has points at the rim alone. There friction
// resists spinning too much: that of a disc by mu N R, where an even pressure on its area gives 2/3 mu N R. Where a dynamic
// body's face turns on what is not dynamic, and the body touches nothing else, a second manifold, the inner ring, is added: a
// copy of the first, the rim, that is as much smaller as the area's mean distance from its middle is. The warm start puts the
// load on the inner ring (constraints/level_pressure.hpp), and the rim holds what would tip. Of faces that do not turn the rim is
// enough.
#pragma once

#include <functional>
#include <vector>

#include "collide/narrowphase.hpp"

namespace unibody {

// Whether the manifold is of faces, just one of the bodies is dynamic, and the two turn so fast against each other about its
// normal that friction needs more than a tenth of the step to stop it.
bool needs_inner_ring(const PairManifold& rim, const Proxy& a, const Proxy& b, const CollideSettings& settings);

// The inner rings of one pair of bodies of many parts or triangles, from its manifolds.
class FaceRings {
 public:
  FaceRings(const Proxy& a, const Proxy& b, const CollideSettings& settings);
  void add(const PairManifold& m);
  void for_each(const std::function<void(const PairManifold&)>& f) const;

 private:
  const Proxy &a_, &b_;
  const CollideSettings& settings_;
  bool turns_;  // against each other, so much that it shows
  std::vector<PairManifold> found_;
};

// The rim's points moved towards their mean. Alone, a ring of the mean distance of a disc's points resists a disc that spins
// exactly as its area does, and takes a disc that slides and spins to the ratio of speeds v/(w R) = 0.6445 before it rests, where
// its area does to 0.653 (Farkas, Bartels, Unger, Wolf 2003, Physical Review Letters 90, 248302); of a square to 0.520, and
// 0.510, in units of half its diagonal.
PairManifold inner_ring(const PairManifold& rim);

// Leaves out the inner rings of dynamic bodies that touch others as well. In a pile what presses a pair together changes with all
// its neighbours, and loads that are moved within the pair are loads that the iterations have to find anew. Which bodies those
// are is known where they are home, and there alone are pairs with what does not move.
void leave_out_rings_in_piles(const World& world, Contacts& contacts);

// Hands f the manifolds of collide_parts(), and the inner rings: of parts or triangles that share a normal one for all.
template <class F>
void collide_with_rings(const Proxy& a, const Proxy& b, const CollideSettings& settings, F&& f) {
  if (!is_composite(a.kind) && !is_composite(b.kind))
    return collide_simple(a, b, settings, [&](const PairManifold& m) {
      f(m);
      if (needs_inner_ring(m, a, b, settings)) f(inner_ring(m));
    });
  FaceRings rings(a, b, settings);
  collide_parts(a, b, settings, [&](const PairManifold& m) { f(m), rings.add(m); });
  rings.for_each(f);
}

}  // namespace unibody
