#include "step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "attach.hpp"
#include "build.hpp"
#include "constraints/constraint_batches.hpp"
#include "core/room.hpp"
#include "partition/migrate.hpp"
#include "partition/migrate_constraints.hpp"
#include "partition/migrate_joints.hpp"
#include "solve/free_motion.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/recall.hpp"
#include "solve/reference.hpp"
#include "solve/surface_guard.hpp"

namespace unibody {

Simulation::Simulation(MPI_Comm comm, const Scene& scene, PhaseClock& clock)
    : scene_(scene),
      clock_(clock),
      halo_(comm),
      cut_(halo_, clock),
      surfaces_(scene.surfaces),
      drag_(scene),
      solver_(find_solver(scene.solver.name)),
      step_(scene.time.step / scene.time.substeps),
      constraint_batches_(std::make_unique<ConstraintBatches>()) {
  collide_settings_.step = step_;
  collide_settings_.margin = scene.solver.margin;
  collide_settings_.gravity = scene.gravity;
  collide_settings_.planar = scene.planar;
  collide_settings_.friction = scene.friction;
  if (std::any_of(scene.restitution.begin(), scene.restitution.end(), [](double e) { return e > 0; }))
    collide_settings_.restitution = scene.restitution;
  collide_settings_.material_count = scene.materials.size();
}

Simulation::~Simulation() = default;

void Simulation::set_tolerance_from_bodies() {
  tolerance_ = scene_.solver.tolerance;
  if (tolerance_ >= 0) return;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < world.homes; ++i) smallest = std::min(smallest, smallest_size(world.properties[i].shape));
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, halo_.comm());
  tolerance_ = std::isfinite(smallest) ? 1e-4 * smallest : 0;
}

void Simulation::detect() {
  if (detected_) return;
  if (!constraints_made_) make_constraints();
  {
    const PhaseClock::Scope scope(clock_, Phase::halo);
    hold_pinned(scene_, world, time(), step_);  // homes, so that their guests learn it
    collide_settings_.has_past = steps_done > 0;
    if (is_alone() && !needs_surfaces())
      halo_.refresh_partners(world);
    else
      halo_.refresh_guests(world, collide_settings_, needs_surfaces() ? &surfaces_ : nullptr);
    hold_pinned(scene_, world, time(), step_);  // guests: a refresh brings states only
  }
  build_constraints();
  const PhaseClock::Scope scope(clock_, Phase::collide);
  detected_ = true;
  if (is_alone()) return;
  const Scratch::Frame frame(scratch_);
  Collider(&scratch_).collide(world, collide_settings_, contacts, surfaces_.empty() ? nullptr : &surfaces_);
  leave_out_attached(scene_, world, time(), contacts);
  leave_out_jointed(scene_.joints, joints, contacts);
}

// A single cloth or thread, whose nodes touch nothing.
bool Simulation::is_alone() const {
  const auto touches_itself = [](const Surface& s) { return s.self_collision; };
  return scene_.groups.size() == 1 && scene_.constraint_groups.size() == 1 &&
         std::none_of(scene_.surfaces.begin(), scene_.surfaces.end(), touches_itself);
}

StepReport Simulation::step() {
  detect();
  const PhaseClock::Scope scope(clock_, Phase::solve);
  const Scratch::Frame frame(scratch_);
  const StepReport report = solve_steadily();
  finalise();
  system_ = System(&scratch_);
  detected_ = false;
  ++steps_done;
  return report;
}

void Simulation::move_homes(std::span<const int> home) {
  const PhaseClock::Scope scope(clock_, Phase::partition);
  auto records = constraint_records(world, constraints, constraint_multipliers, home, halo_.size());
  const auto of_joints = joint_records(world, scene_.joints, joints, joint_impulses, home, halo_.size());
  migrate(halo_.comm(), world, multipliers, home);
  make_constraints();
  constraint_multipliers = take_constraint_records(halo_.comm(), constraints, std::move(records));
  if (has_joints()) joint_impulses = take_joint_records(halo_.comm(), joints, of_joints);
  detected_ = false;
}

