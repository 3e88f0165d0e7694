// What the scene's probes find, frame by frame.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "core/exact_sum.hpp"
#include "report/stretch.hpp"
#include "scene/probe.hpp"
#include "step/contact_impulse.hpp"
#include "world/world.hpp"

namespace unibody {

// Whether its columns are means of what contacts did in the steps of a frame.
bool is_of_contacts(const Probe& probe);

// A body is where its centre is. Through a flow's disc goes what is behind it at the start of a frame and before it at the end,
// where the straight way between the two crosses it; what goes back counts as negative.
class Probes {
 public:
  // frame: s, its length. period: of the scene.
  Probes(std::span<const Probe> probes, double frame, const Period& period) : probes_(probes), frame_(frame), period_(period) {}

  // Between this and columns() bodies keep their ranks.
  void start_frame(const World& world);

  // Whether add_step() is to be called after each step, with the impulses of its contacts.
  bool wants_impulses() const;
  void add_step(std::span<const ContactImpulse> impulses);

  // The columns of all probes. Flows and boxes have their count (1) and mass (kg). A flow also has the momentum along its
  // normal (kg m/s), all per frame. A box has the mean velocity by mass (m/s) and the granular temperature, a third of the mean
  // square of velocities about it by mass (m^2/s^2), neither where nothing is in it, and the share of its room that bodies with
  // their centres in it take. A force has its mean over the frame (N), and the mean torque (N m); a stress its mean over the
  // frame (Pa), positive in compression: the sum of force times branch over the contacts whose points are in the box, over its
  // volume. A cell has the size of its room (m), the pressures on its plates, means of the frame and of both plates (Pa), and the
  // share of the room that bodies take. The same bits on any number of ranks. Collective.
  std::vector<NamedValue> columns(MPI_Comm comm, const World& world) const;

 private:
  std::span<const Probe> probes_;
  double frame_;
  Period period_;
  std::vector<Vec3> start_;         // m, of home bodies; empty where no probe is a flow
  std::vector<ExactSum> impulses_;  // of this frame, as probes.cpp has them; empty where no probe is of contacts
};

}  // namespace unibody
