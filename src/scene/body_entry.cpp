#include "scene/body_entry.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/text.hpp"
#include "scene/generators.hpp"
#include "scene/in_time.hpp"
#include "scene/presence.hpp"
#include "scene/shape_files.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr double degree = M_PI / 180;

const std::vector<std::string> motions{"dynamic", "fixed", "kinematic"};

Vec3 read_plane_normal(const Value& plane, const Scene& scene) {
  plane.map({"normal"});
  const Value* normal = plane.find("normal");
  if (!normal) plane.fail_missing("normal", "a vector of length 1");
  const Vec3 n = normal->unit_vector();
  if (scene.planar && n.y() != 0) normal->fail_expected("a vector without y component (planar scene)");
  return n;
}

Vec3 read_inertia(const Value& value) {
  const Vec3 moments = value.vector(positive, "kg m^2");
  if (!(2 * moments.maxCoeff() <= moments.sum() * (1 + 1e-12)))
    value.fail_expected("three principal moments (kg m^2), none larger than the sum of the other two");
  return moments;
}

void read_amount(const Value& entry, BodyTemplate& body) {
  const Value *mass = entry.find("mass"), *density = entry.find("density"), *moments = entry.find("inertia");
  if (!body.properties.is_dynamic()) {
    for (const char* key : {"mass", "density", "inertia", "force", "torque"})
      if (const Value* value = entry.find(key)) value->fail_expected("no such key for a fixed or kinematic body");
    return;
  }
  if (mass && density) density->fail(density->found() + " beside mass " + mass->found(), "only one of mass and density");
  if (!mass && !density) entry.fail_missing("mass", "a mass (kg) or a density (kg/m^3)");
  if (mass) body.mass = mass->number(positive, "kg");
  if (density) body.density = density->number(positive, "kg/m^3");
  if (moments) body.inertia = read_inertia(*moments);
}

int read_material(const Value& value, const Scene& scene) { return static_cast<int>(value.choice(scene.materials)); }

void read_motion_in_time(const Value& entry, BodyTemplate& body, const Scene& scene) {
  const Value *velocity = entry.find("velocity"), *spin = entry.find("angular_velocity"), *path = entry.find("path");
  MotionInTime motion;
  if (path) {
    if (velocity) path->fail("a path beside a velocity", "only one of them");
    motion.path = read_planar_in_time(*path, scene, "m", false);
    if (motion.path->at(0) != Vec3::Zero()) path->fail_expected("a path that is 0 at time 0: it starts where the body does");
  }
  if (velocity) motion.velocity = read_planar_in_time(*velocity, scene, "m/s", false);
  if (spin) motion.angular_velocity = read_planar_in_time(*spin, scene, "rad/s", true);
  body.velocity = motion.velocity.at(0), body.angular_velocity = motion.angular_velocity.at(0);
  if (path || motion.velocity.changes() || motion.angular_velocity.changes())
    body.motion = std::make_shared<MotionInTime>(std::move(motion));
}

void read_motion(const Value& entry, BodyTemplate& body, const Scene& scene) {
  BodyProperties& properties = body.properties;
  const Value *motion = entry.find("motion"), *velocity = entry.find("velocity"), *spin = entry.find("angular_velocity");
  const ShapeKind kind = properties.shape.kind;
  const bool is_still = kind == ShapeKind::plane || kind == ShapeKind::mesh;
  if (is_still) properties.motion = Motion::fixed;
  if (motion) properties.motion = static_cast<Motion>(motion->choice(motions));
  if (properties.is_dynamic() && is_still)
    motion->fail_expected("fixed or kinematic for a " + std::string(shape_names[static_cast<std::size_t>(kind)]));
  if (properties.motion == Motion::fixed) {
    for (const Value* value : {velocity, spin})
      if (value) value->fail_expected("no such key for a fixed body");
  }
  if (const Value* path = entry.find("path"); path && properties.motion != Motion::kinematic)
    path->fail_expected("motion: kinematic beside a path");
  if (properties.motion == Motion::kinematic) {
    read_motion_in_time(entry, body, scene);
    return;
  }
  if (velocity) body.velocity = read_vector(*velocity, scene, "m/s");
  if (spin) body.angular_velocity = read_vector(*spin, scene, "rad/s", true);
}

