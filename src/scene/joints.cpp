#include "scene/joints.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.hpp"
#include "scene/body_name.hpp"
#include "scene/flexible.hpp"
#include "scene/in_time.hpp"

namespace unibody {

namespace {

constexpr double degree = M_PI / 180;
const std::vector<std::string> kinds{joint_names.begin(), joint_names.end()};

bool needs_axis(const Joint& joint) {
  return joint.has_coordinate() || joint.kind == JointKind::universal || joint.has_cone() || joint.is_limited();
}
bool takes_axis(JointKind kind) {
  return kind == JointKind::hinge || kind == JointKind::slider || kind == JointKind::universal || kind == JointKind::ball;
}

void read_limits(const Value& value, Joint& joint) {
  const bool angle = turns_about_axis(joint.kind);
  const std::string unit = angle ? "degrees" : "m";
  const auto pair = value.numbers(2, angle ? Range{-180, 180} : any_number, unit + ", lower and upper");
  if (!(pair[0] <= pair[1])) value.fail_expected("the lower limit before the upper (" + unit + ")");
  joint.lower = angle ? degree * pair[0] : pair[0], joint.upper = angle ? degree * pair[1] : pair[1];
}

void read_motor(const Value& value, Joint& joint) {
  const bool angle = turns_about_axis(joint.kind);
  const char *place_key = angle ? "angle" : "offset", *strength_key = angle ? "max_torque" : "max_force";
  value.map({"speed", place_key, strength_key});
  const Value *speed = value.find("speed"), *place = value.find(place_key);
  if (speed && place)
    place->fail(place->found() + " beside speed " + speed->found(), std::string("only one of speed and ") + place_key);
  if (!speed && !place)
    value.fail_missing("speed", std::string("a speed (") + (angle ? "rad/s" : "m/s") + ") or " + place_key + ": (" +
                                    (angle ? "degrees)" : "m)"));
  joint.motor = speed ? Motor::speed : Motor::position;
  if (speed)
    joint.target = read_in_time(*speed, any_number, angle ? "rad/s" : "m/s");
  else
    joint.target = angle ? read_in_time(*place, {-180, 180}, "degrees", degree) : read_in_time(*place, any_number, "m");
  joint.strength =
      value.need(strength_key, angle ? "a number > 0 (N m)" : "a number > 0 (N)").number(positive, angle ? "N m" : "N");
}

// A body as the entry of a joint names it.
struct Named {
  std::optional<Body> body;  // none: the world
};

constexpr const char* named = "the name of a body, as door or pile[3], its entry's place in the list, or world";

Named read_named(const Value& value, const Scene& scene) {
  if (value.text == "world") return {};
  return {read_body_name(value, scene, named)};
}

// Where a body is at the start and the axes in which the scene gives its shape: not the principal ones of a hull or a compound,
// that nobody knows before a run. Of the world its own.
struct Place {
  Vec3 position = Vec3::Zero();
  Quat axes = Quat::Identity(), to_body = Quat::Identity();  // -> the world's; -> the body's

