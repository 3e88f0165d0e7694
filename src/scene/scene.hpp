// Scene: what the file says, as plain structs in SI units. read_scene() is the only way in; nothing here knows of MPI.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "constraints/solver_settings.hpp"
#include "core/time_value.hpp"
#include "joints/coupling.hpp"
#include "joints/joint.hpp"
#include "scene/event.hpp"
#include "scene/friction_in_time.hpp"
#include "scene/inlet.hpp"
#include "scene/outlet.hpp"
#include "scene/probe.hpp"
#include "world/body.hpp"
#include "world/material_pairs.hpp"
#include "world/period.hpp"
#include "world/surface.hpp"
#include "world/touch_rules.hpp"

namespace unibody {

struct ConstraintSet;

struct TimeSettings {
  double frame = 0.016;  // s, the length of a frame
  std::int64_t frames = 400;
  int substeps = 1;  // steps of step/substeps a frame
};

struct OutputSettings {
  int every = 1;                  // frames between written frames; 0: none
  int checkpoint_every = 100;     // frames between checkpoints; 0: at the end only; -1: none at all
  double checkpoint_minutes = 0;  // wall time between checkpoints, beside those; 0: no matter
  bool single_precision = false;
  bool joints = false;    // write what each joint does
  int contacts = 0;       // frames between those whose contacts are written; 0: none
  bool crossings = true;  // count, in every frame, the edges that go through faces
};

// The velocities or the path of the kinematic bodies of one entry, where these change in time.
struct MotionInTime {
  TimeVector velocity;             // m/s; unused where there is a path
  std::optional<TimeVector> path;  // m, from where a body starts; 0 at time 0
  TimeVector angular_velocity;     // rad/s

  // Over a step, which then ends where the path or the integral of the velocity says. m/s
  Vec3 mean_velocity(double from, double to) const {
    return path ? Vec3((path->at(to) - path->at(from)) / (to - from)) : velocity.mean(from, to);
  }
};

// How the surfaces of the bodies of one entry move along themselves, in the bodies' axes. An entry whose surfaces do not has
// none.
struct SurfaceMotionInTime {
  TimeVector velocity;          // m/s
  TimeVector angular_velocity;  // rad/s, about the centre
};

// Of the bodies of one entry: the coefficient of friction along an axis of theirs, and across it.
struct AnisotropicFriction {
  Vec3 axis = Vec3::UnitX();  // unit, in the bodies' axes
  double across = 1;          // over that along the axis, which is the materials' own
};

// How the force and the torque on the dynamic bodies of one entry change in time. An entry whose loads are constant has none.
struct LoadInTime {
  TimeVector force;   // N
  TimeVector torque;  // N m, world axes
};

// A force that changes in time, on a part of a solid's surface.
struct PartLoad {
  std::vector<std::pair<Id, double>> shares;  // nodes, ascending, and what part of it each bears
  TimeVector force;                           // N
};

// What the bodies of an entry are when a run starts.
enum class Start : std::uint8_t { present, absent, held };
inline constexpr std::array<std::string_view, 3> start_names{"present", "absent", "held"};

// A run of bodies of consecutive ids made by one entry of `bodies`. `make(k)`, 0 <= k < count, is a pure function of k, so
// that each rank builds only its own share of a large scene. The result's id is first + k.
struct BodyGroup {
  Id first = 0;
  Id count = 0;
  bool is_static = false;  // all fixed or kinematic: replicated on every rank
  bool rotates = true;     // false: particles
  bool generated = false;  // by a generator, even if it is one body
  Start start = Start::present;
  std::string name;                                     // of the entry; may be empty
  std::vector<std::string> names;                       // of its bodies, as the links of a robot; empty: they have numbers alone
  std::vector<std::pair<std::string, Id>> other_names;  // by which its bodies, by their numbers, are found as well
  std::vector<Id> untouched;                            // ids of those that touch nothing, ascending
  int line = 0;                                         // of the entry in the file; 0: it is not from there
  std::function<Body(Id k)> make;
  std::shared_ptr<const MotionInTime> motion;                 // of kinematic bodies; null: their velocities are constant
  std::shared_ptr<const LoadInTime> load;                     // of dynamic bodies; null: it is constant
  std::shared_ptr<const SurfaceMotionInTime> surface_motion;  // null: their surfaces do not move along themselves
  std::optional<AnisotropicFriction> friction;                // none: friction is the same in all directions
  std::shared_ptr<const Inlet> inlet;        // by which they come in; null: they are there, or an event adds them
  std::shared_ptr<const TriaxialCell> cell;  // whose plates they are; null: they are none

