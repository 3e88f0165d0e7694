// Convex solids other than spheres and boxes on the faces of surfaces.
#include <algorithm>
#include <cmath>

#include "collide/convex_distance.hpp"
#include "collide/mesh_triangles.hpp"
#include "collide/surface_contacts.hpp"
#include "collide/triangle_contacts.hpp"
#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

constexpr std::uint32_t through_feature = 1u << 17;  // above those of a manifold

ConvexBody at_origin(const Proxy& solid) { return convex_body(solid.shape(), solid.rotation, Vec3::Zero()); }

// Weights of what of a face is furthest along a direction: of a node, an edge or all of it.
Vec3 furthest(const TriangleNodes& x, const Vec3& direction, double tolerance) {
  const Vec3 along(direction.dot(x[0]), direction.dot(x[1]), direction.dot(x[2]));
  const Vec3 weights = (along.array() >= along.maxCoeff() - tolerance).cast<double>();
  return weights / weights.sum();
}

}  // namespace

// The share of the step at which a solid, without turning, first touches a face; 2: not within it, 0: they touch. Their distance
// along its direction shrinks no faster than the face's nodes and the solid approach each other along it.
double SurfaceCollider::first_touch_of_solid(const Proxy& solid, const SurfaceFace& face, double radius) const {
  const ConvexBody body = at_origin(solid);
  double time = 0;
  for (int i = 0; i < 32; ++i) {
    TriangleNodes nodes = places(face, time);
    for (Vec3& x : nodes) x -= solid.position + time * settings_.step * solid.velocity;
    ConvexDistance distance;
    if (distance_of_cores(body, convex_triangle(nodes, body.size), HUGE_VAL, distance) != Cores::apart) return time;
    const double gap = distance.gap - radius;
    if (gap <= 1e-6 * body.size) return time;
    double closing = 0;
    for (const Slot s : face.nodes) closing = std::max(closing, -distance.normal.dot(solid.velocity - velocity(s)));
    if (!(closing > 0)) return 2;
    time += gap / (closing * settings_.step);
    if (!(time <= 1)) return 2;
  }
  return time;
}

double SurfaceCollider::passes_solid(const Proxy& solid, const SurfaceFace& face, const Approach& approach) const {
  const Pair& pair = approach.pair;
  const double travelled = travel(solid, face), far = approach.reach + travelled;
  if (!(travelled > least_approach * solid.half_size)) return 0;
  const ConvexBody body = at_origin(solid);
  const auto separation_at = [&](double seconds, Separation& separation) {
    const double time = seconds / settings_.step;
    TriangleNodes nodes = places(face, time);
    for (Vec3& x : nodes) x -= centre_of(solid, time);
    ConvexDistance distance;
    if (distance_of_cores(body, convex_triangle(nodes, body.size), far, distance) != Cores::apart) return false;
    const Vec3 weights = closest_on_triangle(distance.on_b, nodes[0], nodes[1], nodes[2]).weights;
    separation = {distance.gap - pair.radii, -distance.normal.dot(solid.velocity - velocity_on(face, weights))};
    return true;
  };
  const Encounter encounter = encounter_of(settings_.step, 1e-6 * body.size, separation_at);
  return encounter.passes() ? encounter.time / settings_.step : 0;
}

// A solid whose centre has gone through the face in the last step is told to come back.
void SurfaceCollider::add_if_through(Pair pair, const Proxy& solid, const SurfaceFace& face, std::uint32_t feature) {
  if (!settings_.has_past || face.is_segment()) return;
  const TriangleNodes now = places(face, 0), before = places(face, -1);
  const Vec3 came = solid.position - settings_.step * solid.velocity, up = face_normal(now).normalized();
  const double height = up.dot(solid.position - now[0]), was = face_normal(before).normalized().dot(came - before[0]);
  if (!(height * was < 0)) return;
  const double t = was / (was - height);
  TriangleNodes then;
  for (std::size_t k = 0; k < 3; ++k) then[k] = before[k] + t * (now[k] - before[k]);
  const ConvexBody body = at_origin(solid);
  const Vec3 through = came + t * (solid.position - came);
  if (closest_on_triangle(through, then[0], then[1], then[2]).distance > 0.1 * body.size) return;  // beside it
  const Vec3 normal = was > 0 ? up : Vec3(-up);
  const Vec3 weights = closest_on_triangle(solid.position, now[0], now[1], now[2]).weights;
  pair.weights = {1, -weights[0], -weights[1], -weights[2]};
  const double reach = body.rounding - normal.dot(body.support(-normal));
  add(pair, solid.position - place(solid.slot, 0), normal, -std::abs(height) - reach - pair.radii, feature,
      std::abs(height) + 0.1 * body.size);
}

// A convex solid against a face, as box_face() does for a box.
void SurfaceCollider::convex_face(const Proxy& body, const SurfaceFace& face, std::uint32_t first_feature) {
  Approach near = approach(body, face, &SurfaceCollider::first_touch_of_solid);
  add_if_through(near.pair, body, face, first_feature + through_feature);
  stand_or_pass(body, face, near, [&](Approach& then) { return stand_by_solid(then, body, face, first_feature); });
}

bool SurfaceCollider::stand_by_solid(Approach& near, const Proxy& body, const SurfaceFace& face, std::uint32_t first_feature) {
  TriangleNodes nodes = places(face, near.time);
  for (Vec3& x : nodes) x -= near.centre;
  PairManifold found;
  const ConvexBody solid = at_origin(body);
  if (!sheet_manifold(solid, nodes, near.reach, found)) return false;
  // the points share a normal, which is that of one feature of the face: where a neighbour comes closer, it speaks
  const Vec3 feature = without_twin(face, furthest(nodes, found.normal, 1e-6 * solid.size));
  if (!is_nearest(face, feature, found.normal, lean_of_boxes)) return false;
  tidy(found, near.reach);
  bool says = false;
  for (int i = 0; i < found.count; ++i) {
    const ContactPoint& c = found.points[i];
    const TrianglePoint on_face = closest_on_triangle(c.position - 0.5 * c.gap * found.normal, nodes[0], nodes[1], nodes[2]);
    const Vec3 weights = without_twin(face, on_face.weights);
    const bool own = !is_one_node(weights) && owns(face, weights);  // nodes touch bodies as the particles that they are
    if ((time_ == 0 && !own) || !is_nearest(face, weights, found.normal, lean_of_boxes)) continue;
    says = true;
    if (!own) continue;
    const Vec3 arm = on_face.point + body.position - place(body.slot, 0);  // to the face: friction turns nothing by itself
    add_touch(near, weights, arm, found.normal, c.gap, first_feature + c.feature);
  }
  return says;
}

}  // namespace unibody
