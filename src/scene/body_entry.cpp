#include "scene/body_entry.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "scene/anisotropic_friction.hpp"
#include "scene/body_mass.hpp"
#include "scene/generators.hpp"
#include "scene/in_time.hpp"
#include "scene/presence.hpp"
#include "scene/shape_files.hpp"
#include "scene/touching.hpp"
#include "world/compound.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

// The keys of what moves, which every body has but the parts of a container or a hopper.
const Keys& moving_keys() {
  static const Keys table{
      "moving bodies",
      "",
      {keys::number("mass", "kg", positive, "a density", "mass of each body; of dynamic bodies alone"),
       keys::number("density", "kg/m^3", positive, "a mass",
                    "density of each body, of a disc per area (kg/m^2); of dynamic bodies alone"),
       keys::choice("motion", {"dynamic", "fixed", "kinematic"}, "dynamic; fixed of a plane or mesh",
                    "what moves the bodies: forces; nothing; their velocities or their path, whatever they meet"),
       keys::vector_in_time("velocity", "m/s", "[0, 0, 0]", "velocity at the start; of kinematic bodies it may change in time"),
       keys::vector_in_time("angular_velocity", "rad/s", "[0, 0, 0]",
                            "angular velocity at the start, world axes; of kinematic bodies it may change in time"),
       keys::vector_in_time("path", "m", "none",
                            "of kinematic bodies, in place of velocity: how far they are from where they start"),
       keys::vector_in_time("surface_velocity", "m/s", "[0, 0, 0]",
                            "how the surface moves along itself while the body does not, as a belt's; body axes"),
       keys::vector_in_time("surface_angular_velocity", "rad/s", "[0, 0, 0]",
                            "the same, turning about the body's centre; body axes"),
       anisotropic_friction_key(), keys::vector_in_time("force", "N", "[0, 0, 0]", "force at the centre of each dynamic body"),
       keys::vector_in_time("torque", "N m", "[0, 0, 0]", "torque on each dynamic body, world axes")}};
  return table;
}

int read_material(const Value& value, const Scene& scene) { return static_cast<int>(value.choice(scene.materials)); }

void read_motion_in_time(const KeyedMap& entry, BodyTemplate& body, const Scene& scene) {
  const Value *velocity = entry.find("velocity"), *spin = entry.find("angular_velocity"), *path = entry.find("path");
  MotionInTime motion;
  entry.only_one_of({"velocity", "path"});
  if (path) {
    motion.path = read_planar_in_time(entry, "path", scene, false);
    if (motion.path->at(0) != Vec3::Zero()) path->fail_expected("a path that is 0 at time 0: it starts where the body does");
  }
  if (velocity) motion.velocity = read_planar_in_time(entry, "velocity", scene, false);
  if (spin) motion.angular_velocity = read_planar_in_time(entry, "angular_velocity", scene, true);
  body.velocity = motion.velocity.at(0), body.angular_velocity = motion.angular_velocity.at(0);
  if (path || motion.velocity.changes() || motion.angular_velocity.changes())
    body.motion = std::make_shared<MotionInTime>(std::move(motion));
}

void read_motion(const KeyedMap& entry, BodyTemplate& body, const Scene& scene) {
  BodyProperties& properties = body.properties;
  const Value *motion = entry.find("motion"), *velocity = entry.find("velocity"), *spin = entry.find("angular_velocity");
  const ShapeKind kind = properties.shape.kind;
  const bool is_still = kind == ShapeKind::plane || kind == ShapeKind::mesh;
  if (is_still) properties.motion = Motion::fixed;
  if (motion) properties.motion = static_cast<Motion>(entry.choice("motion"));
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
  if (velocity) body.velocity = read_vector(entry, "velocity", scene);
  if (spin) body.angular_velocity = read_vector(entry, "angular_velocity", scene, true);
}

void read_load(const KeyedMap& entry, BodyTemplate& body, const Scene& scene) {
  LoadInTime load;
  const auto read = [&](const char* key, bool rotation, TimeVector& in_time, Vec3& constant) {
    const Value* value = entry.find(key);
    if (!value) return;
    if (is_vector_in_time(*value)) {
      in_time = read_planar_in_time(entry, key, scene, rotation);
      constant = in_time.at(0);
    } else {
      constant = read_vector(entry, key, scene, rotation);
      for (std::size_t k = 0; k < 3; ++k) in_time[k] = constant[static_cast<Eigen::Index>(k)];
    }
  };
  read("force", false, load.force, body.properties.force);
  read("torque", true, load.torque, body.properties.torque);
  if (load.force.changes() || load.torque.changes()) body.load = std::make_shared<LoadInTime>(std::move(load));
}

void read_surface_motion(const KeyedMap& entry, BodyTemplate& body, const Scene& scene) {
  const bool moves = entry.has("surface_velocity"), turns = entry.has("surface_angular_velocity");
  if (!moves && !turns) return;
  SurfaceMotionInTime motion;
  if (moves) motion.velocity = read_planar_in_time(entry, "surface_velocity", scene, false);
  if (turns) motion.angular_velocity = read_planar_in_time(entry, "surface_angular_velocity", scene, true);
  body.surface_motion = std::make_shared<SurfaceMotionInTime>(std::move(motion));
}

