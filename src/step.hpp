// One step of the simulation: collide -> predict -> solve -> finalise (paper, Algorithm 1).
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collide/collide.hpp"
#include "constraints/constraint_types.hpp"
#include "constraints/multipliers.hpp"
#include "core/phases.hpp"
#include "core/scratch.hpp"
#include "joints/joint_set.hpp"
#include "partition/cut.hpp"
#include "partition/halo.hpp"
#include "scene/scene.hpp"
#include "solve/colouring.hpp"
#include "solve/drag.hpp"
#include "solve/solver.hpp"
#include "solve/step_error.hpp"
#include "world/world.hpp"

namespace unibody {

struct ContactProblem;

// What a step is asked for beside itself. None of it changes what the step does. Collective: the same on every rank.
struct StepWishes {
  bool error = false;                 // StepReport::error; iterative solvers only
  ContactProblem* problem = nullptr;  // filled in, on rank 0, with the frictional contact problem of the rigid bodies
};

struct StepReport {
  int iterations = 0;
  double residual = 0;     // m, natural residual, of two stages the larger; max over ranks
  bool converged = false;  // the residual is within the tolerance
  std::array<double, ConstraintTypes::size> constraint_residuals{};  // m, of each type of constraint beside contacts
  double attachment_residual = 0;                                    // m, the same of attachments
  double joint_residual = 0;                                         // m, the same of joints
  std::int64_t held = 0;           // pairs that would have passed through each other, had they not been held (surface_guard.hpp)
  bool form_left = false;          // taken in the incremental form, not the total one that the scene asks for
  std::int64_t sliding = 0;        // contact points at the limit of friction, over all ranks
  std::optional<StepError> error;  // where it was wished for
};

// This rank's part of a running scene. All members are collective.
class Simulation {
 public:
  // shares_memory: ranks of one node exchange through memory that they share (partition/mailboxes.hpp). No result depends on it.
  Simulation(MPI_Comm comm, const Scene& scene, PhaseClock& clock, bool shares_memory);
  ~Simulation();

  // Takes the simulation one step of time.step / time.substeps further.
  StepReport step(const StepWishes& wishes = {});

  // Guests and contacts at the present state: of the state that step() left, and what the next step() starts from.
  void detect();

  // Moves every home body to its new home rank, and makes the constraints of those that are here then.
  void move_homes(std::span<const int> home);

  // All constraints of the bodies that are home here, not yet loaded. step() does it where nobody has.
  void make_constraints();

  // Steps taken since time 0; a run that goes on from a checkpoint sets it.
  std::int64_t steps_done = 0;

  World world;
  Multipliers multipliers;                       // of the velocity stage, or of the only stage; history, checkpointed
  Contacts contacts;                             // valid after detect()
  ConstraintSet constraints;                     // all that touch this rank's home bodies
  ConstraintMultipliers constraint_multipliers;  // of each of them; history, checkpointed
  JointList joints;                              // all that touch this rank's home bodies
  std::vector<JointImpulses> joint_impulses;     // of each of them; history, checkpointed

  bool has_surfaces() const { return !is_alone() && !scene_.surfaces.empty(); }  // that may touch something
  const Surfaces& surfaces() const { return surfaces_; }  // where they may touch anything, or feel the air; else empty
  // More bodies at one place than can be there (collide/crowds.hpp), on any rank; after detect().
  bool is_crowded() const { return crowded_; }
  struct CrowdCount {
    std::int64_t bodies = 0, most = 0;  // in crowds; in the largest
    Id one = -1;                        // of those in the largest
  };
  CrowdCount count_crowds() const;
  bool has_attachments() const { return !scene_.attachments.empty(); }  // to dynamic bodies
  bool has_joints() const { return !scene_.joints.empty(); }
  std::vector<JointState> joint_states() const;  // of each of `joints`, after a step
  std::span<const JointSlots> slots_of_joints() const { return joint_slots_; }
  const Halo& halo() const { return halo_; }
  double tolerance() const { return tolerance_; }
  SolverSettings settings_used() const;  // the scene's, with what "auto" comes to; after resolve_automatic_settings()
  void resolve_automatic_settings();     // after the bodies are in, before anything else: what goes by their size
  std::size_t bytes() const;             // all that this rank holds: of the arrays that last, and of the phases' scratch memory

