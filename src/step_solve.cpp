// The solve of a step: stages, warm start, what is remembered, what is measured of it.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "constraints/constraint_batches.hpp"
#include "core/checked.hpp"
#include "solve/free_motion.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/recall.hpp"
#include "solve/reference.hpp"
#include "solve/surface_guard.hpp"
#include "step.hpp"

namespace unibody {

// h^2 K of each slot (kg m^2), K the geometric stiffness of its joints' forces: right for home bodies, whose joints are all here.
std::vector<double> Simulation::turning_of_joints() const {
  std::vector<double> turning(world.size() + 1, 0.0);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Joint& joint = scene_.joints[static_cast<std::size_t>(joints[i])];
    const Slot ends[2] = {joint_slots_[i].a, joint_slots_[i].b};
    for (std::size_t e = 0; e < 2; ++e)
      turning[static_cast<std::size_t>(ends[e])] += step_ * turning_stiffness(joint, e, joint_impulses[i]);
  }
  return turning;
}

// Of the axes about which a body may turn (kg m^2).
double Simulation::least_moment(std::size_t slot) const {
  const Vec3& moments = world.properties[slot].inertia;
  return scene_.planar ? moments.y() : moments.minCoeff();
}

// A light body between strong joints turns back so fast that the step does not resolve it: h^2 K > I. An iteration that takes
// these forces along directions of its own would make it spin. As in Andrews et al. (Geometric stiffness for real-time
// constrained multibody dynamics, 2017) such a body's inertia against constraints is raised, here until h^2 K = I; resolved
// motion is as it was. K is that of the last step's forces.
void Simulation::steady_turning() {
  if (!has_joints() || !world.has_rotations) return;
  cut_.exchange(std::span(turning_));
  for (std::size_t i = 0; i < world.first_static(); ++i) {
    const double missing = turning_[i] - least_moment(i);
    SolverBody& body = system_.bodies[i];
    if (!(missing > 0) || world.properties[i].shape.kind == ShapeKind::particle) continue;
    if (system_.isotropic[i]) {
      body.inverse_inertia /= 1 + missing * body.inverse_inertia;
      continue;
    }
    const Vec3 moments = world.properties[i].inertia + Vec3::Constant(missing);
    system_.inertia[i] = scene_.planar ? InverseInertia{0, 1 / moments.y(), 0, 0, 0, 0}
                                       : inverse_inertia(world.orientation[i], moments.cwiseInverse());
  }
}

// Whether the step's own forces exceed what it was steadied for: at an impact they come from nothing.
bool Simulation::turns_too_fast(std::span<const double> found) const {
  bool here = false;
  for (std::size_t i = 0; i < world.homes; ++i)
    if (world.properties[i].shape.kind != ShapeKind::particle) here |= !(found[i] <= 2 * std::max(turning_[i], least_moment(i)));
  return any_over_ranks(here);
}

// Makes the prediction and solve()s, and again with the step's own forces where they turned bodies faster than it was steadied
// for.
void Simulation::steadily(const std::function<void()>& solve) {
  if (!has_joints() || !world.has_rotations) return predict(), solve();
  constexpr int most_repeats = 3;
  const auto multipliers_before = multipliers;
  const auto constraints_before = constraint_multipliers;
  const auto joints_before = joint_impulses;
  const auto velocity_before = world.velocity;
  for (int repeats = 0;; ++repeats) {
    predict();
    solve();
    std::vector<double> found = turning_of_joints();
    if (repeats == most_repeats || !turns_too_fast(found)) return;
    for (std::size_t i = 0; i < found.size(); ++i)
      turning_[i] = std::isfinite(found[i]) ? std::max(turning_[i], found[i]) : std::numeric_limits<double>::max();
    system_ = System(&scratch_);
    std::copy(velocity_before.begin(), velocity_before.end(), world.velocity.begin());  // the guard and the estimate work on it
    multipliers = multipliers_before, constraint_multipliers = constraints_before, joint_impulses = joints_before;
  }
}

void Simulation::set_form(Form form) {
  form_ = form;
  constraint_batches_->set_form(form);
}

// In the total form: whether the ends of an edge, anywhere, move too far against each other for it to converge.
bool Simulation::leaves_total_form() const {
  return form_ == Form::total && constraints_of_all_ > 0 &&
         any_over_ranks(constraint_batches_->moves_beyond(most_edge_motion, system_.start(), system_.bodies));
}

