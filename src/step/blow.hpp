// The impulses of one impact of two bodies, at all the points where they touch at that moment.
#pragma once

#include <array>
#include <cstdint>

#include "collide/narrowphase.hpp"

namespace unibody {

// In axes of the contact: the normal first, then two tangents.
struct Blow {
  struct Friction {
    double along, across;  // the coefficient along the first tangent; that along the second, over it
  };
  std::uint32_t count = 0;                                                 // of points
  std::array<std::array<Mat3, PairManifold::kept>, PairManifold::kept> K;  // 1/kg, velocity at a point by the impulse at another
  std::array<Vec3, PairManifold::kept> before, impulse;                    // m/s, N s

  Vec3 after(std::uint32_t k) const;  // m/s

  // Newton's hypothesis at the points that close, Coulomb friction at all. Newton's hypothesis can give energy where there is
  // friction (constraints/bounce_limit.cpp): the points then part at the share of their speeds at which the impulses do no work.
  void solve(double restitution, const Friction& friction);

 private:
  double solve_at(double restitution, const Friction& friction);
};

}  // namespace unibody
