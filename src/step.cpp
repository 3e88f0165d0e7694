#include "step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "build.hpp"
#include "partition/migrate.hpp"
#include "partition/migrate_constraints.hpp"
#include "solve/free_motion.hpp"
#include "solve/recall.hpp"

namespace unibody {

Simulation::Simulation(MPI_Comm comm, const Scene& scene, PhaseClock& clock)
    : scene_(scene),
      clock_(clock),
      halo_(comm),
      cut_(halo_, clock),
      solver_(find_solver(scene.solver.name)),
      step_(scene.time.step / scene.time.substeps) {
  collide_settings_.step = step_;
  collide_settings_.margin = scene.solver.margin;
  collide_settings_.gravity = scene.gravity;
  collide_settings_.planar = scene.planar;
  collide_settings_.friction = scene.friction;
  collide_settings_.material_count = scene.materials.size();
}

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
    hold_pinned(scene_, world, static_cast<double>(steps_done) * step_);
    halo_.refresh_guests(world, collide_settings_);
    hold_pinned(scene_, world, static_cast<double>(steps_done) * step_);
  }
  build_constraints();
  const PhaseClock::Scope scope(clock_, Phase::collide);
  collider_.collide(world, collide_settings_, contacts);
  detected_ = true;
}

StepReport Simulation::step() {
  detect();
  const PhaseClock::Scope scope(clock_, Phase::solve);
  predict();
  const StepReport report = solve();
  finalise();
  detected_ = false;
  ++steps_done;
  return report;
}

void Simulation::move_homes(std::span<const int> home) {
  const PhaseClock::Scope scope(clock_, Phase::partition);
  auto records = constraint_records(world, constraints, constraint_multipliers, home, halo_.size());
  migrate(halo_.comm(), world, multipliers, home);
  make_constraints();
  constraint_multipliers = take_constraint_records(halo_.comm(), constraints, std::move(records));
  detected_ = false;
}

// All constraints of the bodies that are home here, and what all ranks must agree on about them.
void Simulation::make_constraints() {
  constraints = unibody::build_constraints(scene_, world);
  for_each_type(constraints,
                [&](auto type, const auto& list) { std::get<type.value>(constraint_multipliers).assign(list.size(), {}); });
  halo_.reset(world, partners(world, constraints));
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
  system_.constraints.build(constraints, world, static_cast<Slot>(world.size()), solver_.sweeps_by_colour, scene_.solver.order,
                            colours_);
  cut_.set_constraints(world, system_.constraints);
}

// v~ = v + h W f, into the system's bodies: of homes, and of guests as well, from the same states to the same bits.
void Simulation::predict() {
  const std::size_t n = world.size();
  system_.homes = world.homes;
  system_.bodies.assign(n + 1, SolverBody{});
  system_.inertia.assign(n + 1, InverseInertia{});
  system_.isotropic.assign(n + 1, 1);
  system_.wrenches.assign(n + 1, Wrench{});
  gyroscopic_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const FreeMotion motion = predict_motion(world.properties[i], world.state(i), scene_.gravity, step_, scene_.planar);
    system_.bodies[i] = motion.body;
    system_.inertia[i] = motion.inverse_inertia;
    system_.isotropic[i] = motion.isotropic;
    gyroscopic_[i] = motion.gyroscopic;
  }
}