// All constraints of the bodies that are home here, and what all ranks must agree on about them.
void Simulation::make_constraints() {
  constraints = unibody::build_constraints(scene_, world);
  for_each_type(constraints,
                [&](auto type, const auto& list) { std::get<type.value>(constraint_multipliers).assign(list.size(), {}); });
  joints = joints_here(scene_.joints, world);
  joint_impulses.assign(joints.size(), {});
  std::vector<Id> wanted = partners(world, constraints);
  const auto add = [&](const std::vector<Id>& more) {
    std::vector<Id> both;
    std::set_union(wanted.begin(), wanted.end(), more.begin(), more.end(), std::back_inserter(both));
    wanted = std::move(both);
  };
  if (needs_surfaces()) add(surfaces_.partners(world));
  if (has_attachments()) add(partners(world, scene_.attachments));
  if (has_joints()) add(partners(scene_.joints, joints, world));
  halo_.reset(world, wanted);
  colours_ = {};
  constraints_of_all_ = static_cast<std::int64_t>(constraint_count(constraints));
  for_each_type(constraints, [&](auto type, const auto& list) {
    for (const auto& constraint : list) colours_[type.value] = std::max(colours_[type.value], constraint.colour + 1);
  });
  MPI_Allreduce(MPI_IN_PLACE, colours_.data(), static_cast<int>(colours_.size()), MPI_INT32_T, MPI_MAX, halo_.comm());
  MPI_Allreduce(MPI_IN_PLACE, &constraints_of_all_, 1, MPI_INT64_T, MPI_SUM, halo_.comm());
  built_version_ = -1;
  constraints_made_ = true;
}

// The slots of the constraints' bodies, where they may have moved.
void Simulation::build_constraints() {
  if (built_version_ == halo_.version()) return;
  built_version_ = halo_.version();
  constraint_batches_->build(constraints, world, static_cast<Slot>(world.size()), solver_.sweeps_by_colour, scene_.solver,
                             colours_);
  cut_.set_constraints(world, *constraint_batches_);
  if (has_joints()) {
    joint_slots_ = joint_slots(scene_.joints, joints, world, static_cast<Slot>(world.size()));
    cut_.set_joints(world, scene_.joints, joints, joint_slots_, solver_.sweeps_by_colour ? scene_.joint_colours : 0);
  }
  if (drag_.any()) drag_.build(world, surfaces_);
}

// v~ = v + h W f, into the system's bodies: of homes, and of guests as well, from the same states to the same bits. What the air
// does comes on top, for homes alone; build_system tells the guests.
void Simulation::predict() {
  const std::size_t n = world.size();
  system_.homes = world.homes;
  system_.bodies.assign(n + 1, SolverBody{});
  system_.isotropic.assign(n + 1, 1);
  system_.rotates = world.has_rotations;
  for (std::size_t i = 0; i < n; ++i) {
    const FreeMotion motion = predict_motion(world.properties[i], world.state(i), scene_.gravity, step_, scene_.planar);
    system_.bodies[i] = motion.body;
    system_.isotropic[i] = motion.isotropic;
    if (motion.isotropic) continue;
    if (system_.inertia.empty()) system_.inertia.resize(n), system_.gyroscopic.resize(n);
    system_.inertia[i] = motion.inverse_inertia, system_.gyroscopic[i] = motion.gyroscopic;
  }
  if (drag_.any()) drag_.apply(world, step_, world.homes, system_.bodies);
}