// A step of the total form whose edges move too far, with the prediction (see solve()) or with what the solve made of it, is
// taken in the incremental form, which is bounded there. It is not the step that was asked for, and so not converged.
StepReport Simulation::take_step(const StepWishes& wishes) {
  StepReport report;
  const auto take = [&] { steadily([&] { report = solve(wishes); }); };
  if (scene_.solver.form != Form::total || constraints_of_all_ == 0) {
    take();
    return report;
  }
  set_form(Form::total);
  const auto multipliers_before = multipliers;
  const auto constraints_before = constraint_multipliers;
  const auto joints_before = joint_impulses;
  const auto velocity_before = world.velocity;
  take();
  if (leaves_total_form()) {
    set_form(Form::incremental);
    system_ = System(&scratch_);
    std::copy(velocity_before.begin(), velocity_before.end(), world.velocity.begin());  // in place: the Vec lies over it
    multipliers = multipliers_before, constraint_multipliers = constraints_before, joint_impulses = joints_before;
    take();
  }
  report.form_left = form_ != Form::total;
  report.converged = report.converged && !report.form_left;
  return report;
}

// At velocity level the only stage is one of positions whose rows are linear about the start of the step.
Stage Simulation::stage(Stage::Kind kind) const {
  if (at_velocity_level()) return Stage::stabilised(step_, scene_.solver.stabilisation);
  // A time of the step's own would take penetration out the faster the finer the steps are: piles would shake.
  const double set = scene_.solver.recovery_time;
  return Stage{kind, step_, set >= 0 ? set : scene_.time.step, recovery_speed_};
}

// What is stretched over an edge pulls with stiff links, which ask for all of their error within the step; a contact that asked
// for less of its own would give way to them as long as they hang there, by centimetres.
Stage Simulation::stage_of_surfaces(Stage stage) const {
  if (!at_velocity_level() && scene_.solver.recovery_time < 0) stage.recovery_time = 0;
  return stage;
}

// How accelerated_jacobi extrapolates in a stage.
Acceleration Simulation::acceleration(Stage::Kind kind) const {
  if (scene_.solver.acceleration != Acceleration::automatic) return scene_.solver.acceleration;
  bool bears_more = scene_.solver.scaling == 1 && !any_bounces();
  if (kind == Stage::Kind::position)
    bears_more &= !has_attachments() && !has_joints() && scene_.solver.gap == Gap::frozen &&
                  (constraints_of_all_ == 0 || (!at_velocity_level() && only_links() && !links_are_tight_));
  return bears_more ? Acceleration::optimized : Acceleration::nesterov;
}

// Whether there are no constraints beside links between bodies' centres, on any rank.
bool Simulation::only_links() const {
  bool only = true;
  for_each_type(constraints,
                [&]<class C>(auto type, const ConstraintList<C>&) { only &= is_link<C> || colours_[type.value] == 0; });
  return only;
}

// Whether old multipliers say that links are too tight for the optimized momentum, on any rank.
bool Simulation::has_tight_links() const {
  if (scene_.solver.acceleration != Acceleration::automatic || solver_.solve != accelerated_jacobi) return false;
  if (constraints_of_all_ == 0 || !only_links()) return false;
  const double most = automatic_share * constraint_batches_->geometric_stiffness(system_.start(), constraint_multipliers);
  return any_over_ranks(!(most <= tight_links));
}

// Runs one stage from the multipliers in the batch, whose impulses the velocities hold already.
SolveReport Simulation::run_stage(Stage::Kind kind, SolveFunction solver, int iterations, double tolerance) {
  const Stage stage = this->stage(kind);
  system_.contacts.start_stage(stage);
  system_.surface.start_stage(stage_of_surfaces(stage));
  system_.before_iteration = nullptr;
  system_.constraints = kind == Stage::Kind::position && constraints_of_all_ > 0 ? constraint_batches_.get() : nullptr;
  system_.attachments = kind == Stage::Kind::position && has_attachments() ? &system_.attachment_rows : nullptr;
  system_.joints = kind == Stage::Kind::position && has_joints() ? &joint_batch_ : nullptr;
  const bool reevaluates = kind == Stage::Kind::position && scene_.solver.gap == Gap::reevaluated;
  const bool bounces = any_bounces();
  system_.acceleration = acceleration(kind);
  if (reevaluates || bounces)
    system_.before_iteration = [this, stage, reevaluates, bounces] {
      if (reevaluates) system_.contacts.reevaluate(world, system_.bodies, stage);
      if (bounces) system_.contacts.limit_bounces(world, system_.bodies), system_.surface.limit_bounces(world, system_.bodies);
    };
  const SolveReport report = solver(system_, cut_, iterations, tolerance);
  if (bounces && !solver_.sweeps_by_colour) {
    system_.contacts.give_back_gains(world, system_.bodies, system_.wrenches);
    system_.apply_wrenches();
    cut_.exchange(system_.bodies);
  }
  if (system_.before_iteration) system_.before_iteration();
  return report;
}

