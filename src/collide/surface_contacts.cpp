#include "collide/surface_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "collide/convex_distance.hpp"
#include "collide/mesh_triangles.hpp"
#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

constexpr std::uint32_t edges_feature = 1000, convex_feature = 2000;

// Points closer than this share of their radii are in one place.
constexpr double one_place = 1e-9;

// The sine at which `towards`, less its part along an edge, rises along a unit direction.
double rise(const Vec3& towards, const Vec3& edge, const Vec3& direction) {
  const double squared = edge.squaredNorm();
  const Vec3 inwards = squared > 0 ? Vec3(towards - edge * (edge.dot(towards) / squared)) : towards;
  const double length = inwards.norm();
  return length > 0 ? direction.dot(inwards) / length : 0;
}

// The edge of a face whose two nodes alone have weight: it runs from node i to i + 1. -1: none.
int edge_of(const Vec3& weights) {
  for (int i = 0; i < 3; ++i)
    if (weights[i] > 0 && weights[(i + 1) % 3] > 0 && weights[(i + 2) % 3] == 0) return i;
  return -1;
}

}  // namespace

bool is_one_node(const Vec3& weights) { return (weights.array() > 0).count() == 1; }

// A segment has its second node twice: all of the weight goes to the first of the two.
Vec3 without_twin(const SurfaceFace& face, Vec3 weights) {
  if (face.is_segment()) weights[1] += weights[2], weights[2] = 0;
  return weights;
}

Vec3 SurfaceCollider::velocity_on(const SurfaceFace& face, const Vec3& weights) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += weights[static_cast<Eigen::Index>(k)] * velocity(face.nodes[k]);
  return sum;
}

// The most that a node of one side moves against one of the other (m).
double SurfaceCollider::travel(std::span<const Slot> first, std::span<const Slot> second) const {
  double fastest = 0;
  for (const Slot a : first)
    for (const Slot b : second) fastest = std::max(fastest, (velocity(a) - velocity(b)).squaredNorm());
  return settings_.step * std::sqrt(fastest);
}

// The same of a solid and a face's nodes, each in the frame in which it is least (narrowphase.hpp).
double SurfaceCollider::travel(const Proxy& solid, const SurfaceFace& face) const {
  double fastest = 0;
  for (const Slot s : face.nodes) {
    double speed = (solid.velocity - velocity(s)).norm();
    if (!solid.turn.isZero(0)) {
      const Vec3 carried = solid.velocity + solid.turn.cross(place(s) - solid.centre());
      speed = std::min(speed, (velocity(s) - carried).norm());
    }
    fastest = std::max(fastest, speed);
  }
  return settings_.step * fastest;
}

// Whether this face makes the contact, if that is at an edge. Both faces of the edge find the same contact; the one whose third
// node has the lower id makes it.
bool SurfaceCollider::owns(const SurfaceFace& face, const Vec3& weights) const {
  const int edge = edge_of(weights);
  if (edge < 0) return true;
  const Slot across = face.across[static_cast<std::size_t>(edge)], own = face.nodes[static_cast<std::size_t>(edge + 2) % 3];
  return across < 0 || world_.id[static_cast<std::size_t>(own)] < world_.id[static_cast<std::size_t>(across)];
}

// Whether no neighbour of the feature comes closer to a point in this direction from it.
bool SurfaceCollider::is_nearest(const SurfaceFace& face, const Vec3& weights, const Vec3& direction, double lean) const {
  if (const int edge = edge_of(weights); edge >= 0) {
    const auto i = static_cast<std::size_t>(edge);
    const Slot across = face.across[i];
    const Vec3 from = place(face.nodes[i]), to = place(face.nodes[(i + 1) % 3]);
    return across < 0 || rise(place(across) - from, to - from, direction) <= lean;
  }
  for (std::size_t i = 0; i < 3 && is_one_node(weights); ++i) {
    if (weights[static_cast<Eigen::Index>(i)] == 0) continue;
    const Vec3 node = place(face.nodes[i]);
    for (const Slot next : surfaces_.ring(face.nodes[i]))
      if (rise(place(next) - node, Vec3::Zero(), direction) > lean) return false;
  }
  return true;
}

// Whether an edge stands out in this direction against all of its faces.
bool SurfaceCollider::is_ridge(const SurfaceEdge& edge, const Vec3& direction) const {
  const Vec3 from = place(edge.nodes[0]), to = place(edge.nodes[1]);
  return std::all_of(edge.wings.begin(), edge.wings.end(),
                     [&](Slot wing) { return wing < 0 || rise(place(wing) - from, to - from, direction) <= 0; });
}

