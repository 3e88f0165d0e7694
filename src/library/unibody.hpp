// Unibody as a library: scenes, and simulations of them that a program steps through by itself.
//
//   unibody::api::Session session(&argc, &argv);
//   unibody::api::Simulation simulation(MPI_COMM_WORLD, unibody::api::Scene::from_file("scene.yaml"));
//   simulation.step(100);
//
// Units are SI, axes the world's, right-handed, z up; vectors are three numbers, quaternions four, w first. Bodies are named by
// their ids: their order in the scene, from 0, fixed ones and nodes of cloths, threads and solids among them. A program takes the
// steps of the program `unibody`: its states are the same bits, on any number of MPI processes.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#if defined(__GNUC__)
#define UNIBODY_API __attribute__((visibility("default")))
#else
#define UNIBODY_API
#endif

namespace unibody::api {

// A scene, a file or an argument is wrong, and nothing has changed. Of a scene file what() begins with its path and line.
struct UNIBODY_API InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A step led to a state that cannot be, or a disk failed. The simulation cannot go on from there.
struct UNIBODY_API RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// MPI and PETSc of this process. It starts what does not run yet, and ends what it has started. One must live as long as any
// simulation.
class UNIBODY_API Session {
 public:
  // Takes the arguments of main(), in which MPI and PETSc may find options of theirs.
  explicit Session(int* argc = nullptr, char*** argv = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// A scene that has been read. Copies share it.
class UNIBODY_API Scene {
 public:
  // Values that take the place of those in the scene, by their paths: {"time.frames", "20"}, {"bodies[0].mass", "2"}, in YAML.
  using Settings = std::map<std::string, std::string>;

  // Throw InputError.
  static Scene from_file(const std::string& path, const Settings& set = {});
  // A scene in YAML, as a file would hold it. Files that it names are looked for in `folder`.
  static Scene from_text(const std::string& yaml, const std::string& folder = ".", const Settings& set = {});

  const std::string& title() const;  // `title` of the scene, or nothing
  std::int64_t body_count() const;   // with fixed bodies, and nodes of cloths, threads and solids
  std::int64_t frames() const;       // time.frames
  int substeps() const;              // steps a frame
  // The ids of all entries of bodies, cloths, threads and solids of that name. Throws InputError where there is none.
  std::vector<std::int64_t> ids(const std::string& name) const;
  std::string body_name(std::int64_t id) const;  // as messages have it: crate, pile[3], or body 7

  struct Data;

 private:
  friend class Simulation;
  std::shared_ptr<Data> data_;
};

// One row a step.
struct StepReport {
  std::int64_t step;              // steps since time 0, this one included
  std::int64_t iterations;        // of all of its stages
  std::int64_t sliding_contacts;  // points of contact that slide
  std::int64_t impacts;           // that were resolved at their own moments
  double time;                    // s, at the step's end
  double natural_residual;        // m, how far the step is from solved
  bool converged;                 // the residual is within the tolerance
};

// A point of contact between two bodies, where they are at a step's start.
struct Contact {
  std::int64_t body_a;  // the one of lower id
  std::int64_t body_b;  // the other one
  double point[3];      // m
  double normal[3];     // unit, from body_b towards body_a
  double gap;           // m; negative where the bodies penetrate
  double friction;      // Coulomb's mu
};

// What a point of contact did in a step. Two bodies that touch are the first two; a side that is a face, edge or segment of a
// cloth, thread or solid takes the force with its nodes, by their shares.
struct ContactForce {
  std::int64_t bodies[4];  // -1: none
  double shares[4];        // of the force that each takes: of the first side positive, of the second negative
  double point[3];         // m
  double normal[3];        // unit, from the second side to the first
  double force[3];         // N, on the first side, the mean over the step
  double friction;         // Coulomb's mu
};

// Where a joint is, and what it did in a step.
struct JointForce {
  double coordinate;  // rad or m: a hinge's angle, a slider's offset
  double drift;       // m, how far it is open
  double turn;        // rad, how far its bodies are turned apart where it lets them not turn
  double force[3];    // N, on its first body
  double torque[3];   // N m, on its first body
  double limit;       // N m or N, of its limit, along the coordinate
  double motor;       // N m or N, of its motor, along the coordinate
  double friction;    // N m or N, of its friction, along the coordinate
  double spring;      // N m or N, of its spring and damper, along the coordinate
  bool broken;        // it does nothing any more: all else is 0
};

// Energies and momenta of all bodies together, and how deep bodies penetrate each other.
struct Energies {
  double kinetic;                          // J
  double potential;                        // J, in the scene's gravity
  std::array<double, 3> linear_momentum;   // kg m/s
  std::array<double, 3> angular_momentum;  // kg m^2/s, about the origin
  double penetration_max;                  // m
  double penetration_rms;                  // m, the root of the mean square over the points that penetrate
  std::int64_t contact_pairs;              // pairs of bodies that are in contact
  std::int64_t contacts;                   // points of contact
};

// What of a body's state is asked for.
enum class Field {
  position,         // m, of the centre of mass
  orientation,      // w, x, y, z: it turns the body's axes into the world's
  velocity,         // m/s
  angular_velocity  // rad/s, world axes
};

// A scene in motion. Members are collective, with the same arguments on every process, but where they say otherwise. They throw
// InputError where an argument is wrong.
class UNIBODY_API Simulation {
 public:
  // checkpoint: the file to go on from, of this library, the program or the Python module; empty: from the scene's start.
  // continue_from: another scene's checkpoint, whose bodies start as they are there, by name and number, as with the program's
  // option -continue_from.
  Simulation(MPI_Comm comm, const Scene& scene, const std::string& checkpoint = "", const std::string& continue_from = "");
  ~Simulation();
  Simulation(Simulation&&) noexcept;             // leaves an object that can only be destroyed or assigned to
  Simulation& operator=(Simulation&&) noexcept;  // ends the simulation that was here

  void step(int count = 1);                       // throws RunError
  double time() const;                            // s. Not collective, as the next three
  double step_length() const;                     // s
  std::int64_t steps_done() const;                // since time 0
  const std::vector<StepReport>& report() const;  // of the steps since the start or the last restore()

  // The field of all bodies, on every process, in the order of the bodies' ids: three numbers a body, of orientations four.
  std::vector<double> all(Field field) const;
  // The ids of the bodies that this process moves, ascending. Not collective.
  std::vector<std::int64_t> home_ids() const;
  // The field of the bodies that this process moves, in the order of their ids. Not collective.
  std::vector<double> home(Field field) const;

  // The contacts between bodies at the present state, of the pairs of this process.
  std::vector<Contact> contacts();
  // What contacts of bodies, cloths, threads and solids did in the last step, of the pairs of this process. Not collective.
  std::vector<ContactForce> contact_forces() const;
  std::vector<JointForce> joints() const;  // of each joint, in the scene's order, after a step
  Energies energies();                     // of the present state
  // The columns of the scene's probe of this name, each with its name, unit and value. A flow tells what has passed since the
  // start, a box what is in it now, and a force or a stress tells its mean over the last step, which is NaN before the first.
  std::vector<std::pair<std::string, double>> probe(const std::string& name) const;

  // Sets the velocities (m/s, rad/s) of moving or kinematic bodies: three numbers a body. An empty list leaves them as they
  // are.
  void set_velocities(std::span<const std::int64_t> ids, std::span<const double> linear, std::span<const double> angular = {});
  // On dynamic bodies, throughout the next step: three numbers a body, or none. N, N m.
  void apply_forces(std::span<const std::int64_t> ids, std::span<const double> forces, std::span<const double> torques = {});
  // From now on: rad/s, m/s, rad or m, by the joint's motor. `joint`: its place in the scene, from 0.
  void set_motor(std::int64_t joint, double target);

  void write_checkpoint(const std::string& path) const;  // at the end of a frame
  // Goes on from a checkpoint of this scene, of this library, the program or the Python module.
  void restore(const std::string& checkpoint);
  std::string state_hash() const;  // 16 hex digits, as the program's last line has them

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

UNIBODY_API std::string version();  // of this library, its compiler and the libraries beneath it, a line each

}  // namespace unibody::api