// Manifold numbers colour by colour, and within a colour by length, so that the four lanes of a block have much the same length.
// A counting sort: stable, so that equal ones stay in key order.
void Simulation::by_colour_and_length(const Colouring& colouring, std::span<std::uint32_t> order,
                                      std::vector<std::uint32_t>& groups) const {
  constexpr std::size_t lengths = 9;
  const std::size_t n = contacts.manifolds.size();
  const auto bucket = [&](std::size_t m) {
    return static_cast<std::size_t>(colouring.colour[m]) * lengths + (lengths - 1 - contacts.manifolds[m].count);
  };
  std::vector<std::uint32_t> begin(colouring.colours * lengths + 1, 0);
  for (std::size_t m = 0; m < n; ++m) ++begin[bucket(m) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  groups.resize(colouring.colours);
  for (std::size_t c = 0; c < colouring.colours; ++c) groups[c] = begin[(c + 1) * lengths];
  for (std::size_t m = 0; m < n; ++m) order[begin[bucket(m)]++] = static_cast<std::uint32_t>(m);
}

namespace {

// Adds one for each contact to the counts of its ends.
void count_ends(std::span<const SurfaceContact> contacts, std::span<std::int32_t> counts) {
  for (const SurfaceContact& contact : contacts)
    for (const Slot s : contact.slots)
      if (s >= 0) ++counts[static_cast<std::size_t>(s)];
}
void count_ends(std::span<const AttachedNode> attached, std::span<std::int32_t> counts) {
  for (const AttachedNode& a : attached)
    for (const Slot s : {a.body, a.node}) ++counts[static_cast<std::size_t>(s)];
}

}  // namespace

// Lays out the contacts: by colour for Gauss-Seidel, in key order for the Jacobi solvers, whose sums per body follow it.
void Simulation::build_system() {
  const std::size_t n = contacts.manifolds.size();
  attached_ = attached_nodes(scene_, world, time());
  cut_.build(world, contacts, attached_);
  if (drag_.any()) cut_.exchange(system_.bodies);
  steady_turning();
  system_.counted.assign(n, 1);
  for (std::size_t m = 0; m < n; ++m) system_.counted[m] = counts_here(world, contacts.manifolds[m]);
  std::pmr::vector<std::uint32_t> order(n, &scratch_);
  std::iota(order.begin(), order.end(), 0);
  std::pmr::vector<std::int32_t> counts(&scratch_);
  std::vector<std::uint32_t> groups;
  if (!solver_.sweeps_by_colour) {
    groups = {static_cast<std::uint32_t>(n)};
    counts.assign(world.size() + 1, 0);
    for (const Manifold& m : contacts.manifolds) ++counts[m.slot_a], ++counts[m.slot_b];
    count_ends(contacts.surface, counts);
    count_ends(attached_, counts);
    constraint_batches_->count(counts);
    for (std::size_t i = 0; i < joints.size(); ++i)
      for (const Slot s : {joint_slots_[i].a, joint_slots_[i].b})
        counts[static_cast<std::size_t>(s)] += JointBatch::parts_of(scene_.joints[static_cast<std::size_t>(joints[i])]);
    cut_.exchange(std::span(counts));
  } else if (scene_.solver.order == Order::sequential) {
    groups.resize(n);
    std::iota(groups.begin(), groups.end(), 1);
  } else {
    const Scratch::Frame frame(scratch_);
    const Colouring colouring = colour_manifolds(world, contacts, cut_, &scratch_);
    by_colour_and_length(colouring, order, groups);
    cut_.set_colours(colouring.colour, colouring.colours);
  }
  fill_places(counts);
  system_.contacts.build(contacts, order, groups, world.position, system_.bodies, system_.inertia, system_.isotropic, counts,
                         scene_.solver, step_);
  build_surface_contacts(counts);
  build_attachments(counts);
  build_joints(counts);
}

// With Gauss-Seidel they share masses among themselves alone.
void Simulation::build_surface_contacts(std::span<const std::int32_t> counts_of_all) {
  system_.any_surface = has_surfaces() && any_over_ranks(!contacts.surface.empty());
  if (!system_.any_surface) return;
  std::pmr::vector<std::int32_t> own(&scratch_);
  if (counts_of_all.empty()) {
    own.assign(world.size() + 1, 0);
    count_ends(contacts.surface, own);
    cut_.exchange(std::span(own));
    system_.wrenches.assign(world.size() + 1, Wrench{});
  }
  system_.surface.build(contacts.surface, system_.bodies, system_.inertia, system_.isotropic,
                        counts_of_all.empty() ? std::span<const std::int32_t>(own) : counts_of_all, scene_.solver, step_,
                        [&](const SurfaceContact& contact) { return counts_here(world, contact); });
}

// As the contacts of surfaces.
void Simulation::build_attachments(std::span<const std::int32_t> counts_of_all) {
  if (!has_attachments()) return;
  std::pmr::vector<std::int32_t> own(&scratch_);
  if (counts_of_all.empty()) {
    own.assign(world.size() + 1, 0);
    count_ends(attached_, own);
    cut_.exchange(std::span(own));
    system_.wrenches.assign(world.size() + 1, Wrench{});
  }
  system_.attachment_rows.build(attached_, system_.bodies, system_.inertia, system_.isotropic,
                                counts_of_all.empty() ? std::span<const std::int32_t>(own) : counts_of_all, scene_.solver.scaling,
                                step_, world.homes);
}

void Simulation::build_joints(std::span<const std::int32_t> counts) {
  if (!has_joints()) return;
  joint_batch_.build(scene_.joints, joints, joint_slots_, solver_.sweeps_by_colour, scene_.joint_colours, world, system_.bodies,
                     system_.inertia, system_.isotropic, counts, scene_.solver.scaling, step_);
}

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

// A light body between strong joints turns back so fast that the step does not resolve it: h^2 K > I. An iteration that takes
// these forces along directions of its own would make it spin. As in Andrews et al. (Geometric stiffness for real-time
// constrained multibody dynamics, 2017) such a body's inertia against constraints is raised, here until h^2 K = I; resolved
// motion is as it was. K is that of the last step's forces.
void Simulation::steady_turning() {
  if (!has_joints() || !world.has_rotations) return;
  cut_.exchange(std::span(turning_));
  for (std::size_t i = 0; i < world.first_static(); ++i) {
    const double missing = turning_[i] - world.properties[i].inertia.minCoeff();
    SolverBody& body = system_.bodies[i];
    if (!(missing > 0) || world.properties[i].shape.kind == ShapeKind::particle) continue;
    if (system_.isotropic[i]) {
      body.inverse_inertia /= 1 + missing * body.inverse_inertia;
      continue;
    }
    const Vec3 moments = world.properties[i].inertia + Vec3::Constant(missing);
    system_.inertia[i] =
        inverse_inertia(world.orientation[i], scene_.planar ? Vec3(0, 1 / moments.y(), 0) : Vec3(moments.cwiseInverse()));
  }
}

// Whether the step's own forces exceed what it was steadied for: at an impact they come from nothing.
bool Simulation::turns_too_fast(std::span<const double> found) const {
  bool here = false;
  for (std::size_t i = 0; i < world.homes; ++i)
    if (world.properties[i].shape.kind != ShapeKind::particle)
      here |= !(found[i] <= 2 * std::max(turning_[i], world.properties[i].inertia.minCoeff()));
  return any_over_ranks(here);
}

// Solves the step, and again with its own forces where they turned bodies faster than it was steadied for.
StepReport Simulation::solve_steadily() {
  if (!has_joints() || !world.has_rotations) return predict(), solve();
  constexpr int most_repeats = 3;
  turning_ = turning_of_joints();
  const auto multipliers_before = multipliers;
  const auto constraints_before = constraint_multipliers;
  const auto joints_before = joint_impulses;
  for (int repeats = 0;; ++repeats) {
    predict();
    const StepReport report = solve();
    std::vector<double> found = turning_of_joints();
    if (repeats == most_repeats || !turns_too_fast(found)) return report;
    for (std::size_t i = 0; i < found.size(); ++i)
      turning_[i] = std::isfinite(found[i]) ? std::max(turning_[i], found[i]) : std::numeric_limits<double>::max();
    system_ = System(&scratch_);
    multipliers = multipliers_before, constraint_multipliers = constraints_before, joint_impulses = joints_before;
  }
}

std::vector<JointState> Simulation::joint_states() const {
  std::vector<JointState> states;
  for (std::size_t i = 0; i < joints.size(); ++i)
    states.push_back(
        joint_state(scene_.joints[static_cast<std::size_t>(joints[i])], joint_slots_[i], world, joint_impulses[i], step_));
  return states;
}

void Simulation::fill_places(std::span<const std::int32_t> counts) {
  system_.step = step_;
  system_.places.clear();
  if (constraints_of_all_ == 0) return;
  system_.places.resize(world.size() + 1, Vec4d{});
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Vec3& x = world.position[i];
    const double sharers = counts.empty() ? 1 : counts[i];
    system_.places[i] = Vec4d{x.x(), x.y(), x.z(), sharers * system_.bodies[i].inverse_mass};
  }
}