// Whether a direction from a face of a closed surface, or from an edge of it, leads into the solid.
bool SurfaceCollider::is_inwards(const SurfaceFace& face, const Vec3& weights, const Vec3& direction) const {
  const auto [a, b, c] = places(face, time_);
  Vec3 outwards = (b - a).cross(c - a).normalized();
  if (const int edge = edge_of(weights); edge >= 0) {
    const auto i = static_cast<std::size_t>(edge);
    const Vec3 from = place(face.nodes[i]), to = place(face.nodes[(i + 1) % 3]);
    if (face.across[i] >= 0) outwards += (from - to).cross(place(face.across[i]) - to).normalized();
  }
  return outwards.dot(direction) < 0;
}

// The way from the second side's point to the first's (m), at a share of the step.
Vec3 SurfaceCollider::apart(const Pair& pair, double time) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    if (pair.weights[k] != 0) sum += pair.weights[k] * place(pair.slots[k], time);
  return sum;
}

Vec3 SurfaceCollider::parting(const Pair& pair) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    if (pair.weights[k] != 0) sum += pair.weights[k] * velocity(pair.slots[k]);
  return sum;
}

// The margin rule of bodies (narrowphase.hpp), of the two points.
double SurfaceCollider::margin(const Pair& pair, const Vec3& normal) const {
  double first = 0, second = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (pair.weights[k] != 0)
      (pair.weights[k] > 0 ? first : second) += std::abs(pair.weights[k]) * normal.dot(velocity(pair.slots[k]));
  const double fastest = pair.watched ? 0 : std::max({std::abs(first), std::abs(second), std::abs(first - second)});
  const double fall = std::abs(normal.dot(settings_.gravity)) * settings_.step * settings_.step;
  return settings_.margin + settings_.step * fastest + pair.spin + fall;
}

void SurfaceCollider::add(const Pair& pair, const Vec3& arm, const Vec3& normal, double gap, std::uint32_t feature,
                          double beyond) {
  SurfaceContact c{{-1, -1, -1, -1}, feature, {-1, -1, -1, -1}, {}, arm, normal, gap, 0, beyond};
  bool home = false;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Slot s = pair.slots[k];
    const bool twin = k == 3 && s == pair.slots[2];
    if (s < 0 || twin || (pair.weights[k] == 0 && !pair.meets)) continue;
    c.slots[count] = s, c.ids[count] = world_.id[static_cast<std::size_t>(s)], c.weights[count] = pair.weights[k];
    home |= world_.is_home(s), ++count;
  }
  if (!home) return;
  const auto material = [&](Slot s) { return static_cast<std::size_t>(world_.properties[static_cast<std::size_t>(s)].material); };
  c.friction = settings_.friction[material(c.slots[0]) * settings_.material_count + material(c.slots[count - 1])];
  out_.push_back(c);
}

// Whether the two points, now apart by `between`, have passed each other in the last step. What was in one place has no side to
// have come from: what rounding leaves of its distance says none.
bool SurfaceCollider::has_passed(const Pair& pair, const Vec3& between) const {
  if (!pair.within || !settings_.has_past || !(between.norm() < 4 * pair.radii)) return false;
  const Vec3 before = apart(pair, -1);
  return before.norm() > one_place * pair.radii && before.dot(between) < 0;
}

// The normal of two points in one place, as all are in a cloth laid on another just like it: the face's normal parts them, all
// the same way, the lower id downwards. Its sign is that of the sum of its entries, as the two may lie either way round.
Vec3 SurfaceCollider::normal_in_one_place(const Pair& pair, const SurfaceFace& face) const {
  const auto [a, b, c] = places(face, 0);
  Vec3 normal = (b - a).cross(c - a);
  const double size = normal.norm();
  normal = size > 0 ? Vec3(normal / size) : Vec3::UnitZ();
  if (normal.sum() < 0) normal = -normal;
  const auto id = [&](std::size_t k) { return world_.id[static_cast<std::size_t>(pair.slots[k])]; };
  return id(0) < id(1) ? Vec3(-normal) : normal;
}