  // The number of the body of this name; none where no body has it.
  std::optional<Id> number_of(const std::string& part) const;
};

// The patch of neighbours that a node belongs to, where nothing is known of its neighbours: a run of numbers.
inline Id patch_by_number(Id number) {
  constexpr Id nodes_of_patch = 256;
  return number / nodes_of_patch;
}

// The constraints inside a run of bodies of consecutive ids, such as the nodes of a cloth. `touching(id, out)` adds every one
// that touches body `id`: a pure function, so that each rank makes only those of its own bodies.
struct ConstraintGroup {
  Id first = 0;
  Id count = 0;
  std::function<void(Id id, ConstraintSet& out)> touching;

  // The patch of neighbours that a body belongs to: what a partition moves as one.
  std::function<Id(Id id)> patch_of = patch_by_number;
};

// A node that is held until a time: where it is, or at the point of a fixed or kinematic body at which it is at the start.
struct Pin {
  Id id = 0;
  double release = std::numeric_limits<double>::infinity();  // s
  Id body = -1;                                              // -1: none
  Vec3 place = Vec3::Zero();                                 // m, from that body's centre, in its axes
};

// A node tied until a time to the point of a dynamic body at which it is at the start.
struct Attachment {
  Id node = 0, body = 0;
  Vec3 place = Vec3::Zero();                                 // m, from the body's centre, in its axes
  double release = std::numeric_limits<double>::infinity();  // s
};

// The room that a scene may fill. Every rank makes its share of the dynamic bodies, and all of the static ones.
struct Room {
  double bytes = std::numeric_limits<double>::infinity();  // of memory, for each rank
  int ranks = 1;

  static constexpr double least_bytes_of_body = sizeof(Body) + sizeof(BodyState);  // while the world is made
  // The most bodies that a rank can hold: by its memory, and by how slots are numbered.
  Id bodies_of_rank() const {
    return static_cast<Id>(std::min(bytes / least_bytes_of_body, double{std::numeric_limits<Slot>::max()}));
  }
};

struct Scene {
  std::string path;
  std::string title;
  Room room;
  TimeSettings time;
  Vec3 gravity{0, 0, -9.81};                  // m/s^2, at time 0
  std::optional<TimeVector> gravity_in_time;  // where it changes
  TimeVector wind;                            // m/s
  double air_density = 1.2;                   // kg/m^3
  Period period;                              // directions in which the scene repeats itself
  bool planar = false;                        // motion in x and z and one rotation about y
  SolverSettings solver;
  OutputSettings output;
  std::vector<std::string> materials{"default"};
  std::vector<double> friction{0.5};  // materials x materials, row major, symmetric: Coulomb's mu of each pair, at time 0
  MaterialPairs pairs;                // what else each pair has
  std::optional<FrictionInTime> friction_in_time;  // where some of it changes
  std::vector<BodyGroup> groups;                   // in the order of the file; ids run on from group to group
  TouchRules touch_rules;                          // which of them touch each other

  std::vector<ConstraintGroup> constraint_groups;
  std::vector<Pin> pins;                // ascending ids
  std::vector<Attachment> attachments;  // ascending nodes
  std::vector<Surface> surfaces;
  std::vector<PartLoad> part_loads;  // besides the bodies' own
  std::vector<Joint> joints;
  std::map<std::string, std::vector<std::size_t>> joints_named;  // their places in `joints`, of those that have a name
  std::int32_t joint_colours = 0, joint_trees = 0;
  std::vector<Coupling> couplings;
  std::int32_t coupling_colours = 0;
  std::vector<Probe> probes;
  std::vector<Event> events;
  std::vector<Outlet> outlets;
  bool lacks_bodies = false;       // some are not there, since the checkpoint that the run goes on from lacks them
  std::vector<std::string> notes;  // what a person should know of what was read

  Vec3 gravity_at(double t) const { return gravity_in_time ? gravity_in_time->at(t) : gravity; }
  double largest_gravity() const { return gravity_in_time ? gravity_in_time->largest() : gravity.stableNorm(); }

  Id body_count() const;
  const BodyGroup& group_of(Id id) const;  // id in [0, body_count())
  bool has_rotations() const;              // false: all bodies but fixed ones are particles
  bool bodies_come_and_go() const;         // some are absent at the start, or may be later
  bool joints_break() const;               // some joint does where it bears too much, or is released by an event
  Body body(Id id) const;                  // id in [0, body_count())
  std::string body_name(Id id) const;      // "crate" or "pile[17]"; "body 17" where the entry has no name
  double friction_of(int material_a, int material_b) const {
    return friction[static_cast<std::size_t>(material_a) * materials.size() + static_cast<std::size_t>(material_b)];
  }
};

// A value set from the command line: path.to.key=value, the value in YAML.
struct Override {
  std::string path, value;
};

// Reads and checks a scene file. Throws InputError "file:line: key 'k': found v, expected e" on the first fault; more bodies than
// there is room for are one.
Scene read_scene(const std::string& path, const std::vector<Override>& overrides = {}, const Room& room = {});

// The same of a text that is in no file. `path` names it in errors, without a line; mesh files are looked for beside it.
Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides = {},
                      const Room& room = {});

}  // namespace unibody
