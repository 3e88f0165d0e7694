// The plan of a step: every setting that the scene leaves to the program, as a value. A pure function of the settings, of what
// the scene is and of what the step has found; summary.json tells the plan as used.
#pragma once

#include <cstdint>
#include <limits>

#include "constraints/solver_settings.hpp"
#include "constraints/stage.hpp"

namespace unibody {

// What a scene is, as far as its steps are planned by it: the same on all ranks.
struct SceneTraits {
  double frame = 0.016, step = 0.016;                              // s, the length of a frame and of a step
  double gravity = 9.81;                                           // m/s^2
  double smallest_size = std::numeric_limits<double>::infinity();  // m, least extent of the smallest dynamic body; infinite: none
  bool has_centre_constraints = false;                             // links, membranes, tetrahedra ... between bodies' centres
  bool only_links = false;                                         // all of these are links
  bool has_solids = false, only_solids = false;                    // some of these, or all, are tetrahedra of solids
  double stiffness = std::numeric_limits<double>::infinity();  // of those, as far as asks_for_stiffness() (scene/stiffness.hpp)
  bool has_joints = false;
  bool has_attachments = false;   // to dynamic bodies
  bool adheres = false;           // some pair of materials
  bool complies = false;          // contacts of some pair of materials
  bool is_wet = false;            // some pair of materials has bridges of liquid
  double adhesion_range = 0;      // m, the largest that a pair of materials says
  std::int64_t lasting_work = 0;  // ns an iteration (partition/work.hpp), of joints and constraints between centres

  SceneTraits of_free_islands() const;  // of what the bodies would be without those constraints
  bool has_constraints() const { return has_centre_constraints || has_joints; }  // beside contacts
};

// What a step has found, on any rank.
struct StepFacts {
  bool any_contact = false;
  bool bounces = false;          // some contact bounces
  bool links_are_tight = false;  // see links_are_tight() below
  double error_ratio = 0;        // of the error of a step to its residual, as far as it is known; see accuracy.hpp
  // ns an iteration, of all ranks (partition/work.hpp), and what of it is of islands without constraints; 0: not known
  std::int64_t work = 0, free_work = 0;
  // Where the plan asks for islands (asks_for_islands()): some contact is of an island without constraints, or of one with them.
  bool free_contacts = false, constrained_contacts = false;
};

struct StepPlan {
  // By the size of the smallest body and the step: see "auto" in solver_settings.hpp.
  double tolerance = 0, margin = 0, recovery_speed = 0;  // m, m, m/s
  int iterations = 0;                                    // the most of a step, over both stages
  // m. Where the program may take more than the default iterations, a stage first goes for the residual `aim`, in as many
  // iterations as it has of the default ones (least_...). After them it stops at `tolerance`, or where more of them hardly help.
  // Where `least_...` are 0, `aim` is `tolerance`.
  double aim = 0;
  int least_velocity_iterations = 0, least_position_iterations = 0;
  double recovery_time = 0, surface_recovery_time = 0;  // s

  Islands islands = Islands::all;  // of which this is the plan
  Form form = Form::incremental;   // of all constraints between centres where the scene says it, else of solids alone
  Stages stages = Stages::two;
  bool two_stages = false;                            // this step has a velocity stage
  int velocity_iterations = 0;                        // most of them; what they leave of all iterations is the position stage's
  double velocity_share = 0, leak = 0, swelling = 0;  // see Split
  double most_weights = 0;  // of a body, which a contact may bear before it leaks less (ContactBatch::limit_leak); 0: any

  // The shares of the old multipliers from which a step starts: of contacts, and of all others. Types that start cold take
  // theirs only where the scene says so.
  double contacts_share = 0, share = 0;
  double uneven_share = 1;         // in this step; see Split
  bool solids_start_cold = false;  // contacts of solids start from nothing
  Acceleration velocity_acceleration = Acceleration::nesterov, position_acceleration = Acceleration::nesterov;
  double most_stiffness = std::numeric_limits<double>::infinity();  // geometric stiffness with which a link may start

  int least_of(Stage::Kind kind) const {
    return kind == Stage::Kind::velocity ? least_velocity_iterations : least_position_iterations;
  }
  Stage stage(Stage::Kind kind, const SolverSettings& settings, double step) const;
};

// What is decided for the whole scene from a property of a part of it:
// - the smallest body sets the tolerance, the margin and the speed of recovery of all, and the sampled steps of all the ratio of
//   error to residual by which an accuracy becomes a tolerance;
// - one contact that bounces makes the momentum of accelerated_jacobi Nesterov's for all;
// - one tetrahedron that is too stiff makes the form of all solids incremental, as does an edge that moves too far in a step.
// Islands without constraints beside contacts are solved apart from the others, where there are both, each kind by its own plan.
// Where the scene leaves the iterations open, the islands of a kind share one number of them, which falls with the work of all
// islands of that kind together.
// What is decided for all islands with constraints from a property of one:
// - one constraint makes the Jacobi solvers take them in one position stage, from a share of the old multipliers, and gives the
//   velocity stage of Gauss-Seidel half of the iterations at most;
// - one joint or attachment, one constraint that is no link, one tight link: the momentum of accelerated_jacobi is Nesterov's;
// - one contact makes a step have a velocity stage, where its plan has two stages; a step without contacts leaves that stage out.
StepPlan plan(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts = {});

// The share of the old multipliers that the scene asks for, or that so many iterations of a step make best.
double old_share(const SolverSettings& settings, int iterations);

// Whether it matters to the plan how stiff solids are: finding out takes a pass over their tetrahedra.
bool asks_for_stiffness(const SolverSettings& settings, const SceneTraits& traits);

// Whether it matters to the plan if links are tight: finding out takes a pass over all of them.
bool asks_for_tight_links(const SolverSettings& settings, const SceneTraits& traits);
// The plan of the islands that the plan above leaves out, where a step has found free contacts beside constraints.
StepPlan plan_of_free_islands(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts);

// Whether the plan depends on which islands have constraints.
bool asks_for_islands(const SolverSettings& settings, const SceneTraits& traits);

// m, the tolerance that bodies with contacts alone have where the scene asks for none; infinite: nothing moves.
double tolerance_of_contacts(const SceneTraits& traits);

// m, what a contact may have crept by before it is taken back; see constraints/creep.hpp.
double least_creep(const SceneTraits& traits);

bool links_are_tight(double geometric_stiffness);  // of the tightest link, with all of the old multipliers

}  // namespace unibody