// On any rank.
bool Simulation::any_bounces() const {
  if (collide_settings_.restitution.empty()) return false;
  const auto bounces = [](const SurfaceContact& c) { return c.bounce > 0; };
  return any_over_ranks(system_.contacts.any_bounces() || std::ranges::any_of(contacts.surface, bounces));
}

namespace {

double position_share(const SolverSettings& settings) { return settings.warm_start >= 0 ? settings.warm_start : automatic_share; }

// Of contacts, where there is one stage.
double contact_share(const SolverSettings& settings) {
  return settings.level == Level::velocity && settings.warm_start < 0 ? automatic_velocity_share : position_share(settings);
}

}  // namespace

// Where tetrahedra start cold, in a position stage, what touches them must as well: an impact on stiff material, far from
// converged, goes through few nodes; a share of its force with nothing against it would throw them further than an edge is long.
bool Simulation::solids_start_cold() const {
  return scene_.solver.warm_start < 0 && stages() == Stages::position && !at_velocity_level();
}

void Simulation::forget_solids(std::span<ContactBatch::Impulse> start) const {
  const auto is_solid = [&](Slot s) { return surfaces_.is_node(s) && surfaces_.is_closed(surfaces_.surface_of(s)); };
  for (const Manifold& m : contacts.manifolds)
    if (is_solid(m.slot_a) || is_solid(m.slot_b)) std::fill_n(start.begin() + m.first, m.count, ContactBatch::Impulse{0, 0, 0});
}

// Which the old multipliers of links may start with.
double Simulation::most_stiffness_of_links() const {
  const bool optimized = solver_.solve == accelerated_jacobi && acceleration(Stage::Kind::position) == Acceleration::optimized;
  return optimized && !at_velocity_level() ? most_geometric_stiffness : HUGE_VAL;
}

// Starts from a share of the last step's multipliers: of contacts, and of the other constraints.
void Simulation::warm_start(double share_of_contacts) {
  const bool jacobi = !solver_.sweeps_by_colour;
  const double share = has_constraints() ? position_share(scene_.solver) : 0;
  joint_batch_.set_impulses(joint_impulses, share);
  if (constraints_of_all_ > 0) constraint_batches_->set_multipliers(constraint_multipliers, scene_.solver.warm_start);
  links_are_tight_ = has_tight_links();  // by this step's shares of mass, which the batches take anew from here on
  if (jacobi && (!is_alone() || has_attachments() || has_joints())) system_.wrenches.assign(world.size() + 1, Wrench{});
  if (constraints_of_all_ > 0 && (jacobi || share > 0)) system_.impulses.assign(world.size() + 1, Vec4d{});
  if (share_of_contacts <= 0) {
    system_.contacts.set_impulses({});
    if (share <= 0) return;
  } else {
    const Scratch::Frame frame(scratch_);
    std::pmr::vector<ContactBatch::Impulse> start(contacts.points.size(), &scratch_);
    recall(multipliers, world, contacts, share_of_contacts * step_, start);
    if (solids_start_cold()) forget_solids(start);
    system_.contacts.set_impulses(start);
  }
  const Scratch::Frame frame(scratch_);
  const bool borrowed = !jacobi && (share_of_contacts > 0 || has_joints()) && system_.wrenches.empty();
  if (borrowed) system_.wrenches.assign(world.size() + 1, Wrench{});
  if (share_of_contacts > 0) system_.contacts.add_impulses(system_.wrenches);
  if (share > 0 && has_joints()) joint_batch_.add_impulses(system_.bodies, system_.wrenches);
  if (share > 0 && constraints_of_all_ > 0)
    constraint_batches_->add_impulses(system_.start(), system_.bodies, system_.impulses, most_stiffness_of_links());
  system_.apply_wrenches();
  if (borrowed) system_.wrenches = std::pmr::vector<Wrench>(&scratch_);
  if (!jacobi) system_.impulses.clear();
  cut_.exchange(system_.bodies);
}

