// A box over a plane: every corner within the margin, so that a plate may fall flat within the step.
#include "collide/shape_pairs.hpp"

namespace unibody {

void box_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  out.normal = b.rotation.col(2);
  if (settings.planar) out.normal = Vec3(out.normal.x(), 0, out.normal.z()).normalized();
  const double height = out.normal.dot(a.position - b.position);
  Mat3 edges;  // half edges, as columns
  for (int k = 0; k < 3; ++k) edges.col(k) = a.half[k] * a.rotation.col(k);
  if (settings.planar) edges.col(1).setZero();
  const Vec3 rise = edges.transpose() * out.normal;
  for (unsigned corner = 0; corner < 8; ++corner) {
    if (settings.planar && (corner & 2)) continue;
    const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const double gap = height + sign.dot(rise);
    if (gap > settings.margin) continue;
    out.add(edges * sign - 0.5 * gap * out.normal, gap, corner);
  }
}

}  // namespace unibody
