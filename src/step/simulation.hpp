// A running scene, step by step (paper, Algorithm 1).
#pragma once

#include <span>
#include <vector>

#include "step/detect.hpp"
#include "step/rank_state.hpp"
#include "step/step_report.hpp"

namespace unibody {

// This rank's part of a running scene. All members are collective, but for those that only tell something.
class Simulation : public RankState {
 public:
  Simulation(MPI_Comm over, const Scene& of, PhaseClock& timed_by, bool in_shared_memory);

  // After the bodies are in, before anything else: what goes by their size.
  void resolve_automatic_settings();

  // Takes the simulation one step of time.frame / time.substeps further, in parts where a joint asks for it (division.hpp).
  StepReport step(const StepRequest& request = {});
  using RankState::step;

  // Guests and contacts at the present state: of the state that step() left, and what the next step() starts from.
  void detect();

  // After velocities of bodies were set from outside, between steps: contacts are found anew.
  void bodies_were_changed() { done_.contacts_found = false; }

  // Moves every home body to its new home rank, and makes the constraints of those that are here then.
  void move_homes(std::span<const int> home);

  // Between steps, takes the bodies of these ids out of the world, then adds others, none of which is there already: statics on
  // every rank alike, all others on one. Collective where any rank has something to change.
  struct BodyChanges {
    std::vector<Id> removed;  // those that are not here do not matter
    std::vector<Body> homes, statics;
  };
  void change_bodies(const BodyChanges& changes);

  // Between steps: joints of the scene, by their places, that do nothing from now on. The same on every rank.
  void release(std::span<const std::size_t> joints);

  // All constraints of the bodies that are home here, not yet loaded. detect() does it where nobody has.
  void make_constraints();

  bool is_crowded() const { return done_.is_crowded; }  // more bodies at one place than can be there, on any rank; after detect()
  std::vector<JointState> joint_states() const;         // of each of `joints`; after detect() or a step
  SolverSettings settings_used() const;                 // the scene's, with what "auto" comes to; after detect()
  std::size_t bytes() const;                            // all that this rank holds

 private:
  void set_length(double length);
  StepReport take_part(const StepRequest& request);
  StepReport attempt(const StepRequest& request);
  StepReport take_in_form(const StepRequest& request);

  // What has been done for the step that comes next.
  struct Done {
    bool constraints_made = false, contacts_found = false;
    bool is_crowded = false;
    bool loads_compared = true;       // what joints bore in the last step, with what they bear
    std::int64_t built_version = -1;  // of the halo, for which the slots of the batches that last hold
  };

  System system_{&scratch};  // within step(), but for the batches that last
  Done done_;
};

}  // namespace unibody