// Runs one stage from the multipliers in the batch, whose impulses the velocities hold already.
SolveReport Simulation::run_stage(Stage::Kind kind, int iterations) {
  Stage stage{kind, step_, step_, scene_.solver.recovery_speed};
  if (scene_.solver.recovery_time >= 0) stage.recovery_time = scene_.solver.recovery_time;
  system_.contacts.start_stage(stage);
  system_.surface.start_stage(stage);
  system_.before_iteration = nullptr;
  system_.constraints = kind == Stage::Kind::position && constraints_of_all_ > 0 ? constraint_batches_.get() : nullptr;
  system_.attachments = kind == Stage::Kind::position && has_attachments() ? &system_.attachment_rows : nullptr;
  system_.joints = kind == Stage::Kind::position && has_joints() ? &joint_batch_ : nullptr;
  if (kind == Stage::Kind::position && scene_.solver.gap == Gap::reevaluated)
    system_.before_iteration = [this, stage] { system_.contacts.reevaluate(world, system_.bodies, stage); };
  const SolveReport report = solver_.solve(system_, cut_, iterations, tolerance_);
  if (system_.before_iteration) system_.before_iteration();
  return report;
}

namespace {

double position_share(const SolverSettings& settings) { return settings.warm_start >= 0 ? settings.warm_start : automatic_share; }

}  // namespace