 private:
  void predict();
  void predict_particles();
  void build_constraints();
  void build_system();
  void fill_places();
  void share_masses();
  StepReport solve(const StepWishes& wishes);
  StepReport solve_by_newton();
  void by_colour_and_length(const Colouring& colouring, std::span<std::uint32_t> order, std::vector<std::uint32_t>& groups) const;
  void warm_start(double share);
  bool solids_start_cold() const;
  void forget_solids(std::span<ContactBatch::Impulse> start) const;
  Stage stage(Stage::Kind kind) const;
  Stage stage_of_surfaces(Stage stage) const;
  Acceleration acceleration(Stage::Kind kind) const;
  bool only_links() const;
  bool has_tight_links() const;
  double most_stiffness_of_links() const;
  SolveReport run_stage(Stage::Kind kind, SolveFunction solver, int iterations, double tolerance);
  double contact_residual() const;
  void measure_solution(StepReport& report, double left_by_velocities = 0);
  std::vector<ContactBatch::Impulse> total_impulses(std::span<const ContactBatch::Impulse> kept, bool apart) const;
  StepError estimate_error(const SolvedStep& solved);
  ConvergedStep converged_step(const SolvedStep& solved);
  ConvergedStep solve_on(const SolvedStep& solved);
  ConvergedStep solve_anew(const SolvedStep& solved) const;
  ConvergedStep converge(SolveFunction solver);
  Scene scene_of_reference() const;
  bool has_other_reference() const;
  void fill_problem(const SolvedStep& solved, ContactProblem& problem) const;
  bool any_over_ranks(bool here) const;
  bool any_bounces() const;
  bool is_alone() const;
  bool at_velocity_level() const { return scene_.solver.level == Level::velocity; }
  Stages stages() const;
  Split split() const;
  double leak_of(const Split& split) const;
  void build_surface_contacts(std::span<const std::int32_t> counts);
  void build_attachments(std::span<const std::int32_t> counts);
  std::vector<RollingContact> rolling_contacts() const;
  void build_joints(std::span<const std::int32_t> counts);
  std::vector<double> turning_of_joints() const;
  double least_moment(std::size_t slot) const;
  void steady_turning();
  bool turns_too_fast(std::span<const double> found) const;
  void steadily(const std::function<void()>& solve);
  StepReport take_step(const StepWishes& wishes);
  void set_form(Form form);
  bool leaves_total_form() const;
  bool has_iterative_joints() const { return has_joints() && scene_.solver.joints == JointSolve::iterative; }
  bool has_constraints() const { return constraints_of_all_ > 0 || has_joints(); }  // beside contacts
  bool needs_surfaces() const { return has_surfaces() || drag_.any(); }
  double time() const { return static_cast<double>(steps_done) * step_; }  // s
  void finalise();

  const Scene& scene_;
  PhaseClock& clock_;
  Halo halo_;
  Cut cut_;
  const bool shares_memory_;
  CollideSettings collide_settings_;
  Surfaces surfaces_;
  Drag drag_;
  std::vector<AttachedNode> attached_;  // of this step, to dynamic bodies
  std::vector<JointSlots> joint_slots_;
  std::vector<double> turning_;  // h^2 K of each slot (kg m^2) that this step is steadied for
  const Solver& solver_;
  const bool resists_rolling_;
  Scratch scratch_;  // of collision detection, then of the solve
  JointBatch joint_batch_;
  System system_{&scratch_};  // within step()
  double step_ = 0, tolerance_ = 0, recovery_speed_ = most_automatic_recovery_speed;
  bool detected_ = false, constraints_made_ = false, crowded_ = false;
  std::vector<std::int32_t> crowd_ranks_;  // by slot (crowds.hpp); empty where nothing is crowded
  std::unique_ptr<ConstraintBatches> constraint_batches_;
  std::int64_t built_version_ = -1;  // of the halo, for which their slots hold
  ConstraintColours colours_{};
  std::int64_t constraints_of_all_ = 0;
  Form form_;                     // of this step
  bool links_are_tight_ = false;  // of this step: see has_tight_links()
};

}  // namespace unibody