  explicit Place(const std::optional<Body>& body) {
    if (!body) return;
    position = body->state.position, to_body = frame_of(body->properties.shape).conjugate();
    axes = body->state.orientation * to_body;
  }
  Vec3 world(const Vec3& point) const { return position + axes * point; }
};

std::array<Vec3, 2> read_pair(const Value& value, const Scene& scene, const std::string& what) {
  if (value.kind != Value::Kind::list || value.entries.size() != 2) value.fail_expected("a list of 2 " + what);
  return {read_vector(value.entries[0], scene, "m"), read_vector(value.entries[1], scene, "m")};
}

// Where the anchors are: one world point for both, a world point of each, or a point of each in its shape's axes.
void read_anchors(const Value& entry, const Scene& scene, const std::array<Place, 2>& at, Joint& joint) {
  const Value *anchor = entry.find("anchor"), *points = entry.find("points"), *anchors = entry.find("anchors");
  const Value* given = anchor ? anchor : points ? points : anchors;
  for (const Value* other : {points, anchors})
    if (other && other != given)
      other->fail(other->found() + " beside another key for the anchors", "only one of anchor, points and anchors");
  if (!given) {
    if (joint.kind == JointKind::rope)
      entry.fail_missing("points", "a list of 2 points (m), or anchors: of 2 points in the bodies' axes");
    entry.fail_missing("anchor", "a point (m, world axes), or anchors: a list of 2 points in the bodies' axes");
  }
  if (anchors) {
    const auto points_of = read_pair(*anchors, scene, "points in the bodies' axes (m)");
    for (std::size_t e = 0; e < 2; ++e) joint.anchor[e] = at[e].to_body * points_of[e];
    return;
  }
  std::array<Vec3, 2> place;
  if (anchor)
    place.fill(read_vector(*anchor, scene, "m"));
  else
    place = read_pair(*points, scene, "points (m, world axes)");
  for (std::size_t e = 0; e < 2; ++e) joint.anchor[e] = at[e].to_body * (at[e].axes.conjugate() * (place[e] - at[e].position));
}

void read_axes(const Value& entry, const Scene& scene, const std::array<Place, 2>& at, Joint& joint) {
  const Value *axis = entry.find("axis"), *axes = entry.find("axes"), *second = entry.find("second_axis");
  std::array<Vec3, 2> z{Vec3::UnitZ(), Vec3::UnitZ()};
  if (axis && axes) axes->fail(axes->found() + " beside axis " + axis->found(), "only one of axis and axes");
  if (axes) {
    if (axes->kind != Value::Kind::list || axes->entries.size() != 2) axes->fail_expected("a list of 2 vectors of length 1");
    for (std::size_t e = 0; e < 2; ++e) z[e] = at[e].axes * axes->entries[e].unit_vector();
  } else if (axis) {
    z.fill(axis->unit_vector());
  } else if (needs_axis(joint)) {
    entry.fail_missing("axis", "a vector of length 1 (world axes), or axes: a list of 2 in the bodies' axes");
  }
  const Value* given = axes ? axes : axis;
  if (given && scene.planar && joint.kind == JointKind::hinge && (std::abs(z[0].y()) < 1 - 1e-9 || std::abs(z[1].y()) < 1 - 1e-9))
    given->fail_expected("an axis along y (planar scene)");
  if (given && scene.planar && joint.kind == JointKind::slider && (std::abs(z[0].y()) > 1e-9 || std::abs(z[1].y()) > 1e-9))
    given->fail_expected("an axis without y component (planar scene)");
  Vec3 x = Vec3::Zero();
  if (second) {
    x = second->unit_vector();
    if (!(std::abs(x.dot(z[1])) < 1e-3)) second->fail_expected("a vector of length 1, square to the axis");
  }
  const Quat of_second = joint_axes(z[1], x);
  const Quat of_first = axes ? joint_axes(z[0], of_second * Vec3::UnitX()) : of_second;
  const auto in_body = [&](std::size_t e, const Quat& of_world) { return at[e].to_body * (at[e].axes.conjugate() * of_world); };
  joint.frame = {in_body(0, of_first), in_body(1, of_second)};
}

void set_lever(const Body& a, const Body* b, Joint& joint) {
  joint.lever = 0;
  for (const Body* body : {&a, b})
    if (body && !body->properties.is_static()) joint.lever = std::max(joint.lever, bounding_radius(body->properties.shape));
}

JointKind read_kind(const Value& entry, const std::vector<std::string>& names) {
  return static_cast<JointKind>(entry.need("type", one_of(names)).choice(names));
}

Joint read_joint(const Value& entry, const Scene& scene) {
  if (entry.kind != Value::Kind::map) entry.fail_expected("a map with type and bodies");
  Joint joint;
  joint.kind = read_kind(entry, kinds);
  const bool rope = joint.kind == JointKind::rope;
  entry.map(joint_entry_keys(joint.kind));
  const Value& bodies = entry.need("bodies", "a list of 2 bodies, the second of which may be world");
  if (bodies.kind != Value::Kind::list || bodies.entries.size() != 2)
    bodies.fail_expected("a list of 2 bodies, the second of which may be world");
  const Named a = read_named(bodies.entries[0], scene), b = read_named(bodies.entries[1], scene);
  if (!a.body) bodies.entries[0].fail("world", "a body; the second may be world");
  if (b.body && a.body->id == b.body->id) bodies.fail("the same body twice", "two bodies");
  for (std::size_t e = 0; e < 2; ++e)
    if (const auto& body = (e == 0 ? a : b).body) check_turns(bodies.entries[e], joint.kind, body->properties.shape);
  if (a.body->properties.is_static() && !(b.body && !b.body->properties.is_static()))
    bodies.fail("no body that moves freely", "at least one dynamic body");
  joint.ids = {a.body->id, b.body ? b.body->id : -1};
  const std::array<Place, 2> at{Place(a.body), Place(b.body)};
  read_joint_behaviour(entry, joint);
  read_anchors(entry, scene, at, joint);
  read_axes(entry, scene, at, joint);
  set_lever(*a.body, b.body ? &*b.body : nullptr, joint);
  if (rope) {
    const auto place = [&](std::size_t e) { return at[e].world(at[e].to_body.conjugate() * joint.anchor[e]); };
    const Value* length = entry.find("length");
    joint.length = length ? length->number(positive, "m") : (place(0) - place(1)).norm();
  }
  return joint;
}

}  // namespace

void check_turns(const Value& value, JointKind kind, const Shape& shape) {
  if (kind == JointKind::ball || kind == JointKind::rope || shape.kind != ShapeKind::particle) return;
  value.fail(std::string(joint_names[static_cast<std::size_t>(kind)]) + " at a particle, which does not turn",
             "a body that turns; ball and rope also hold particles");
}

Quat joint_axes(const Vec3& axis, const Vec3& second) {
  Vec3 x = second - second.dot(axis) * axis;
  if (x.squaredNorm() < 1e-12) {
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(axis[k]) < std::abs(axis[least])) least = k;
    x = Vec3::Unit(least) - axis[least] * axis;
  }
  x.normalize();
  Mat3 axes;
  axes << x, axis.cross(x), axis;
  return Quat(axes).normalized();
}

