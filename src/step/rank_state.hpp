// What one rank holds of a running scene: its bodies and what touches them, and who shares them with other ranks.
#pragma once

#include <memory>
#include <vector>

#include "collide/collide.hpp"
#include "collide/restitution.hpp"
#include "constraints/attachment_batch.hpp"
#include "constraints/constraint_types.hpp"
#include "core/phases.hpp"
#include "core/scratch.hpp"
#include "joints/joint_set.hpp"
#include "partition/exchange.hpp"
#include "partition/halo.hpp"
#include "scene/scene.hpp"
#include "solve/drag.hpp"
#include "solve/solver.hpp"
#include "solve/surface_pressure.hpp"
#include "step/coarse_level.hpp"
#include "step/contact_impulse.hpp"
#include "step/history.hpp"
#include "step/plan.hpp"
#include "world/world.hpp"

namespace unibody {

// When the next step starts, and how long steps are.
struct StepTime {
  const double whole_step;      // s, time.frame / time.substeps
  std::int64_t steps_done = 0;  // since time 0; a run that goes on from a checkpoint sets it
  double in_step = 0;           // s, of a step that is taken in parts: how much of it is done
};

// What drives the bodies beside contacts and ties.
struct Drives {
  explicit Drives(const Scene& scene);

  Vec3 gravity;                              // m/s^2, the mean over the step that is taken next; after set_loads()
  std::vector<const BodyGroup*> loaded;      // dynamic bodies on which a force or torque changes in time
  std::vector<const BodyGroup*> belts;       // bodies whose surfaces move along themselves
  std::vector<const BodyGroup*> prescribed;  // kinematic bodies whose velocities change in time
  Drag drag;
  SurfacePressure pressure;
};

// What ties bodies to each other: this rank's constraints between centres, joints, couplings and attachments.
struct Ties {
  explicit Ties(const Scene& scene);
  Ties(const Ties&) = delete;  // joint_input refers to the other members
  Ties& operator=(const Ties&) = delete;

  ConstraintSet constraints;  // all that touch this rank's home bodies
  JointList joints;           // the same
  std::vector<JointSlots> joint_slots;
  JointList couplings;  // of joints, the same
  std::vector<CouplingSlots> coupling_slots;
  const JointInput joint_input;
  std::vector<double> pressed_areas;  // m^2, of the scene's joints; after measure_pressed_areas(); empty: no motor presses
  bool joints_break = false;          // some joint of the scene breaks where it bears too much
  std::size_t breaks_known = 0;       // of the history's breaks: those that `broken` and `bodies` know of
  std::vector<std::uint8_t> broken;   // 1 for each joint of the scene that has broken; empty: none has
  std::vector<Id> bodies;             // of joints that have not, and of attachments, ascending
  std::vector<std::array<Id, 2>> attachments;  // that touch this rank's home bodies: the node and the dynamic body, ascending
  std::vector<AttachedNode> attached;          // of these, the ones that hold in this step
};

// What contacts are found by.
struct ContactSearch {
  ContactSearch(const Scene& scene, const Solver& solver, double step);

  CollideSettings settings;
  Surfaces surfaces;                      // where they may touch anything, or are pushed by drag or pressure; else empty
  std::vector<std::int32_t> crowd_ranks;  // by slot (crowds.hpp); empty where nothing is crowded
  FrictionAxes friction_axes;             // of all bodies that have one
};

// What impacts have changed within the step (impacts.hpp).
struct StepImpacts {
  std::vector<Vec3> displaced;           // m, by slot: where a body that was hit seems to start the step; empty: none was hit
  std::vector<Vec3> turned;              // rad, and turned by how much, as the solve's rows see it: to first order
  std::vector<Vec3> attitude;            // rad, and as its attitude is taken: a turn of that at the step's start
  std::int64_t count = 0;                // of the step, which this rank counts
  std::vector<std::uint8_t> settled;     // of each manifold: impacts alone say how it bounces; empty: of none
  std::vector<BounceStart> starts;       // by slot: from where the others bounce; empty: nothing does
  std::vector<ContactImpulse> impulses;  // of these
  std::vector<double> gaps_found;        // m, of contact points, before impacts were taken into them; empty: they were not
};

// What a manifold gave to one of its bodies beside its rows (edge_crossing.hpp).
struct CrossingImpulse {
  std::size_t manifold;
  Vec3 on_a;  // N s, on the manifold's first body
};

// What the rows of the step's constraints are laid out and steadied by.
struct StepRows {
  Form form = Form::incremental;             // in which this step solves constraints between centres
  ConstraintColours colours{};               // of each type, over all ranks
  std::vector<std::int32_t> lasting_counts;  // for the Jacobi solvers, of each slot: constraints of the batches that last
  std::vector<double> geometric_stiffness;   // h^2 K of each slot (kg m^2) that the step is steadied for; empty: no joints
  std::vector<double> adhesive;              // N s, by contact point, as they were found (adhesion.hpp); empty: nothing adheres
  std::vector<CrossingImpulse> crossings;    // ascending manifolds, of home bodies
};

struct RankState {
  // in_shared_memory: ranks of one node exchange through memory that they share (partition/mailboxes.hpp). No result depends on
  // it.
  RankState(MPI_Comm over, const Scene& of, PhaseClock& timed_by, bool in_shared_memory);

  const Scene& scene;
  PhaseClock& clock;
  const Solver& solver;
  SceneTraits traits;
  StepTime when;

  World world;
  History history;
  Contacts contacts;  // valid after detect()
  Drives drives;
  Ties ties;
  ContactSearch search;
  StepImpacts impacts;
  StepRows rows;
  CoarseLevel coarse;

  Halo halo;
  Exchange exchange;
  Scratch scratch;  // of collision detection, then of the solve

  double step() const { return traits.step; }  // s, or of the part of one that is taken next
  double time() const { return static_cast<double>(when.steps_done) * when.whole_step + when.in_step; }  // s
  MPI_Comm comm() const { return halo.comm(); }
  bool is_tied(Id id) const;             // by a joint, an attachment or a constraint between centres: not free
  bool any_over_ranks(bool here) const;  // collective
  bool has_surfaces() const { return !is_alone() && !scene.surfaces.empty(); }  // that may touch something
  bool needs_surfaces() const { return has_surfaces() || drives.drag.any() || drives.pressure.any(); }
  bool is_pushed() const { return drives.drag.any() || drives.pressure.any() || !scene.part_loads.empty(); }  // besides contacts
  bool is_alone() const;  // a single cloth or thread, whose nodes touch nothing
  Elements elements() const {
    return {world, &ties.constraints, traits.has_joints ? &ties.joint_input : nullptr, ties.attachments};
  }
  std::size_t bytes() const;  // of the arrays that last, and of the phases' scratch memory; the batches come on top
};

// The bodies of attachments and of joints that have not broken, ascending.
std::vector<Id> tied_bodies(const Scene& scene, const std::vector<std::uint8_t>& broken);

}  // namespace unibody