// Starts from a share of the last step's multipliers: of contacts, and of the other constraints.
void Simulation::warm_start(double share_of_contacts) {
  const bool jacobi = !solver_.sweeps_by_colour;
  const double share = has_constraints() ? position_share(scene_.solver) : 0;
  joint_batch_.set_impulses(joint_impulses, share);
  if (constraints_of_all_ > 0) constraint_batches_->set_multipliers(constraint_multipliers, scene_.solver.warm_start);
  if (jacobi && (!is_alone() || has_attachments() || has_joints())) system_.wrenches.assign(world.size() + 1, Wrench{});
  if (constraints_of_all_ > 0 && (jacobi || share > 0)) system_.impulses.assign(world.size() + 1, Vec4d{});
  if (share_of_contacts <= 0) {
    system_.contacts.set_impulses({});
    if (share <= 0) return;
  } else {
    const Scratch::Frame frame(scratch_);
    std::pmr::vector<ContactBatch::Impulse> start(contacts.points.size(), &scratch_);
    recall(multipliers, world, contacts, share_of_contacts * step_, start);
    system_.contacts.set_impulses(start);
  }
  const Scratch::Frame frame(scratch_);
  const bool borrowed = !jacobi && (share_of_contacts > 0 || has_joints()) && system_.wrenches.empty();
  if (borrowed) system_.wrenches.assign(world.size() + 1, Wrench{});
  if (share_of_contacts > 0) system_.contacts.add_impulses(system_.wrenches);
  if (share > 0 && has_joints()) joint_batch_.add_impulses(system_.bodies, system_.wrenches);
  if (share > 0 && constraints_of_all_ > 0) constraint_batches_->add_impulses(system_.start(), system_.bodies, system_.impulses);
  system_.apply_wrenches();
  if (borrowed) system_.wrenches = std::pmr::vector<Wrench>(&scratch_);
  if (!jacobi) system_.impulses.clear();
  cut_.exchange(system_.bodies);
}

Stages Simulation::stages() const {
  if (scene_.solver.stages != Stages::automatic) return scene_.solver.stages;
  return has_constraints() && !solver_.sweeps_by_colour ? Stages::position : Stages::two;
}

// Two stages: velocities first, from the full multipliers of the last step, with existing penetration left alone; then positions.
// A share of what the second had to add leaks into what the first starts from next time. Or positions alone, from a share of the
// old multipliers that must stay below 1/2: an unconverged position stage that starts from more gains energy.
// Constraints other than contacts, attachments too, belong to the position stage; where there are no contacts, it is the only
// one.
StepReport Simulation::solve() {
  build_system();
  if (!solver_.solve) return solve_by_newton();
  const SolverSettings& settings = scene_.solver;
  const bool two_stages =
      stages() != Stages::position && (!has_constraints() || system_.any_surface || any_over_ranks(!contacts.manifolds.empty()));
  StepReport report;
  warm_start(stages() != Stages::position ? 1 : position_share(settings));
  std::pmr::vector<ContactBatch::Impulse> impulses(contacts.points.size(), &scratch_);
  if (two_stages) {
    report.iterations = run_stage(Stage::Kind::velocity, settings.iterations / 2).iterations;
    system_.contacts.keep_impulses(stages() == Stages::joint, impulses);
    system_.surface.keep_impulses(stages() == Stages::joint);
  }
  report.iterations += run_stage(Stage::Kind::position, settings.iterations - report.iterations).iterations;
  const double leak = settings.leak >= 0 ? settings.leak : solver_.leak(settings.iterations);
  measure_solution(report);
  if (has_surfaces()) report.held = SurfaceGuard(world, surfaces_, collide_settings_, &scratch_).hold(system_.bodies, halo_);
  if (settings.friction == FrictionModel::postprocess)
    report.sliding = postprocess_friction(world, contacts, impulses, system_, cut_);
  report.sliding += system_.contacts.leak_impulses(two_stages ? leak : 0, system_.counted, impulses);
  report.sliding += system_.surface.sliding();
  remember(multipliers, world, contacts, impulses, step_);
  if (constraints_of_all_ > 0) constraint_batches_->get_multipliers(constraint_multipliers, constraints);
  joint_batch_.get_impulses(joint_impulses);
  MPI_Allreduce(MPI_IN_PLACE, &report.sliding, 1, MPI_INT64_T, MPI_SUM, halo_.comm());
  return report;
}