// Manifold numbers colour by colour, and within a colour by length, so that the four lanes of a block have much the same length.
// A counting sort: stable, so that equal ones stay in key order.
std::vector<std::uint32_t> Simulation::by_colour_and_length(const Colouring& colouring,
                                                            std::vector<std::uint32_t>& groups) const {
  constexpr std::size_t lengths = 9;
  const std::size_t n = contacts.manifolds.size();
  const auto bucket = [&](std::size_t m) {
    return static_cast<std::size_t>(colouring.colour[m]) * lengths + (lengths - 1 - contacts.manifolds[m].count);
  };
  std::vector<std::uint32_t> begin(colouring.colours * lengths + 1, 0), order(n);
  for (std::size_t m = 0; m < n; ++m) ++begin[bucket(m) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  groups.resize(colouring.colours);
  for (std::size_t c = 0; c < colouring.colours; ++c) groups[c] = begin[(c + 1) * lengths];
  for (std::size_t m = 0; m < n; ++m) order[begin[bucket(m)]++] = static_cast<std::uint32_t>(m);
  return order;
}

// Lays out the contacts: by colour for Gauss-Seidel, in key order for the Jacobi solvers, whose sums per body follow it.
void Simulation::build_system() {
  const std::size_t n = contacts.manifolds.size();
  cut_.build(world, contacts);
  system_.counted.assign(n, 1);
  for (std::size_t m = 0; m < n; ++m) {
    const Manifold& manifold = contacts.manifolds[m];
    system_.counted[m] = world.is_home(world.is_static(manifold.slot_a) ? manifold.slot_b : manifold.slot_a);
  }
  std::vector<std::uint32_t> order(n), groups;
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::int32_t> counts;
  if (!solver_.sweeps_by_colour) {
    groups = {static_cast<std::uint32_t>(n)};
    counts.assign(world.size() + 1, 0);
    for (const Manifold& m : contacts.manifolds) ++counts[m.slot_a], ++counts[m.slot_b];
    system_.constraints.count(counts);
    cut_.exchange(std::span(counts));
  } else if (scene_.solver.order == Order::sequential) {
    groups.resize(n);
    std::iota(groups.begin(), groups.end(), 1);
  } else {
    const Colouring colouring = colour_manifolds(world, contacts, cut_);
    order = by_colour_and_length(colouring, groups);
    cut_.set_colours(colouring.colour, colouring.colours);
  }
  fill_places(counts);
  system_.contacts.build(contacts, order, groups, world.position, system_.bodies, system_.inertia, system_.isotropic, counts,
                         scene_.solver, step_);
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
  system_.before_iteration = nullptr;
  system_.constrained = kind == Stage::Kind::position && constraints_of_all_ > 0;
  if (kind == Stage::Kind::position && scene_.solver.gap == Gap::reevaluated)
    system_.before_iteration = [this, stage] { system_.contacts.reevaluate(world, system_.bodies, stage); };
  const SolveReport report = solver_.solve(system_, cut_, iterations, tolerance_);
  if (system_.before_iteration) system_.before_iteration();
  return report;
}

// Starts from a share of the last step's multipliers: of contacts, and of the other constraints.
void Simulation::warm_start(double share_of_contacts) {
  std::vector<ContactBatch::Impulse> start;
  if (share_of_contacts > 0) start = recall(multipliers, world, contacts, share_of_contacts * step_);
  system_.contacts.set_impulses(start);
  const double share = constraints_of_all_ > 0 ? scene_.solver.warm_start : 0;
  if (constraints_of_all_ > 0) system_.constraints.set_multipliers(constraint_multipliers, share);
  if (start.empty() && share == 0) return;
  if (!start.empty()) system_.contacts.add_impulses(system_.wrenches);
  if (share > 0) system_.constraints.add_impulses(system_.start(), system_.bodies, system_.wrenches);
  system_.apply_wrenches();
  cut_.exchange(system_.bodies);
}

// Two stages: velocities first, from the full multipliers of the last step, with existing penetration left alone; then positions.
// A share of what the second had to add leaks into what the first starts from next time. Or positions alone, from a share of the
// old multipliers that must not pass 1/2: an unconverged position stage that starts from all of them gains energy.
// Constraints other than contacts belong to the position stage; where there are no contacts, it is the only one.
StepReport Simulation::solve() {
  build_system();
  const SolverSettings& settings = scene_.solver;
  const bool two_stages = settings.stages != Stages::position && (constraints_of_all_ == 0 || any_contacts());
  StepReport report;
  warm_start(settings.stages != Stages::position ? 1 : settings.warm_start);
  if (two_stages) {
    report.iterations = run_stage(Stage::Kind::velocity, settings.iterations / 2).iterations;
    system_.contacts.keep_impulses(settings.stages == Stages::joint);
  }
  report.iterations += run_stage(Stage::Kind::position, settings.iterations - report.iterations).iterations;
  measure_solution(report);
  if (two_stages) system_.contacts.leak_impulses(settings.leak >= 0 ? settings.leak : solver_.leak(settings.iterations));
  if (constraints_of_all_ > 0) system_.constraints.get_multipliers(constraint_multipliers, constraints);
  impulses_.resize(contacts.points.size());
  system_.contacts.get_impulses(impulses_);
  remember(multipliers, world, contacts, impulses_, step_);
  return report;
}

bool Simulation::any_contacts() const {
  int any = !contacts.manifolds.empty();
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, halo_.comm());
  return any != 0;
}

void Simulation::measure_solution(StepReport& report) {
  report.residual = system_.contacts.residual(system_.bodies);
  report.sliding = system_.contacts.sliding(system_.counted);
  if (constraints_of_all_ > 0) {
    report.constraint_residuals = system_.constraints.residuals(system_.start(), system_.bodies);
    for (const double r : report.constraint_residuals) report.residual = std::max(report.residual, r);
    MPI_Allreduce(MPI_IN_PLACE, report.constraint_residuals.data(), static_cast<int>(report.constraint_residuals.size()),
                  MPI_DOUBLE, MPI_MAX, halo_.comm());
  }
  MPI_Allreduce(MPI_IN_PLACE, &report.residual, 1, MPI_DOUBLE, MPI_MAX, halo_.comm());
  MPI_Allreduce(MPI_IN_PLACE, &report.sliding, 1, MPI_INT64_T, MPI_SUM, halo_.comm());
  report.converged = report.residual <= tolerance_;
}

// q = q_l (+) h v for home bodies, and for kinematic ones on every rank.
void Simulation::finalise() {
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (i >= world.homes && i < world.first_static()) continue;
    if (world.properties[i].motion == Motion::fixed) continue;
    world.set_state(i,
                    finish_motion(world.properties[i], world.state(i), system_.bodies[i], gyroscopic_[i], step_, scene_.planar));
  }
}

std::size_t Simulation::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return of(world.id) + of(world.properties) + of(world.position) + of(world.orientation) + of(world.velocity) +
         of(world.angular_velocity) + of(multipliers.manifolds) + of(multipliers.points) + of(contacts.manifolds) +
         of(contacts.points) + of(system_.bodies) + of(system_.inertia) + of(system_.isotropic) + of(system_.wrenches) +
         of(system_.counted) + of(gyroscopic_) + system_.contacts.bytes() + of(system_.places) + system_.constraints.bytes();
}

}  // namespace unibody