// The template's keys, all but the shape, which is in place already.
BodyTemplate read_template(const KeyedMap& entry, const Shape& shape, const Scene& scene) {
  BodyTemplate body;
  body.properties.shape = shape;
  if (shape.kind == ShapeKind::particle)
    entry.none_of({"inertia", "angular_velocity", "torque"}, "for a particle: it does not turn");
  if (shape.kind == ShapeKind::particle)
    entry.none_of({"surface_velocity", "surface_angular_velocity", "anisotropic_friction"},
                  "for a particle: a point has no surface");
  read_motion(entry, body, scene);
  read_surface_motion(entry, body, scene);
  body.friction = read_anisotropic_friction(entry, scene);
  read_amount(entry, body, scene);
  read_load(entry, body, scene);
  if (const Value* material = entry.find("material")) body.properties.material = read_material(*material, scene);
  return body;
}

const GeneratorType* find_generator(const Value& entry) {
  const GeneratorType* result = nullptr;
  for (const GeneratorType& type : generator_types()) {
    const Value* value = entry.find(type.key.name);
    if (value && result) value->fail("a second generator beside " + result->key.name, "one generator an entry");
    if (value) result = &type;
  }
  return result;
}

// The keys that an entry may have beside a generator's key, or without one.
Keys make_keys(const GeneratorType* type) {
  Keys table{
      "body",
      "A body, or with the key of a generator many.",
      {name_key(), material_key(),
       keys::vector("position", "m", "[0, 0, 0]",
                    "where the centre of mass is, a point of a plane, or the origin of a mesh or generator"),
       orientation_key("how the body, or all that is generated, is turned; not of a plane"), collide_key(),
       keys::choice("start", {start_names.begin(), start_names.end()}, "present",
                    "what the bodies are until an event changes it: absent ones are not in the scene, held ones stay where "
                    "they are")}};
  const Takes takes = type ? type->takes : Takes::shape;
  if (takes == Takes::shape || takes == Takes::no_shape) table = table.with(moving_keys());
  if (takes == Takes::shape) table = table.with({"", "", {shape_key(needed)}}).with(inertia_keys());
  if (type) return table.with({"", "", {type->key}});
  for (const GeneratorType& other : generator_types()) table.keys.push_back(other.key);
  return table;
}

const Keys& keys_with(const GeneratorType* type) {
  static const Keys without = make_keys(nullptr);
  static const std::vector<Keys> with = [] {
    std::vector<Keys> tables;
    for (const GeneratorType& of : generator_types()) tables.push_back(make_keys(&of));
    return tables;
  }();
  return type ? with[static_cast<std::size_t>(type - generator_types().data())] : without;
}

// Says in the schema which keys there may be beside the one of each generator.
void restrict_by_generator(Json& schema) {
  Json rules = Json::array();
  Json any = Json::array();
  for (const GeneratorType& type : generator_types()) {
    const Json has = Json::object().set("required", keys::texts({type.key.name}));
    any.push(has);
    Json then = Json::object().set("propertyNames", Json::object().set("enum", keys::texts(keys_with(&type).names())));
    if (type.takes == Takes::shape) then.set("required", keys::texts({"shape"}));
    rules.push(Json::object().set("if", has).set("then", then));
  }
  rules.push(Json::object()
                 .set("if", Json::object().set("not", Json::object().set("anyOf", any)))
                 .set("then", Json::object().set("required", keys::texts({"shape"}))));
  schema.set("allOf", rules);
}

Generated read_single(const Value& entry, const BodyTemplate& body, const Scene& scene) {
  if (body.properties.shape.kind != ShapeKind::plane)
    return {1, [body](Id) { return make_body(body, body.properties.shape, Vec3::Zero()); }};
  if (const Value* turn = entry.find("orientation")) turn->fail_expected("no orientation: a plane is turned by its normal");
  const Vec3 normal = read_plane_normal(*entry.find("shape")->find("plane"), scene);
  return {1, [body, normal](Id) { return make_plane(body, Vec3::Zero(), normal); }};
}

Generated read_generated(const KeyedMap& entry, BodyTemplate& body, const GeneratorType* type, const Scene& scene) {
  const Takes takes = type ? type->takes : Takes::shape;
  if (takes == Takes::shape) {
    const Value& shape = entry.need("shape");
    const Shape solid = read_shape(shape, scene);
    if (type && (solid.kind == ShapeKind::plane || solid.kind == ShapeKind::mesh))
      shape.fail("a " + shape.children[0].first + " in a " + type->key.name, "a shape that can move");
    body = read_template(entry, solid, scene);
    check_mass(entry.value(), body, body.properties.shape);
  } else if (takes == Takes::no_shape) {
    body = read_template(entry, Shape{}, scene);
  } else {
    if (takes == Takes::nothing) body.properties.motion = Motion::fixed;
    if (const Value* material = entry.find("material")) body.properties.material = read_material(*material, scene);
  }
  return type ? type->read(entry.need(type->key.name), body, scene) : read_single(entry.value(), body, scene);
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
  const Value* generator = type ? entry.find(type->key.name) : nullptr;
  for (const char* key : {"count", "courses", "levels"})
    if (const Value* count = generator ? generator->find(key) : nullptr) return *count;
  return generator ? *generator : entry;
}