// A pair as it is at the time that is looked at; its gap opened by what it closes until then.
bool SurfaceCollider::add_standing(const Pair& pair, const SurfaceFace* face) {
  const Vec3 between = apart(pair, time_);
  const double distance = between.norm();
  const bool one = !(distance > one_place * pair.radii);
  if (one && !face) return false;  // edges: nodes on faces say it
  Vec3 normal = one ? normal_in_one_place(pair, *face) : Vec3(between / distance);
  double gap = distance - pair.radii, beyond = 0;
  if (pair.inside)
    normal = -normal, gap = -distance - pair.radii;
  else if (time_ == 0 && has_passed(pair, between))
    normal = -normal, gap = -distance - pair.radii, beyond = distance + 0.1 * pair.radii;
  const bool is_near = (time_ > 0 && !pair.watched) || gap <= margin(pair, normal);
  if (time_ > 0) gap += std::max(0.0, -time_ * settings_.step * normal.dot(parting(pair)));
  if (is_near)
    add(pair, pair.turns ? Vec3(-apart(pair, 0)) : Vec3(Vec3::Zero()), normal, gap, pair.edges ? edges_feature : 0, beyond);
  return is_near || time_ > 0;
}

// A pair as it will first touch, at a share of the step; its gap opened by what it closes until then. Each face speaks for
// itself.
void SurfaceCollider::add_meeting(Pair pair, double time) {
  pair.meets = true;
  const Vec3 between = apart(pair, time);
  const double distance = between.norm();
  if (!(distance > 1e-100)) return;
  const Vec3 normal = between / distance;
  const double closed = std::max(0.0, -time * settings_.step * normal.dot(parting(pair)));
  add(pair, pair.turns ? Vec3(-between) : Vec3(Vec3::Zero()), normal, distance - pair.radii + closed,
      pair.edges ? edges_feature : 0);
}

// A solid's own nodes are all inside of its faces on the other side.
bool SurfaceCollider::is_own(Slot point, const SurfaceFace& face) const {
  return surfaces_.is_node(point) && surfaces_.surface_of(point) == face.surface;
}

// A point with a radius, end 0 of the pair, on a face. `fast`: travel (m) from which on it is followed along the step.
void SurfaceCollider::point_face(Pair pair, const SurfaceFace& face, double fast) {
  std::copy(face.nodes.begin(), face.nodes.end(), pair.slots.begin() + 1);
  const auto set_weights = [&](const Vec3& w) { pair.weights = {1, -w[0], -w[1], -w[2]}; };
  const bool closed = surfaces_.is_closed(face.surface) && !is_own(pair.slots[0], face);
  if (travel(std::span(pair.slots).first(1), face.nodes) > fast) {
    const ContinuousHit hit = point_meets_triangle(path(pair.slots[0]), path(face.nodes[0]), path(face.nodes[1]),
                                                   path(face.nodes[2]), continuous(pair.radii));
    pair.watched = !hit.hit;
    if (hit.hit && hit.time > 0) {
      const Vec3 weights = without_twin(face, {hit.weights[1], hit.weights[2], hit.weights[3]});
      set_weights(weights);
      const bool leaves = closed && is_inwards(face, weights, apart(pair, 0));
      if (!leaves) return add_meeting(pair, hit.time);
    }
  }
  const TrianglePoint near = nearest_on(face, pair.slots[0], 0);
  time_ = passes_face(pair, face, near);
  const bool says = time_ > 0 && stand_on_face(pair, face, nearest_on(face, pair.slots[0], time_));
  time_ = 0;
  if (!says) stand_on_face(pair, face, near);
}

TrianglePoint SurfaceCollider::nearest_on(const SurfaceFace& face, Slot point, double time) const {
  const auto [a, b, c] = places(face, time);
  return closest_on_triangle(place(point, time), a, b, c);
}

double SurfaceCollider::passes_face(Pair pair, const SurfaceFace& face, const TrianglePoint& near) const {
  const Slot point = pair.slots[0];
  const auto separation_of = [&](const TrianglePoint& nearest, double time) {
    const Vec3 towards = place(point, time) - nearest.point, parting = velocity(point) - velocity_on(face, nearest.weights);
    return Separation{nearest.distance - pair.radii, -towards.dot(parting) / nearest.distance};
  };
  if (!(near.distance > pair.radii)) return 0;
  const Separation now = separation_of(near, 0);
  if (!(now.gap < settings_.step * now.closing)) return 0;
  if (!(travel(std::span(pair.slots).first(1), face.nodes) > least_approach * pair.radii)) return 0;
  const Vec3 between = place(point, 0) - near.point;
  pair.weights = {1, -near.weights[0], -near.weights[1], -near.weights[2]}, pair.within = true;
  const bool closed = surfaces_.is_closed(face.surface) && !is_own(point, face);
  if (has_passed(pair, between) || (closed && is_inwards(face, near.weights, between))) return 0;
  const auto separation_at = [&](double seconds, Separation& separation) {
    const double time = seconds / settings_.step;
    const TrianglePoint nearest = nearest_on(face, point, time);
    separation = separation_of(nearest, time);
    return nearest.distance > 0;
  };
  const Encounter encounter = encounter_of(settings_.step, 1e-6 * pair.radii, separation_at);
  return encounter.passes() ? encounter.time / settings_.step : 0;
}

