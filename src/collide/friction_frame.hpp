// The two directions across a contact's normal in which friction is told, and how its coefficient differs between them.
#pragma once

#include <cmath>

#include "core/types.hpp"

namespace unibody {

// The first of two directions across a unit normal, s; the second is n x s. Fixed by the normal alone; in the x-z plane for
// normals in it.
inline Vec3 first_tangent_of(const Vec3& n) {
  if (std::abs(n.y()) < 0.7) {  // y x n
    const double scale = 1 / std::sqrt(n.x() * n.x() + n.z() * n.z());
    return {scale * n.z(), 0, -scale * n.x()};
  }
  const double scale = 1 / std::sqrt(n.y() * n.y() + n.z() * n.z());  // x x n
  return {0, -scale * n.z(), scale * n.y()};
}

// Of a contact with anisotropic friction: the force of friction is in the ellipse with the half axes mu N along s and across mu N
// along t = n x s, where mu is the contact's own coefficient and N its normal force.
struct FrictionFrame {
  Vec3 s;             // unit, across the normal
  double across = 1;  // 0 to 1

  // The same direction across another normal, to which the contact's has turned.
  Vec3 turned_to(const Vec3& n) const { return (s - n * n.dot(s)).normalized(); }

  Mat3 axes_about(const Vec3& n) const {  // columns n, s and n x s
    Mat3 axes;
    axes << n, s, n.cross(s);
    return axes;
  }
};

}  // namespace unibody