// The joints between the bodies of an entry, and between them and the world, and what couples these.
void add_joints(const Generated& generated, const BodyGroup& group, const Vec3& position, const Quat& orientation, Scene& scene) {
  const std::size_t first = scene.joints.size();
  for (Joint joint : generated.joints) {
    if (joint.ids[1] < 0)
      joint.anchor[1] = position + orientation * joint.anchor[1], joint.frame[1] = orientation * joint.frame[1];
    for (Id& id : joint.ids)
      if (id >= 0) id += group.first;
    if (joint.area) {
      PressedArea area = *joint.area;
      for (PressedArea::Length& length : area.lengths)
        if (length.slider >= 0) length.slider += static_cast<std::int64_t>(first);
      joint.area = std::make_shared<PressedArea>(area);
    }
    scene.joints.push_back(joint);
  }
  for (std::size_t j = 0; j < generated.joint_names.size(); ++j)
    scene.joints_named[group.name + "/" + generated.joint_names[j]].push_back(first + j);
  for (Coupling coupling : generated.couplings) {
    for (std::int64_t& joint : coupling.joints) joint += static_cast<std::int64_t>(first);
    scene.couplings.push_back(with_bodies(coupling, scene.joints));
  }
}

void read_entry(const Value& entry, Scene& scene) {
  if (entry.kind != Value::Kind::map) entry.fail_expected("a map with a shape or a generator");
  const GeneratorType* type = find_generator(entry);
  const KeyedMap map(entry, keys_with(type));
  BodyTemplate body;
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();
  if (map.has("position")) position = read_vector(map, "position", scene);
  if (const Value* value = entry.find("orientation")) orientation = read_orientation(*value, scene);

  BodyGroup group;
  group.line = entry.line;
  if (const Value* name = entry.find("name")) group.name = name->string("a name");
  if (const Value* inlet = entry.find("inlet")) check_inlet_name(entry, *inlet, scene);
  const Generated generated = read_generated(map, body, type, scene);
  group.first = scene.body_count();
  group.count = generated.count;
  group.is_static = !body.properties.is_dynamic();
  group.generated = type != nullptr;
  group.motion = body.motion, group.load = body.load, group.surface_motion = body.surface_motion, group.friction = body.friction;
  read_start(map, body, generated, group);
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
  add_joints(generated, group, position, orientation, scene);
  group.names = generated.names, group.other_names = generated.other_names;
  if (generated.cell) {
    TriaxialCell cell = *generated.cell;
    cell.corner = position + orientation * cell.corner, cell.axes = orientation * cell.axes;
    group.cell = std::make_shared<TriaxialCell>(cell);
  }
  for (const Id k : generated.untouched) group.untouched.push_back(group.first + k);
  scene.notes.insert(scene.notes.end(), generated.notes.begin(), generated.notes.end());
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
    result.properties.mass = body.mass ? *body.mass : body.density ? *body.density * volume(shape) : own_mass(shape);
    result.properties.inertia = body.inertia ? *body.inertia : inertia(shape, result.properties.mass);
  }
  const bool given = shape.kind != ShapeKind::hull && shape.kind != ShapeKind::compound;  // in its principal axes
  result.state = {position, given ? orientation : orientation * frame_of(shape), body.velocity, body.angular_velocity};
  return result;
}

Body make_plane(const BodyTemplate& body, const Vec3& position, const Vec3& normal) {
  return make_body(body, {ShapeKind::plane, Vec3::Zero()}, position, turn_to(normal));
}

Vec3 read_vector(const Value& value, const Scene& scene, const std::string& unit, bool rotation) {
  const Vec3 v = value.vector(any_number, unit);
  if (scene.planar && !rotation && v.y() != 0)
    value.fail_expected("0 as the second of three numbers (" + unit + "; planar scene)");
  if (scene.planar && rotation && (v.x() != 0 || v.z() != 0))
    value.fail_expected("0 as the first and third of three numbers (" + unit + "; planar scene)");
  return v;
}

Vec3 read_vector(const KeyedMap& map, std::string_view name, const Scene& scene, bool rotation) {
  return read_vector(map.need(name), scene, map.key(name).unit, rotation);
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

Key name_key() { return keys::text("name", "a name", "none", "by which messages and other entries call it"); }
Key material_key() { return keys::text("material", "a material", "the first material", "what it is made of"); }

const Keys& body_keys() {
  static const Keys table = [] {
    Keys keys = keys_with(nullptr);
    for (Key& key : keys.keys)
      if (key.name == "shape") key.without.is_needed = false;
    keys.restrict_schema = restrict_by_generator;
    return keys;
  }();
  return table;
}

void read_bodies(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("bodies and generators")) read_entry(entry, scene);
}

}  // namespace unibody