void read_load(const Value& entry, BodyTemplate& body, const Scene& scene) {
  LoadInTime load;
  const auto read = [&](const char* key, const char* unit, bool rotation, TimeVector& in_time, Vec3& constant) {
    const Value* value = entry.find(key);
    if (!value) return;
    if (is_vector_in_time(*value)) {
      in_time = read_planar_in_time(*value, scene, unit, rotation);
      constant = in_time.at(0);
    } else {
      constant = read_vector(*value, scene, unit, rotation);
      for (std::size_t k = 0; k < 3; ++k) in_time[k] = constant[static_cast<Eigen::Index>(k)];
    }
  };
  read("force", "N", false, load.force, body.properties.force);
  read("torque", "N m", true, load.torque, body.properties.torque);
  if (load.force.changes() || load.torque.changes()) body.load = std::make_shared<LoadInTime>(std::move(load));
}

// The template's keys, all but the shape, which is in place already.
BodyTemplate read_template(const Value& entry, const Shape& shape, const Scene& scene) {
  BodyTemplate body;
  body.properties.shape = shape;
  if (shape.kind == ShapeKind::particle)
    for (const char* key : {"inertia", "angular_velocity", "torque"})
      if (const Value* value = entry.find(key)) value->fail_expected("no such key for a particle: it does not turn");
  read_motion(entry, body, scene);
  read_amount(entry, body);
  read_load(entry, body, scene);
  if (const Value* material = entry.find("material")) body.properties.material = read_material(*material, scene);
  return body;
}

const GeneratorType* find_generator(const Value& entry) {
  const GeneratorType* result = nullptr;
  for (const GeneratorType& type : generator_types()) {
    const Value* value = entry.find(type.key);
    if (value && result) value->fail("a second generator beside " + std::string(result->key), "one generator an entry");
    if (value) result = &type;
  }
  return result;
}

std::vector<std::string> keys_with(const GeneratorType* type) {
  std::vector<std::string> keys{"name", "material", "position", "orientation", "start"};
  const Takes takes = type ? type->takes : Takes::shape;
  if (takes != Takes::nothing)
    for (const char* key : {"mass", "density", "motion", "velocity", "angular_velocity", "path", "force", "torque"})
      keys.emplace_back(key);
  if (takes == Takes::shape) {
    keys.emplace_back("shape");
    keys.emplace_back("inertia");
  }
  if (type) keys.emplace_back(type->key);
  if (!type)
    for (const GeneratorType& other : generator_types()) keys.emplace_back(other.key);
  return keys;
}

Generated read_single(const Value& entry, const BodyTemplate& body, const Scene& scene) {
  if (body.properties.shape.kind != ShapeKind::plane)
    return {1, [body](Id) { return make_body(body, body.properties.shape, Vec3::Zero()); }};
  if (const Value* turn = entry.find("orientation")) turn->fail_expected("no orientation: a plane is turned by its normal");
  const Vec3 normal = read_plane_normal(*entry.find("shape")->find("plane"), scene);
  return {1, [body, normal](Id) { return make_plane(body, Vec3::Zero(), normal); }};
}

Generated read_generated(const Value& entry, BodyTemplate& body, const GeneratorType* type, const Scene& scene) {
  const Takes takes = type ? type->takes : Takes::shape;
  const Value* shape = entry.find("shape");
  if (takes == Takes::shape) {
    if (!shape) entry.fail_missing("shape", "a map with the key " + one_of({shape_names.begin(), shape_names.end()}));
    const Shape solid = read_shape(*shape, scene);
    if (type && (solid.kind == ShapeKind::plane || solid.kind == ShapeKind::mesh))
      shape->fail("a " + shape->children[0].first + " in a " + std::string(type->key), "a shape that can move");
    body = read_template(entry, solid, scene);
    check_mass(entry, body, solid);
  } else if (takes == Takes::no_shape) {
    body = read_template(entry, Shape{}, scene);
  } else {
    body.properties.motion = Motion::fixed;
    if (const Value* material = entry.find("material")) body.properties.material = read_material(*material, scene);
  }
  return type ? type->read(*entry.find(type->key), body, scene) : read_single(entry, body, scene);
}

// Numbers that are finite each may give places that are not: looked for at both ends of an entry.
void check_places(const Value& entry, const BodyGroup& group) {
  const auto check = [&](Id k) {
    const BodyState state = group.make(k).state;
    if (!state.position.allFinite() || !state.orientation.coeffs().allFinite())
      entry.fail("a place of body " + std::to_string(k) + " that is not finite", "smaller numbers");
  };
  for (Id k = 0; k < std::min<Id>(group.count, 8); ++k) check(k);
  check(group.count - 1);
}

// The value that says how many bodies an entry has.
const Value& count_of(const Value& entry, const GeneratorType* type) {
  const Value* generator = type ? entry.find(type->key) : nullptr;
  for (const char* key : {"count", "courses", "levels"})
    if (const Value* count = generator ? generator->find(key) : nullptr) return *count;
  return generator ? *generator : entry;
}

