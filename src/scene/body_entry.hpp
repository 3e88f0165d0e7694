// One entry of `bodies`: what its bodies are made of (the template) and where they stand.
#pragma once

#include <memory>
#include <optional>

#include "scene/scene.hpp"
#include "scene/shape_entry.hpp"

namespace unibody {

// What all bodies of an entry share. Its keys stand beside the generator's key.
struct BodyTemplate {
  BodyProperties properties;  // mass and inertia are set by make_body
  std::optional<double> mass, density;
  std::optional<Vec3> inertia;
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  std::shared_ptr<const LoadInTime> load;  // null: force and torque are constant
  std::shared_ptr<const SurfaceMotionInTime> surface_motion;
  std::optional<AnisotropicFriction> friction;
  std::shared_ptr<const MotionInTime> motion;  // null: these velocities are constant, or of bodies that are not kinematic
};

// The template's body with this shape at this place. Checked at reading, so that it can't fail later.
Body make_body(const BodyTemplate& body, const Shape& shape, const Vec3& position, const Quat& orientation = Quat::Identity());

// Half space below the plane through `position` with this unit normal.
Body make_plane(const BodyTemplate& body, const Vec3& position, const Vec3& normal);

// The turn that takes z to the unit vector n; about y where n lies in the x-z plane.
Quat turn_to(const Vec3& n);

// A quaternion [w, x, y, z] or a map with axis and angle (degrees).
Quat read_orientation(const Value& value, const Scene& scene);
Key orientation_key(const char* about);

// A vector of a body; planar scenes have no component along y (or, for `rotation`, along y only).
Vec3 read_vector(const Value& value, const Scene& scene, const std::string& unit, bool rotation = false);
// The same of a key that must be there, in the unit that its table says.
Vec3 read_vector(const KeyedMap& map, std::string_view name, const Scene& scene, bool rotation = false);

// Fails on `value` where the scene has no room for `count` bodies more.
void check_room(const Value& value, const Scene& scene, Id count, bool is_static = false);

// All keys that an entry may have, of whatever kind it is.
const Keys& body_keys();

// Keys that entries of bodies, cloths, threads and solids have.
Key name_key();
Key material_key();

// Reads the list `bodies` into scene.groups. Sections that it leans on (materials, planar) are read before.
void read_bodies(const Value& list, Scene& scene);

}  // namespace unibody
