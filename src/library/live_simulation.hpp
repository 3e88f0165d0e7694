// A scene that a program steps through by itself: what the library's Simulation and the Python module's do.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/running_scene.hpp"
#include "library/unibody.hpp"
#include "report/measure.hpp"
#include "report/probes.hpp"

namespace unibody {

using StepRow = api::StepReport;
using ContactRow = api::Contact;
using ForceRow = api::ContactForce;

// The ids of all bodies of the entries of that name. Throws InputError where there is none.
std::vector<Id> ids_named(const Scene& scene, const std::string& name);

// All members but those that only tell something of this rank are collective, with the same arguments on every rank. Bodies
// are named by their ids. Members throw InputError where an argument is wrong, before anything has changed.
class LiveSimulation {
 public:
  // checkpoint: the file to go on from; empty: from the scene's start. continue_from: another scene's checkpoint, whose bodies go
  // on (app/continued.hpp); empty: none. Throws InputError as a run of the program does.
  LiveSimulation(MPI_Comm comm, const Scene& scene, const std::string& checkpoint = "", const std::string& continue_from = "");
  ~LiveSimulation();
  LiveSimulation(const LiveSimulation&) = delete;
  LiveSimulation& operator=(const LiveSimulation&) = delete;

  // Throws RunError where the step leads to a state that cannot be.
  void step();
  // Frees all that it holds of MPI; nothing but close() and the destructor may follow.
  void close();
  bool is_open() const { return running_ != nullptr; }

  const Scene& scene() const { return scene_; }
  MPI_Comm comm() const { return comm_; }
  int rank() const;
  int ranks() const;
  double step_length() const { return scene_.time.frame / scene_.time.substeps; }  // s
  double time() const { return static_cast<double>(steps_done()) * step_length(); }
  std::int64_t steps_done() const;
  const std::vector<StepRow>& report() const { return report_; }

  using Field = api::Field;
  static std::size_t width(Field field) { return field == Field::orientation ? 4 : 3; }
  // The field of all bodies, in the order of their ids, on every rank; NaN of those that are absent. Positions are in m;
  // orientations w, x, y, z of unit quaternions, body to world; velocities in m/s; angular velocities in rad/s, world axes.
  std::vector<double> gathered(Field field) const;
  // The ids of this rank's home bodies, ascending, and the field in that order. Not collective.
  std::vector<Id> home_ids() const;
  std::vector<double> of_homes(Field field) const;

  // The contacts at the present state of this rank's pairs. A pair belongs to the rank whose home its first moving body is.
  std::vector<ContactRow> contacts();
  // The forces of this rank's pairs, where there was one: what contacts of bodies, cloths, threads and solids did in the last
  // step. Not collective.
  std::vector<ForceRow> contact_forces() const;
  Measures measures();
  // The columns of the scene's probe of this name (probes.hpp). A flow tells what has passed since the simulation was made, a box
  // what is in it now, and a force or a stress tells its mean over the last step, which is NaN before the first. Throws
  // InputError where no probe has that name.
  std::vector<std::pair<std::string, double>> probe(const std::string& name) const;
  std::vector<JointState> joint_states();  // of each joint of the scene; forces are those of the last step
  std::uint64_t state_hash() const;        // of the program's last line

  // Sets the velocities (m/s; rad/s, world axes) of moving bodies, and of kinematic ones whose velocity the scene does not give
  // in time: three numbers a body. An empty list leaves them as they are.
  void set_velocities(std::span<const Id> ids, std::span<const double> linear, std::span<const double> angular);
  // Forces (N) and torques (N m, world axes) on dynamic bodies throughout the next step: three numbers a body, or none.
  void apply_forces(std::span<const Id> ids, std::span<const double> forces, std::span<const double> torques);
  // Sets the target of a joint's motor from now on: rad/s, m/s, rad or m, by the motor. `joint`: its place in the scene, from
  // 0. Checkpoints don't hold it.
  void set_motor(std::int64_t joint, double target);

  void write_checkpoint(const std::string& path) const;
  void restore(const std::string& checkpoint);

 private:
  using Totals = std::vector<std::pair<std::string, double>>;

  void start(const std::string& checkpoint);
  void tell_probes(std::span<const ContactImpulse> impulses);
  void check_ids(std::span<const Id> ids, bool dynamic_alone) const;
  // turns: the numbers are about axes of turning.
  void check_numbers(std::span<const Id> ids, std::span<const double> numbers, const char* what, bool turns) const;
  void check_open() const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  Scene scene_;        // as steps see it, with the motors' targets as they were set
  const Scene first_;  // as it was given
  Options options_;
  std::unique_ptr<RunningScene> running_;
  std::optional<Probes> probes_;
  Totals flows_;                          // of all steps
  std::vector<NamedValue> latest_;        // all probes' columns, of the last step
  std::vector<ContactImpulse> impulses_;  // of the last step
  std::vector<StepRow> report_;
};

}  // namespace unibody
