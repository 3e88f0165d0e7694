// Spheres and discs: one point, always exact. In a planar scene all centres have y = 0, and both are circles.
#include <algorithm>
#include <cmath>

#include "collide/shape_pairs.hpp"

namespace unibody {

void round_round(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  const Vec3 between = a.position - b.position;
  const double reach = a.half.x() + b.half.x() + settings.margin;
  const double squared = between.squaredNorm();
  if (squared > reach * reach) return;
  const double distance = std::sqrt(squared);
  // coincident centres: any direction will do if it is always the same
  out.normal = distance > 1e-100 ? Vec3(between / distance) : Vec3::UnitZ();
  const double gap = distance - (a.half.x() + b.half.x());
  out.add(-0.5 * between + 0.5 * (b.half.x() - a.half.x()) * out.normal, gap, 0);
}

void round_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  out.normal = b.rotation.col(2);
  if (settings.planar) out.normal = Vec3(out.normal.x(), 0, out.normal.z()).normalized();
  const double gap = out.normal.dot(a.position - b.position) - a.half.x();
  out.add(-(a.half.x() + 0.5 * gap) * out.normal, gap, 0);
}

namespace {

// The face of the box nearest to a centre inside it; planar boxes have no y faces.
int nearest_face(const Vec3& centre, const Vec3& half, bool planar) {
  int face = 0;
  for (int k = planar ? 2 : 1; k < 3; k += 1)
    if (half[k] - std::abs(centre[k]) < half[face] - std::abs(centre[face])) face = k;
  return face;
}

}  // namespace

void round_box(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  Vec3 centre = b.rotation.transpose() * (a.position - b.position);
  if (settings.planar) centre.y() = 0;
  const Vec3 nearest = centre.cwiseMax(-b.half).cwiseMin(b.half);
  Vec3 normal = centre - nearest;
  double distance = normal.norm();
  if (distance - a.half.x() > settings.margin) return;
  if (distance > 0) {
    normal /= distance;
  } else {
    const int face = nearest_face(centre, b.half, settings.planar);
    normal = std::copysign(1.0, centre[face]) * Vec3::Unit(face);
    distance = std::abs(centre[face]) - b.half[face];
  }
  out.normal = b.rotation * normal;
  const double gap = distance - a.half.x();
  out.add(-(a.half.x() + 0.5 * gap) * out.normal, gap, 0);
}

}  // namespace unibody