bool SurfaceCollider::stand_on_face(Pair pair, const SurfaceFace& face, const TrianglePoint& near) {
  const auto set_weights = [&](const Vec3& w) { pair.weights = {1, -w[0], -w[1], -w[2]}; };
  const bool closed = surfaces_.is_closed(face.surface) && !is_own(pair.slots[0], face);
  const Vec3 weights = without_twin(face, near.weights);
  const bool at_node = is_one_node(weights);
  const bool speaks = !(at_node && !surfaces_.is_node(pair.slots[0]));  // nodes touch bodies as the particles that they are
  if (!speaks && time_ == 0) return false;
  set_weights(weights);
  const int edge = edge_of(weights);  // one of two faces: on it there are sides as well; around a boundary one may go
  pair.within = !at_node && (edge < 0 || face.across[static_cast<std::size_t>(edge)] >= 0 || face.is_segment());
  const Vec3 between = apart(pair, time_);
  const double distance = between.norm();
  if (pair.within && closed) {
    pair.within = false;
    const double deepest = (pair.turns ? 1 : 4) * pair.radii;  // beyond it another face may be the way out
    pair.inside = is_inwards(face, weights, between);
    if (pair.inside && distance > deepest) return false;
  }
  const bool one = !(distance > one_place * pair.radii);
  if (time_ == 0 && !owns(face, weights)) return false;
  if (!one && !is_nearest(face, weights, between / distance, lean_of_points)) return false;
  if (!speaks || !owns(face, weights)) return true;
  if (at_node) {  // two nodes: the lower id first, so that all who find them agree
    for (std::size_t k = 1; k < 4; ++k)
      if (pair.weights[k] != 0) pair.slots[1] = pair.slots[k];
    if (world_.id[static_cast<std::size_t>(pair.slots[1])] < world_.id[static_cast<std::size_t>(pair.slots[0])])
      std::swap(pair.slots[0], pair.slots[1]);
    pair.weights = {1, -1, 0, 0};
  }
  return add_standing(pair, &face);
}

void SurfaceCollider::node_face(Slot node, std::int32_t number) {
  const SurfaceFace& face = surfaces_.faces[static_cast<std::size_t>(number)];
  if (std::find(face.nodes.begin(), face.nodes.end(), node) != face.nodes.end()) return;
  Pair pair;
  pair.slots[0] = node;
  pair.radii = radius(node) + radius(face.nodes[0]);
  point_face(pair, face, pair.radii);
}

void SurfaceCollider::body_face(const Proxy& body, std::int32_t number) {
  const SurfaceFace& face = surfaces_.faces[static_cast<std::size_t>(number)];
  if (body.kind == ShapeKind::mesh) return mesh_face(body, face);
  if (body.kind == ShapeKind::compound) {
    std::uint32_t parts = 0;
    return for_each_part(body, [&](const Proxy& part) { convex_face(part, face, convex_feature + (parts++ << 18)); });
  }
  if (body.kind == ShapeKind::box) return box_face(body, face);
  if (!is_round(body.shape())) return convex_face(body, face, convex_feature);
  Pair pair;
  pair.slots[0] = body.slot;
  pair.radii = body.half.x() + radius(face.nodes[0]);
  pair.turns = body.kind != ShapeKind::particle;
  point_face(pair, face, body.half_size);
}

void SurfaceCollider::finish() {
  // nodes in one place have as many normals as faces: the least speaks
  std::sort(out_.begin(), out_.end(), [](const SurfaceContact& a, const SurfaceContact& b) {
    const auto least = [](const Vec3& n) { return std::tuple(n.x(), n.y(), n.z()); };
    return a.before(b) || (!b.before(a) && least(a.normal) < least(b.normal));
  });
  const auto same = [](const SurfaceContact& a, const SurfaceContact& b) { return !a.before(b) && !b.before(a); };
  out_.erase(std::unique(out_.begin(), out_.end(), same), out_.end());
}

}  // namespace unibody
