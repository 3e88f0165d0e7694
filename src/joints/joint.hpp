// A joint as the scene defines it: which points and axes of two bodies belong together, and what drives and bounds their motion.
//
// Each body carries a copy of the joint's axes, and its anchor; at the start of a scene the two copies coincide as a rule. Its
// angle, twist or offset is that of the first body against the second, about or along the axis z of the copies.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "core/time_value.hpp"
#include "core/types.hpp"
#include "joints/strength.hpp"

namespace unibody {

enum class JointKind : std::uint8_t { ball, hinge, slider, fixed, universal, rope, spring };
inline constexpr std::array<std::string_view, 7> joint_names{"ball", "hinge", "slider", "fixed", "universal", "rope", "spring"};

// Whether it is about the distance of two points.
constexpr bool ties_points(JointKind kind) { return kind == JointKind::rope || kind == JointKind::spring; }

enum class Motor : std::uint8_t { none, speed, position };

// The area on which the motor of a slider presses: the product of two lengths, each of which may grow by the offset of a slider.
struct PressedArea {
  struct Length {
    double at_start = 1;       // m
    std::int64_t slider = -1;  // the joint's number; -1: the length stays
  };
  std::array<Length, 2> lengths;
};

struct Joint {
  JointKind kind = JointKind::ball;
  bool collide = false;        // its bodies may touch each other
  std::int32_t tree = -1;      // its own rows are solved with those of that tree (JointSolve::direct); -1: by themselves
  std::int32_t colour = 0;     // two joints of a colour share no moving body
  std::array<Id, 2> ids{};     // the second -1: the world
  std::array<Vec3, 2> anchor;  // m, from each body's centre, in its axes; of the world a point
  std::array<Quat, 2> frame;   // the joint's axes, in each body's; of the world's
  double compliance = 0;       // m/N, of the rows that measure a length
  double turning = 0;          // rad/(N m), compliance of the rows that measure an angle
  double damping = 0;          // s, rho: its rows see c + rho dc/dt
  double lever = 1;            // m, what one radian counts as where errors are compared with lengths
  double length = 0;           // m, of a rope or spring
  double lower = -std::numeric_limits<double>::infinity(), upper = -lower;  // rad or m, of the angle, twist or offset
  double swing = upper;  // rad, of a ball: the most that the second body's axis z and the first's may part
  Motor motor = Motor::none;
  TimeValue target;                         // rad/s, m/s, rad or m
  TimeValue strength;                       // N m or N, the most that the motor gives; with an area Pa
  std::shared_ptr<const PressedArea> area;  // null: the strength is not a pressure
  double friction = 0;                      // N m or N, the most that dry friction gives
  // Of a spring and a damper about a hinge's angle or along a slider's offset.
  double stiffness = 0, viscosity = 0;  // N m/rad and N m s/rad, or N/m and N s/m
  double rest = 0;                      // rad or m, where the spring is at rest
  Strength bears;                       // what it bears before it breaks

  bool is_limited() const { return lower > -infinity || upper < infinity; }
  bool is_sprung() const { return stiffness > 0 || viscosity > 0; }
  bool has_cone() const { return swing < infinity; }
  bool has_span() const { return ties_points(kind); }
  bool has_coordinate() const { return kind == JointKind::hinge || kind == JointKind::slider; }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
};

// Whether its angle or its twist is what limits and a motor are about, rather than an offset.
inline bool turns_about_axis(JointKind kind) { return kind == JointKind::hinge || kind == JointKind::ball; }

// Impulses (N s or N m s) of a joint in the last step: of its own rows, six at most, of limits, motor and friction; of a ball's
// cone behind its three rows, and of the spring of a hinge or slider behind its five. And what it has borne of late.
struct JointImpulses {
  static constexpr std::size_t cone = 3, spring = 5, limits = 6, motor = 7, friction = 8;
  std::array<double, 9> value{};
  std::array<double, 6> load{};  // N, N m: mean force and torque on the first body, in its copy of the axes (Strength::duration)
};

// The joints that touch some bodies, by their numbers in Scene::joints, ascending.
using JointList = std::vector<std::int64_t>;

}  // namespace unibody
