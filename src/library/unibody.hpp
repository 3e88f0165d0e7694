// Unibody as a library: scenes, and simulations of them that a program steps through by itself.
//
//   #include <unibody/unibody.hpp>
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

  const std::string& title() const;
  std::int64_t body_count() const;
  std::int64_t frames() const;  // time.frames
  int substeps() const;         // steps a frame
  // The ids of all entries of bodies, cloths, threads and solids of that name. Throws InputError where there is none.
  std::vector<std::int64_t> ids(const std::string& name) const;
  std::string body_name(std::int64_t id) const;

  struct Data;

 private:
  friend class Simulation;
  std::shared_ptr<Data> data_;
};

// One row a step.
struct StepReport {
  std::int64_t step, iterations, sliding_contacts, impacts;
  double time;              // s, at the step's end
  double natural_residual;  // m
  bool converged;
};

// A point of contact between two bodies, where they are at a step's start.
struct Contact {
  std::int64_t body_a, body_b;  // body_a < body_b
  double point[3];              // m
  double normal[3];             // unit, from body_b towards body_a
  double gap;                   // m; negative where the bodies penetrate
  double friction;              // Coulomb's mu
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

struct JointForce {
  double coordinate;              // rad or m: a hinge's angle, a slider's offset
  double drift, turn;             // m, rad: how far it is open and turned apart
  double force[3], torque[3];     // N, N m, on its first body
  double limit, motor, friction;  // N m or N, along the coordinate
};

struct Energies {
  double kinetic, potential;                                // J
  std::array<double, 3> linear_momentum, angular_momentum;  // kg m/s; kg m^2/s, about the origin
  double penetration_max, penetration_rms;                  // m
  std::int64_t contact_pairs, contacts;
};

enum class Field { position, orientation, velocity, angular_velocity };  // m; w, x, y, z; m/s; rad/s

// A scene in motion. Members are collective, with the same arguments on every process, but where they say otherwise. They throw
// InputError where an argument is wrong.
class UNIBODY_API Simulation {
 public:
  // checkpoint: the file to go on from, of this library, the program or the Python module; empty: from the scene's start.
  Simulation(MPI_Comm comm, const Scene& scene, const std::string& checkpoint = "");
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  void step(int count = 1);    // throws RunError
  double time() const;         // s. Not collective, as the next three
  double step_length() const;  // s
  std::int64_t steps_done() const;
  const std::vector<StepReport>& report() const;

  // The field of all bodies, on every process, in the order of the bodies' ids: three numbers a body, of orientations four.
  std::vector<double> all(Field field) const;
  // The ids of the bodies that this process moves, ascending, and the field in that order. Not collective.
  std::vector<std::int64_t> home_ids() const;
  std::vector<double> home(Field field) const;

  // The contacts between bodies at the present state, of the pairs of this process.
  std::vector<Contact> contacts();
  // What contacts of bodies, cloths, threads and solids did in the last step, of the pairs of this process. Not collective.
  std::vector<ContactForce> contact_forces() const;
  std::vector<JointForce> joints() const;  // of each joint, in the scene's order, after a step
  Energies energies();
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
  void restore(const std::string& checkpoint);
  std::string state_hash() const;  // 16 hex digits, as the program's last line has them

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

UNIBODY_API std::string version();  // of this library, its compiler and the libraries beneath it, a line each

}  // namespace unibody::api