void read_entry(const Value& entry, Scene& scene) {
  if (entry.kind != Value::Kind::map) entry.fail_expected("a map with a shape or a generator");
  const GeneratorType* type = find_generator(entry);
  entry.map(keys_with(type));
  BodyTemplate body;
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();
  if (const Value* value = entry.find("position")) position = read_vector(*value, scene, "m");
  if (const Value* value = entry.find("orientation")) orientation = read_orientation(*value, scene);

  BodyGroup group;
  group.line = entry.line;
  if (const Value* name = entry.find("name")) group.name = name->string("a name");
  if (const Value* inlet = entry.find("inlet")) check_inlet_name(entry, *inlet, scene);
  const Generated generated = read_generated(entry, body, type, scene);
  group.first = scene.body_count();
  group.count = generated.count;
  group.is_static = !body.properties.is_dynamic();
  group.generated = type != nullptr;
  group.motion = body.motion, group.load = body.load;
  read_start(entry, body, generated, group);
  check_room(count_of(entry, type), scene, group.count, group.is_static);
  const auto put = [first = group.first, held = group.start == Start::held, position, orientation](Id k, Body body_in_frame) {
    body_in_frame.id = first + k;
    BodyState& state = body_in_frame.state;
    state.position = position + orientation * state.position;
    if (body_in_frame.properties.shape.kind != ShapeKind::particle) state.orientation = orientation * state.orientation;
    if (held) body_in_frame.properties.motion = Motion::pinned;
    return body_in_frame;
  };
  group.make = [make = generated.make, put](Id k) { return put(k, make(k)); };
  if (group.inlet) put_inlet(position, orientation, put, group);
  check_places(entry, group);
  // An entry has bodies of one kind, or boxes, or a chain's ball at the end.
  group.rotates = group.make(0).properties.shape.kind != ShapeKind::particle ||
                  group.make(group.count - 1).properties.shape.kind != ShapeKind::particle;
  for (Joint joint : generated.joints) {
    if (joint.ids[1] < 0)
      joint.anchor[1] = position + orientation * joint.anchor[1], joint.frame[1] = orientation * joint.frame[1];
    for (Id& id : joint.ids)
      if (id >= 0) id += group.first;
    scene.joints.push_back(joint);
  }
  if (const std::string note = note_of(body.properties.shape); !note.empty()) scene.notes.push_back(note);
  scene.groups.push_back(std::move(group));
}

}  // namespace

Quat turn_to(const Vec3& n) {
  if (n.x() == 0 && n.y() == 0 && n.z() < 0) return Quat(0, 0, 1, 0);
  const double sideways = n.x() * n.x() + n.y() * n.y();
  return Quat(n.z() >= 0 ? 1 + n.z() : sideways / (1 - n.z()), -n.y(), n.x(), 0).normalized();
}

Body make_body(const BodyTemplate& body, const Shape& shape, const Vec3& position, const Quat& orientation) {
  Body result;
  result.properties = body.properties;
  result.properties.shape = shape;
  if (body.properties.is_dynamic()) {
    result.properties.mass = body.mass ? *body.mass : *body.density * volume(shape);
    result.properties.inertia = body.inertia ? *body.inertia : inertia(shape, result.properties.mass);
  }
  const bool given = shape.kind != ShapeKind::hull && shape.kind != ShapeKind::compound;  // in its principal axes
  result.state = {position, given ? orientation : orientation * frame_of(shape), body.velocity, body.angular_velocity};
  return result;
}

Body make_plane(const BodyTemplate& body, const Vec3& position, const Vec3& normal) {
  return make_body(body, {ShapeKind::plane, Vec3::Zero()}, position, turn_to(normal));
}

Quat read_orientation(const Value& value, const Scene& scene) {
  Quat q;
  if (value.kind == Value::Kind::map) {
    value.map({"axis", "angle"});
    const Value *axis = value.find("axis"), *angle = value.find("angle");
    if (!axis) value.fail_missing("axis", "a vector of length 1");
    if (!angle) value.fail_missing("angle", "a number (degrees)");
    q = Eigen::AngleAxisd(angle->number(any_number, "degrees") * degree, axis->unit_vector());
  } else {
    if (value.kind != Value::Kind::list) value.fail_expected("a quaternion [w, x, y, z] or a map with axis and angle (degrees)");
    const auto c = value.numbers(4, any_number, "quaternion w, x, y, z");
    q = Quat(c[0], c[1], c[2], c[3]);
    if (!(std::abs(q.norm() - 1) <= 1e-3)) value.fail_expected("a quaternion of length 1");
    if (q.norm() != 1) q.normalize();
  }
  if (scene.planar && (q.x() != 0 || q.z() != 0)) value.fail_expected("a turn about y (planar scene)");
  return q;
}