namespace {

// Whether a tetrahedron ends the step turned inside out: St. Venant-Kirchhoff has equilibria there, of no solid.
bool inverts(const World& world, const ConstraintList<Tetrahedron>& solids, std::span<const Vec3> velocity, double step) {
  return std::any_of(solids.begin(), solids.end(), [&](const Constraint<Tetrahedron>& c) {
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
  report.converged = step.converged && !inverts(world, std::get<ConstraintList<Tetrahedron>>(constraints), step.velocity, step_);
  return report;
}

bool Simulation::any_over_ranks(bool here) const {
  int any = here;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, halo_.comm());
  return any != 0;
}

void Simulation::measure_solution(StepReport& report) {
  report.residual = std::max(system_.contacts.residual(system_.bodies), system_.surface.residual(system_.bodies));
  if (constraints_of_all_ > 0) {
    report.constraint_residuals = constraint_batches_->residuals(system_.start(), system_.bodies);
    for (const double r : report.constraint_residuals) report.residual = std::max(report.residual, r);
    MPI_Allreduce(MPI_IN_PLACE, report.constraint_residuals.data(), static_cast<int>(report.constraint_residuals.size()),
                  MPI_DOUBLE, MPI_MAX, halo_.comm());
  }
  if (has_attachments()) {
    report.attachment_residual = system_.attachment_rows.residual(system_.bodies);
    MPI_Allreduce(MPI_IN_PLACE, &report.attachment_residual, 1, MPI_DOUBLE, MPI_MAX, halo_.comm());
    report.residual = std::max(report.residual, report.attachment_residual);
  }
  if (has_joints()) {
    report.joint_residual = joint_batch_.residual(system_.bodies);
    MPI_Allreduce(MPI_IN_PLACE, &report.joint_residual, 1, MPI_DOUBLE, MPI_MAX, halo_.comm());
    report.residual = std::max(report.residual, report.joint_residual);
  }
  MPI_Allreduce(MPI_IN_PLACE, &report.residual, 1, MPI_DOUBLE, MPI_MAX, halo_.comm());
  report.converged = report.residual <= tolerance_;
}

// q = q_l (+) h v for home bodies, and for kinematic ones on every rank.
void Simulation::finalise() {
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (i >= world.homes && i < world.first_static()) continue;
    if (world.properties[i].motion == Motion::fixed) continue;
    const Vec3 gyroscopic = system_.isotropic[i] ? Vec3(Vec3::Zero()) : system_.gyroscopic[i];
    const SolverBody &solved = system_.bodies[i], &moving = system_.moving.empty() ? solved : system_.moving[i];
    world.set_state(i, finish_motion(world.properties[i], world.state(i), moving, solved, gyroscopic, step_, scene_.planar));
  }
}

std::size_t Simulation::bytes() const {
  return bytes_of(world.id) + world.properties.bytes() + bytes_of(world.position) + bytes_of(world.orientation) +
         bytes_of(world.velocity) + bytes_of(world.angular_velocity) + bytes_of(multipliers.manifolds) +
         bytes_of(multipliers.points) + bytes_of(multipliers.places) + bytes_of(contacts.manifolds) + bytes_of(contacts.points) +
         bytes_of(contacts.surface) + bytes_of(attached_) + drag_.bytes() + surfaces_.bytes() + halo_.bytes() + scratch_.bytes() +
         constraint_batches_->bytes() + joint_batch_.bytes() + bytes_of(joints) + bytes_of(joint_impulses) +
         bytes_of(joint_slots_);
}

}  // namespace unibody