Stages Simulation::stages() const {
  if (at_velocity_level()) return Stages::position;
  if (scene_.solver.stages != Stages::automatic) return scene_.solver.stages;
  return has_constraints() && !solver_.sweeps_by_colour ? Stages::position : Stages::two;
}

// Links and joints have the position stage alone: half of the iterations are for it, whatever contacts would do with fewer.
Split Simulation::split() const {
  const SolverSettings& settings = scene_.solver;
  Split split = solver_.split(settings.iterations);
  if (has_constraints()) split.velocity_share = std::min(split.velocity_share, 0.5);
  return {settings.velocity_share >= 0 ? settings.velocity_share : split.velocity_share,
          settings.leak >= 0 ? settings.leak : split.leak, split.swelling};
}

// The leak, less while the contacts that the position stage pushed on open together: U, their mean opening speed, times S, the
// part of it that is coherent, against the solver's share of g h. A pile deeper than the velocity stage reaches in a step is a
// mass on its contacts, and what leaks into them an integral feedback too fast for it: withheld on the way up, it pumps no more.
double Simulation::leak_of(const Split& split) const {
  const double gh = scene_.gravity.norm() * step_;
  if (split.leak == 0 || split.swelling == 0 || gh == 0 || stages() != Stages::two) return split.leak;
  const std::vector<double> sums = all_sums(halo_.comm(), system_.contacts.opening(system_.bodies, system_.counted));
  if (!(sums[0] > 0)) return split.leak;
  const double speed = sums[0] / sums[2], coherence = sums[0] / sums[1];
  return split.leak * std::max(0.0, 1 - speed * coherence / (split.swelling * gh));
}

SolverSettings Simulation::settings_used() const {
  SolverSettings used = scene_.solver;
  used.tolerance = tolerance_, used.stages = stages(), used.warm_start = contact_share(scene_.solver);
  used.margin = collide_settings_.margin, used.recovery_speed = recovery_speed_;
  used.velocity_share = split().velocity_share, used.leak = split().leak;
  if (stages() == Stages::position) used.velocity_share = used.leak = 0;
  if (!at_velocity_level()) used.recovery_time = stage(Stage::Kind::position).recovery_time;
  return used;
}

// Two stages: velocities first, from the full multipliers of the last step, with existing penetration left alone; then positions.
// A share of what the second had to add leaks into what the first starts from next time, unless the first has converged: a leak
// then feeds on what the tolerance leaves, and what lies still trembles within it. Or positions alone, from a share of the
// old multipliers that must stay below 1/2: an unconverged position stage that starts from more gains energy.
// Constraints other than contacts, attachments too, belong to the position stage; where there are no contacts, it is the only
// one. At velocity level there is one stage too, of all constraints; what it leaves of the old multipliers does no harm there
// up to a larger share (settings.hpp).
StepReport Simulation::solve(const StepWishes& wishes) {
  build_system();
  if (!solver_.solve) return solve_by_newton();
  if (leaves_total_form()) set_form(Form::incremental);
  const SolverSettings& settings = scene_.solver;
  const bool two_stages =
      stages() != Stages::position && (!has_constraints() || system_.any_surface || any_over_ranks(!contacts.manifolds.empty()));
  const bool wished = wishes.error || wishes.problem;
  SolvedStep solved;
  if (wished) solved.predicted.assign(system_.bodies.begin(), system_.bodies.end()), solved.velocity_before = world.velocity;
  StepReport report;
  warm_start(stages() != Stages::position ? 1 : contact_share(settings));
  std::pmr::vector<ContactBatch::Impulse> impulses(contacts.points.size(), &scratch_);
  bool leaks = false;
  double left_by_velocities = 0;
  if (two_stages) {
    const int first = std::clamp(static_cast<int>(split().velocity_share * settings.iterations), 1, settings.iterations - 1);
    const SolveReport velocity = run_stage(Stage::Kind::velocity, solver_.solve, first, tolerance_);
    report.iterations = velocity.iterations;
    leaks = !velocity.converged;
    if (stages() == Stages::two) left_by_velocities = contact_residual();
    system_.contacts.keep_impulses(stages() == Stages::joint, impulses);
    system_.rolling.keep_impulses(stages() == Stages::joint);
    system_.surface.keep_impulses(stages() == Stages::joint);
  }
  report.iterations +=
      run_stage(Stage::Kind::position, solver_.solve, settings.iterations - report.iterations, tolerance_).iterations;
  measure_solution(report, left_by_velocities);
  if (wished) {
    solved.solved.assign(system_.bodies.begin(), system_.bodies.end());
    solved.impulses = total_impulses(impulses, two_stages && stages() != Stages::joint);
  }
  if (wishes.problem) fill_problem(solved, *wishes.problem);
  const double leak = leaks ? leak_of(split()) : 0;  // while the guests are as the homes: the guard changes homes alone
  if (has_surfaces()) report.held = SurfaceGuard(world, surfaces_, collide_settings_, &scratch_).hold(system_.bodies, halo_);
  if (settings.friction == FrictionModel::postprocess)
    report.sliding = postprocess_friction(world, contacts, impulses, system_, cut_);
  report.sliding += system_.contacts.leak_impulses(leak, system_.counted, impulses);
  report.sliding += system_.surface.sliding();
  remember(multipliers, world, contacts, impulses, step_);
  if (constraints_of_all_ > 0) constraint_batches_->get_multipliers(constraint_multipliers, constraints);
  joint_batch_.get_impulses(joint_impulses);
  if (!is_alone()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &report.sliding, 1, MPI_INT64_T, MPI_SUM, halo_.comm()));
  if (wishes.error) report.error = estimate_error(solved);
  return report;
}