Vec3 read_vector(const Value& value, const Scene& scene, const std::string& unit, bool rotation) {
  const Vec3 v = value.vector(any_number, unit);
  if (scene.planar && !rotation && v.y() != 0)
    value.fail_expected("0 as the second of three numbers (" + unit + "; planar scene)");
  if (scene.planar && rotation && (v.x() != 0 || v.z() != 0))
    value.fail_expected("0 as the first and third of three numbers (" + unit + "; planar scene)");
  return v;
}

namespace {

// Shapes given by lengths alone, as their types say (world/shape_type.hpp).
Shape read_lengths(const Value& solid, const ShapeType& type) {
  solid.map({type.lengths.begin(), type.lengths.end()});
  std::vector<double> lengths;
  for (const std::string_view key : type.lengths) {
    const Value* length = solid.find(key);
    if (!length) solid.fail_missing(std::string(key), "a number > 0 (m)");
    lengths.push_back(length->number(positive, "m"));
  }
  return type.make(lengths);
}

Shape read_box(const Value& solid) {
  solid.map({"size"});
  const Value* size = solid.find("size");
  if (!size) solid.fail_missing("size", "a list of 3 numbers > 0 (m)");
  return {ShapeKind::box, 0.5 * size->vector(positive, "m, edge lengths")};
}

}  // namespace

Shape read_shape(const Value& value, const Scene& scene) {
  const std::vector<std::string> names{shape_names.begin(), shape_names.end()};
  value.map(names);
  if (value.children.size() != 1)
    value.fail("a map of " + std::to_string(value.children.size()) + " shapes", "one of " + one_of(names));
  const auto& [name, solid] = value.children[0];
  const auto kind = static_cast<ShapeKind>(std::find(names.begin(), names.end(), name) - names.begin());
  if (kind == ShapeKind::disc && !scene.planar) solid.fail("a disc", "sphere, box or plane in a scene that is not planar");
  if (kind > ShapeKind::particle && scene.planar) solid.fail("a " + name, "sphere, box, plane or disc in a planar scene");
  if (kind == ShapeKind::plane) {
    read_plane_normal(solid, scene);
    return {ShapeKind::plane, Vec3::Zero()};
  }
  if (kind == ShapeKind::box) return read_box(solid);
  if (kind == ShapeKind::hull) return read_hull(solid, scene);
  if (kind == ShapeKind::compound) return read_compound(solid, scene);
  if (kind == ShapeKind::mesh) return read_mesh_shape(solid, scene);
  return read_lengths(solid, type_of(kind));
}

void check_mass(const Value& entry, const BodyTemplate& body, const Shape& shape) {
  if (!body.properties.is_dynamic()) return;
  const BodyProperties p = make_body(body, shape, Vec3::Zero()).properties;
  const double moment = shape.kind == ShapeKind::particle ? p.mass : p.inertia.minCoeff();
  if (std::min(p.mass, moment) > 0 && std::isfinite(p.mass) && p.inertia.allFinite()) return;
  const Value* amount = entry.find(body.mass ? "mass" : "density");
  (amount ? *amount : entry).fail_expected("a mass and an inertia > 0 and finite for a body of this size");
}

void check_room(const Value& value, const Scene& scene, Id count, bool is_static) {
  if (count == 1) return;  // what a file lists one by one fits; and thousands of entries need no sums
  const Id capacity = scene.room.bodies_of_rank(), ranks = scene.room.ranks;
  Id statics = 0, dynamic = 0;  // before these
  for (const BodyGroup& group : scene.groups) (group.is_static ? statics : dynamic) += group.count;
  const Id most =
      std::max<Id>(0, is_static ? capacity - statics - (dynamic + ranks - 1) / ranks : (capacity - statics) * ranks - dynamic);
  if (count <= most) return;
  const std::string bodies = std::to_string(count), own = value.found();
  std::ostringstream expected;
  expected << "at most " << most << " bodies: the memory of " << ranks << (ranks == 1 ? " rank" : " ranks")
           << " has room for no more";
  value.fail(own == bodies ? own : own + ", " + bodies + " bodies", expected.str());
}

std::vector<std::string> body_keys() { return keys_with(nullptr); }

void read_bodies(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("bodies and generators")) read_entry(entry, scene);
}

}  // namespace unibody
