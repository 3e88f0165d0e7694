#include "scene/joints.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.hpp"
#include "scene/body_name.hpp"
#include "scene/flexible.hpp"
#include "scene/in_time.hpp"
#include "scene/joint_keys.hpp"
#include "scene/strength.hpp"

namespace unibody {

namespace {

constexpr double degree = M_PI / 180;

bool needs_axis(const Joint& joint) {
  return joint.has_coordinate() || joint.kind == JointKind::universal || joint.has_cone() || joint.is_limited();
}
void read_limits(const KeyedMap& map, const char* name, Joint& joint) {
  const bool angle = turns_about_axis(joint.kind);
  const Key& key = map.key(name);
  const Value& value = map.need(name);
  const auto pair = value.numbers(2, key.range, key.unit + ", lower and upper");
  if (!(pair[0] <= pair[1])) value.fail_expected("the lower limit before the upper (" + key.unit + ")");
  joint.lower = angle ? degree * pair[0] : pair[0], joint.upper = angle ? degree * pair[1] : pair[1];
}

}  // namespace

void read_motor(const Value& value, const Scene& scene, Joint& joint) {
  const bool angle = turns_about_axis(joint.kind);
  const char *place_key = angle ? "angle" : "offset", *strength_key = angle ? "max_torque" : "max_force";
  const KeyedMap map(value, motor_keys(angle));
  map.only_one_of({"speed", place_key});
  const Value *speed = map.find("speed"), *place = map.find(place_key);
  if (!speed && !place)
    value.fail_missing("speed", std::string("a speed (") + (angle ? "rad/s" : "m/s") + ") or " + place_key + ": (" +
                                    (angle ? "degrees)" : "m)"));
  joint.motor = speed ? Motor::speed : Motor::position;
  joint.target = speed ? read_in_time(map, "speed", scene) : read_in_time(map, place_key, scene, angle ? degree : 1);
  if (!angle) {
    map.only_one_of({"max_force", "max_pressure"});
    if (map.has("max_pressure")) {
      const std::optional<double> area = map.number_if("area");
      if (!area) value.fail_missing("area", "the area (m^2) on which max_pressure acts");
      joint.strength = read_in_time(map, "max_pressure", scene);
      joint.area = std::make_shared<PressedArea>(PressedArea{{PressedArea::Length{*area, -1}, {}}});
      return;
    }
    map.none_of({"area"}, "without max_pressure");
  }
  joint.strength = read_in_time(map, strength_key, scene);
}

namespace {

void read_joint_spring(const Value& value, Joint& joint) {
  const bool angle = turns_about_axis(joint.kind);
  const KeyedMap map(value, joint_spring_keys(angle));
  joint.stiffness = map.number_if("stiffness").value_or(0), joint.viscosity = map.number("damping");
  if (!joint.is_sprung()) value.fail("neither stiffness nor damping", "one of the two > 0");
  if (joint.stiffness == 0) map.none_of({"rest"}, "of a damper alone");
  joint.rest = (angle ? degree : 1) * map.number("rest");
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
void read_anchors(const KeyedMap& entry, const Scene& scene, const std::array<Place, 2>& at, Joint& joint) {
  const char* in_world = joint.has_span() ? "points" : "anchor";
  entry.only_one_of({in_world, "anchors"});
  const Value *given = entry.find(in_world), *anchors = entry.find("anchors");
  if (!given && !anchors) {
    if (joint.has_span())
      entry.value().fail_missing("points", "a list of 2 points (m), or anchors: of 2 points in the bodies' axes");
    entry.value().fail_missing("anchor", "a point (m, world axes), or anchors: a list of 2 points in the bodies' axes");
  }
  if (anchors) {
    const auto points_of = read_pair(*anchors, scene, "points in the bodies' axes (m)");
    for (std::size_t e = 0; e < 2; ++e) joint.anchor[e] = at[e].to_body * points_of[e];
    return;
  }
  std::array<Vec3, 2> place;
  if (joint.has_span())
    place = read_pair(*given, scene, "points (m, world axes)");
  else
    place.fill(read_vector(entry, "anchor", scene));
  for (std::size_t e = 0; e < 2; ++e) joint.anchor[e] = at[e].to_body * (at[e].axes.conjugate() * (place[e] - at[e].position));
}

void read_axes(const KeyedMap& entry, const Scene& scene, const std::array<Place, 2>& at, Joint& joint) {
  const Value *axis = entry.value().find("axis"), *axes = entry.value().find("axes"), *second = entry.value().find("second_axis");
  std::array<Vec3, 2> z{Vec3::UnitZ(), Vec3::UnitZ()};
  if (axis && axes) entry.only_one_of({"axis", "axes"});
  if (axes) {
    if (axes->kind != Value::Kind::list || axes->entries.size() != 2) axes->fail_expected("a list of 2 vectors of length 1");
    for (std::size_t e = 0; e < 2; ++e) z[e] = at[e].axes * axes->entries[e].unit_vector();
  } else if (axis) {
    z.fill(axis->unit_vector());
  } else if (needs_axis(joint)) {
    entry.value().fail_missing("axis", "a vector of length 1 (world axes), or axes: a list of 2 in the bodies' axes");
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

Joint read_joint(const Value& value, const Scene& scene) {
  if (value.kind != Value::Kind::map) value.fail_expected("a map with type and bodies");
  Joint joint;
  const Key& type = joint_keys().at("type");
  joint.kind = static_cast<JointKind>(value.need("type", type.words).choice(type.names));
  const KeyedMap entry(value, joint_keys_of(joint.kind));
  const Value& bodies = entry.need("bodies");
  if (bodies.kind != Value::Kind::list || bodies.entries.size() != 2) bodies.fail_expected(entry.key("bodies").words);
  const Named a = read_named(bodies.entries[0], scene), b = read_named(bodies.entries[1], scene);
  if (!a.body) bodies.entries[0].fail("world", "a body; the second may be world");
  if (b.body && a.body->id == b.body->id) bodies.fail("the same body twice", "two bodies");
  for (std::size_t e = 0; e < 2; ++e)
    if (const auto& body = (e == 0 ? a : b).body) check_turns(bodies.entries[e], joint.kind, body->properties.shape);
  if (a.body->properties.is_static() && !(b.body && !b.body->properties.is_static()))
    bodies.fail("no body that moves freely", "at least one dynamic body");
  joint.ids = {a.body->id, b.body ? b.body->id : -1};
  const std::array<Place, 2> at{Place(a.body), Place(b.body)};
  read_joint_behaviour(entry, scene, joint);
  read_anchors(entry, scene, at, joint);
  read_axes(entry, scene, at, joint);
  set_lever(*a.body, b.body ? &*b.body : nullptr, joint);
  if (joint.has_span()) {
    const auto place = [&](std::size_t e) { return at[e].world(at[e].to_body.conjugate() * joint.anchor[e]); };
    const std::optional<double> length = entry.number_if("length");
    joint.length = length ? *length : (place(0) - place(1)).norm();
  }
  return joint;
}

}  // namespace

void check_turns(const Value& value, JointKind kind, const Shape& shape) {
  if (kind == JointKind::ball || ties_points(kind) || shape.kind != ShapeKind::particle) return;
  value.fail(std::string(joint_names[static_cast<std::size_t>(kind)]) + " at a particle, which does not turn",
             "a body that turns; ball, rope and spring also hold particles");
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

void read_joint_behaviour(const KeyedMap& map, const Scene& scene, Joint& joint) {
  joint.collide = map.flag("collide"), joint.compliance = map.number("compliance"), joint.damping = map.number("damping");
  const auto may_have = [&](const char* name) { return map.value().find(name) != nullptr; };  // the type has it, if it is given
  if (may_have("turning_compliance")) joint.turning = map.number("turning_compliance");
  if (may_have("strength")) joint.bears = read_strength(map.need("strength"), map.key("strength").maps.front()());
  if (may_have("limits")) read_limits(map, "limits", joint);
  if (may_have("twist_limits")) read_limits(map, "twist_limits", joint);
  if (may_have("swing_limit")) joint.swing = degree * map.number("swing_limit");
  if (may_have("motor")) read_motor(map.need("motor"), scene, joint);
  if (may_have("spring")) read_joint_spring(map.need("spring"), joint);
  if (may_have("friction")) joint.friction = map.number("friction");
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
  const KeyedMap map(value, joint_template_keys_of(kind));
  if (const Value* axis = value.find("axis")) {
    result.axis = axis->unit_vector();
    if (scene.planar && kind == JointKind::hinge && std::abs(result.axis.y()) < 1 - 1e-9)
      axis->fail_expected("an axis along y (planar scene)");
  }
  if (const Value* second = value.find("second_axis")) result.second = second->unit_vector();
  if (kind == JointKind::universal && !(std::abs(result.second.dot(result.axis)) < 1e-3))
    value.fail("axes that are not square to each other", "second_axis square to axis");
  read_joint_behaviour(map, scene, result.joint);
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