namespace {

// Whether a tetrahedron ends the step turned inside out: St. Venant-Kirchhoff has equilibria there, of no solid.
template <class C>
bool inverts(const World& world, const ConstraintList<C>& solids, std::span<const Vec3> velocity, double step) {
  return std::any_of(solids.begin(), solids.end(), [&](const Constraint<C>& c) {
    const auto place = [&](std::size_t e) -> Vec3 {
      const auto slot = static_cast<std::size_t>(world.find(c.ids[e]));
      return world.position[slot] + step * velocity[slot];
    };
    const Vec3 origin = place(0);
    return (place(1) - origin).cross(place(2) - origin).dot(place(3) - origin) < 0;
  });
}

}  // namespace

// One flexible body alone on one rank, as read_scene() and run() see to. The rows hold to round-off by construction where the
// impulses are eliminated: what says how far off the step is, is how far the next iteration would move the nodes.
StepReport Simulation::solve_by_newton() {
  const ReferenceStep step = reference_step(world, constraints, std::span(system_.bodies).first(world.size()), step_);
  for (std::size_t i = 0; i < world.size(); ++i)
    for (int k = 0; k < 3; ++k) system_.bodies[i].v[k] = step.velocity[i][k];
  constraint_multipliers = step.multipliers;
  constraint_batches_->set_multipliers(constraint_multipliers, 1);
  StepReport report;
  report.iterations = step.iterations;
  measure_solution(report);
  report.residual = std::max(report.residual, step_ * step.correction);
  report.converged = step.converged;
  for_each_solid_type(constraints, [&](const auto& solids) {
    report.converged = report.converged && !inverts(world, solids, step.velocity, step_);
  });
  return report;
}

bool Simulation::any_over_ranks(bool here) const {
  int any = here;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, halo_.comm()));
  return any != 0;
}

// Natural residual (m) of the stage that was run last, on this rank.
double Simulation::contact_residual() const {
  return std::max({system_.contacts.residual(system_.bodies), system_.surface.residual(system_.bodies),
                   system_.rolling.residual(system_.contacts, system_.bodies)});
}

// The largest over all ranks, of everything in one message. What a velocity stage left counts too: the position stage starts
// anew, and would hide it.
void Simulation::measure_solution(StepReport& report, double left_by_velocities) {
  constexpr std::size_t types = ConstraintTypes::size;
  std::array<double, types + 3> largest{};  // of each type, of attachments, joints, and contacts
  double &of_attachments = largest[types], &of_joints = largest[types + 1], &of_contacts = largest[types + 2];
  if (constraints_of_all_ > 0)
    std::ranges::copy(constraint_batches_->residuals(system_.start(), system_.bodies), largest.begin());
  if (has_attachments()) of_attachments = system_.attachment_rows.residual(system_.bodies);
  if (has_joints()) of_joints = joint_batch_.residual(system_.bodies);
  of_contacts = std::max(contact_residual(), left_by_velocities);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, halo_.comm()));
  std::copy_n(largest.begin(), types, report.constraint_residuals.begin());
  report.attachment_residual = of_attachments, report.joint_residual = of_joints;
  report.residual = *std::ranges::max_element(largest);
  report.converged = report.residual <= tolerance_;
}

}  // namespace unibody
