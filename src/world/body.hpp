// One body as the scene defines it: all that its home rank needs to know, before it has a place in the arrays.
#pragma once

#include "world/shapes.hpp"

namespace unibody {

enum class Motion : std::uint8_t {
  dynamic,    // moved by the solver
  fixed,      // never moves; inverse mass 0
  kinematic,  // moves with its prescribed velocity and angular velocity; inverse mass 0
  pinned,     // dynamic, but held for now: inverse mass 0
};

// What a body is and does not change during a run. Trivially copyable: it travels when the body migrates.
struct BodyProperties {
  Shape shape;
  Motion motion = Motion::dynamic;
  std::int32_t material = 0;    // index into Scene::materials
  std::int32_t group = -1;      // bodies of one group >= 0, such as the nodes of a cloth, do not touch each other
  double mass = 1;              // kg; ignored unless dynamic
  Vec3 inertia = Vec3::Ones();  // kg m^2, principal, body frame; ignored unless dynamic
  Vec3 force = Vec3::Zero();    // N, constant, world frame, at the centre
  Vec3 torque = Vec3::Zero();   // N m, constant, world frame

  bool is_dynamic() const { return motion == Motion::dynamic; }
  bool is_static() const { return motion == Motion::fixed || motion == Motion::kinematic; }
};

// The state of a body. 13 doubles.
struct BodyState {
  Vec3 position = Vec3::Zero();          // m, of the centre of mass
  Quat orientation = Quat::Identity();   // body -> world, unit
  Vec3 velocity = Vec3::Zero();          // m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, world frame
};

struct Body {
  Id id = 0;
  BodyProperties properties;
  BodyState state;
};

}  // namespace unibody