Joint joint_between(JointKind kind, const Body& a, const Body* b, const Vec3& point, const Quat& axes) {
  Joint joint;
  joint.kind = kind, joint.ids = {a.id, b ? b->id : -1};
  const std::array<BodyState, 2> at{a.state, b ? b->state : BodyState{}};
  for (std::size_t e = 0; e < 2; ++e) {
    const Quat back = at[e].orientation.conjugate();
    joint.anchor[e] = back * (point - at[e].position), joint.frame[e] = back * axes;
  }
  set_lever(a, b, joint);
  return joint;
}

std::vector<std::string> joint_keys(JointKind kind) {
  std::vector<std::string> keys{"collide", "compliance", "damping"};
  if (kind != JointKind::rope && kind != JointKind::ball) keys.emplace_back("turning_compliance");
  if (kind == JointKind::hinge || kind == JointKind::slider) keys.insert(keys.end(), {"limits", "motor", "friction"});
  if (kind == JointKind::ball) keys.insert(keys.end(), {"swing_limit", "twist_limits"});
  return keys;
}

std::vector<std::string> joint_entry_keys(JointKind kind) {
  const bool rope = kind == JointKind::rope;
  std::vector<std::string> keys = joint_keys(kind);
  keys.insert(keys.end(), {"name", "type", "bodies", "anchors", rope ? "points" : "anchor"});
  if (rope) keys.emplace_back("length");
  if (takes_axis(kind)) keys.insert(keys.end(), {"axis", "axes"});
  if (kind == JointKind::universal) keys.emplace_back("second_axis");
  return keys;
}

void read_joint_behaviour(const Value& map, Joint& joint) {
  if (const Value* v = map.find("collide")) joint.collide = v->boolean();
  if (const Value* v = map.find("compliance")) joint.compliance = v->number(not_negative, "m/N");
  if (const Value* v = map.find("turning_compliance")) joint.turning = v->number(not_negative, "rad/(N m)");
  if (const Value* v = map.find("damping")) joint.damping = v->number(not_negative, "s");
  if (const Value* v = map.find("limits")) read_limits(*v, joint);
  if (const Value* v = map.find("twist_limits")) read_limits(*v, joint);
  if (const Value* v = map.find("swing_limit")) joint.swing = degree * v->number({0, 180, true}, "degrees");
  if (const Value* v = map.find("motor")) read_motor(*v, joint);
  if (const Value* v = map.find("friction")) joint.friction = v->number(not_negative, turns_about_axis(joint.kind) ? "N m" : "N");
}

Joint JointTemplate::between(const Body& a, const Body* b, const Vec3& point) const {
  Joint result = joint;
  const Joint placed = joint_between(joint.kind, a, b, point, joint_axes(axis, second));
  result.ids = placed.ids, result.anchor = placed.anchor, result.frame = placed.frame, result.lever = placed.lever;
  return result;
}

JointTemplate read_joint_template(const Value& value, const Scene& scene, const std::vector<JointKind>& allowed) {
  std::vector<std::string> names;
  for (const JointKind kind : allowed) names.emplace_back(joint_names[static_cast<std::size_t>(kind)]);
  if (value.kind != Value::Kind::map) value.fail_expected("a map with type: " + one_of(names));
  const Value& type = value.need("type", one_of(names));
  JointTemplate result;
  result.joint.kind = allowed[type.choice(names)];
  const JointKind kind = result.joint.kind;
  std::vector<std::string> keys = joint_keys(kind);
  keys.emplace_back("type");
  if (takes_axis(kind)) keys.emplace_back("axis");
  if (kind == JointKind::universal) keys.emplace_back("second_axis");
  value.map(keys);
  if (const Value* axis = value.find("axis")) {
    result.axis = axis->unit_vector();
    if (scene.planar && kind == JointKind::hinge && std::abs(result.axis.y()) < 1 - 1e-9)
      axis->fail_expected("an axis along y (planar scene)");
  }
  if (const Value* second = value.find("second_axis")) result.second = second->unit_vector();
  if (kind == JointKind::universal && !(std::abs(result.second.dot(result.axis)) < 1e-3))
    value.fail("axes that are not square to each other", "second_axis square to axis");
  read_joint_behaviour(value, result.joint);
  return result;
}

void read_joints(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("joints")) {
    scene.joints.push_back(read_joint(entry, scene));
    if (const Value* name = entry.find("name"))  // several may have the same
      scene.joints_named[name->string("a name")].push_back(scene.joints.size() - 1);
  }
}

}  // namespace unibody
