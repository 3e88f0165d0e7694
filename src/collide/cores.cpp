#include "collide/cores.hpp"

#include <algorithm>

#include "collide/convex_distance.hpp"
#include "world/hull.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

bool has_core(const Proxy& p) { return p.dynamic && p.kind != ShapeKind::plane && !is_round(p.shape()); }

Proxy ball_at_centre(const Proxy& whole, double radius, bool planar) {
  Proxy ball = whole;
  ball.kind = planar ? ShapeKind::disc : ShapeKind::sphere;
  ball.radius = ball.half_size = radius;
  ball.half = Vec3::Constant(radius);
  ball.spin_reach = ball.bounce_reach = 0;
  return ball;
}

// The radius of a body (m). The size of a hull is that of a box around it, which may be wider than it is across some other
// direction.
double radius_of(const Proxy& p) {
  double radius = 0.5 * p.half_size;
  if (p.kind != ShapeKind::hull) return radius;
  const Hull& hull = shape_library().hulls[p.data];
  for (const Hull::Face& face : hull.faces)
    radius = std::min(radius, p.half.x() / hull.size.x() * face.normal.dot(hull.corners[hull.face_corners[face.first]]));
  return radius;
}

// How near the centre may come to what is in a direction (unit). m
double distance_kept(const Proxy& p, double radius, const Vec3& direction) {
  if (p.kind != ShapeKind::hull) return radius;  // others reach as far to both sides
  const ConvexBody body = convex_body(p.shape(), p.rotation, Vec3::Zero());
  const double ahead = direction.dot(body.support(direction)), behind = -direction.dot(body.support(-direction));
  return std::max(radius, 0.5 * (ahead - behind));
}

// Planes are not swept against: their contacts are where the bodies are now, with arms as long as the gap.
void move_to_touch(const Proxy& core, double closing, PairManifold& m) {
  ContactPoint& point = m.points[0];
  if (!(point.gap > 0)) return;
  m.time = point.gap / closing;
  point.position = core.position + m.time * core.velocity - core.radius * m.normal;
}

}  // namespace

void collide_core(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& m) {
  m.count = 0;
  if (!has_core(a)) return;
  const Vec3 velocity = a.velocity - b.velocity;
  const double speed = velocity.norm();
  if (!(settings.step * relative_speed(a, b) > 3 * a.half_size || a.spin_reach > 1.5 * a.half_size)) return;
  const double radius = radius_of(a);
  const double kept_ahead = distance_kept(a, radius, speed > 0 ? Vec3(velocity / speed) : Vec3(Vec3::UnitZ()));
  const Proxy core = ball_at_centre(a, kept_ahead, settings.planar);
  collide_pair(core, b, settings, m);
  if (m.count == 0) return;
  const double kept = distance_kept(a, radius, -m.normal), closing = -m.normal.dot(velocity), fall = std::max(a.fall, b.fall);
  ContactPoint& point = m.points[0];
  const double gap = point.gap + kept_ahead - radius;  // of the core
  point.gap = std::max(point.gap + kept_ahead - kept, std::min(gap, 0.0));
  point.feature = core_feature;
  m.count = point.gap < settings.step * closing + fall ? 1 : 0;
  if (b.kind == ShapeKind::plane && closing > 0) move_to_touch(core, closing, m);
}

bool centre_meets(const Proxy& a, const Proxy& b, double step) {
  CollideSettings settings;
  settings.step = step, settings.margin = 0;
  const Proxy centre = ball_at_centre(a, 1e-3 * a.half_size, false);
  bool meets = false;
  for_each_part(b, [&](const Proxy& part) {
    if (part.kind == ShapeKind::mesh) return;
    PairManifold m;
    collide_pair(centre, part, settings, m);
    meets = meets || (m.count > 0 && m.points[0].gap + step * m.normal.dot(a.velocity - b.velocity) < 0);
  });
  return meets;
}

}  // namespace unibody
