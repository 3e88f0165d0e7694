#include "step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/room.hpp"
#include "partition/migrate.hpp"
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
  {
    const PhaseClock::Scope scope(clock_, Phase::halo);
    halo_.refresh_guests(world, collide_settings_);
  }
  const PhaseClock::Scope scope(clock_, Phase::collide);
  const Scratch::Frame frame(scratch_);
  Collider(&scratch_).collide(world, collide_settings_, contacts);
  detected_ = true;
}

StepReport Simulation::step() {
  detect();
  const PhaseClock::Scope scope(clock_, Phase::solve);
  const Scratch::Frame frame(scratch_);
  predict();
  const StepReport report = solve();
  finalise();
  system_ = System(&scratch_);
  detected_ = false;
  return report;
}

void Simulation::move_homes(std::span<const int> home) {
  const PhaseClock::Scope scope(clock_, Phase::partition);
  migrate(halo_.comm(), world, multipliers, home);
  halo_.reset();
  detected_ = false;
}

// v~ = v + h W f, into the system's bodies: of homes, and of guests as well, from the same states to the same bits.
void Simulation::predict() {
  const std::size_t n = world.size();
  system_.homes = world.homes;
  system_.bodies.assign(n + 1, SolverBody{});
  system_.isotropic.assign(n + 1, 1);
  for (std::size_t i = 0; i < n; ++i) {
    const FreeMotion motion = predict_motion(world.properties[i], world.state(i), scene_.gravity, step_, scene_.planar);
    system_.bodies[i] = motion.body;
    system_.isotropic[i] = motion.isotropic;
    if (motion.isotropic) continue;
    if (system_.inertia.empty()) system_.inertia.resize(n), system_.gyroscopic.resize(n);
    system_.inertia[i] = motion.inverse_inertia, system_.gyroscopic[i] = motion.gyroscopic;
  }
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

// Lays out the contacts: by colour for Gauss-Seidel, in key order for the Jacobi solvers, whose sums per body follow it.
void Simulation::build_system() {
  const std::size_t n = contacts.manifolds.size();
  cut_.build(world, contacts);
  system_.counted.assign(n, 1);
  for (std::size_t m = 0; m < n; ++m) {
    const Manifold& manifold = contacts.manifolds[m];
    system_.counted[m] = world.is_home(world.is_static(manifold.slot_a) ? manifold.slot_b : manifold.slot_a);
  }
  std::pmr::vector<std::uint32_t> order(n, &scratch_);
  std::iota(order.begin(), order.end(), 0);
  std::pmr::vector<std::int32_t> counts(&scratch_);
  std::vector<std::uint32_t> groups;
  if (!solver_.sweeps_by_colour) {
    groups = {static_cast<std::uint32_t>(n)};
    counts.assign(world.size() + 1, 0);
    for (const Manifold& m : contacts.manifolds) ++counts[m.slot_a], ++counts[m.slot_b];
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
  system_.contacts.build(contacts, order, groups, world.position, system_.bodies, system_.inertia, system_.isotropic, counts,
                         scene_.solver, step_);
}

// Runs one stage from the multipliers in the batch, whose impulses the velocities hold already.
SolveReport Simulation::run_stage(Stage::Kind kind, int iterations) {
  Stage stage{kind, step_, step_, scene_.solver.recovery_speed};
  if (scene_.solver.recovery_time >= 0) stage.recovery_time = scene_.solver.recovery_time;
  system_.contacts.start_stage(stage);
  system_.before_iteration = nullptr;
  if (kind == Stage::Kind::position && scene_.solver.gap == Gap::reevaluated)
    system_.before_iteration = [this, stage] { system_.contacts.reevaluate(world, system_.bodies, stage); };
  const SolveReport report = solver_.solve(system_, cut_, iterations, tolerance_);
  if (system_.before_iteration) system_.before_iteration();
  return report;
}

// Starts from a share of the last step's multipliers.
void Simulation::warm_start(double share) {
  if (!solver_.sweeps_by_colour) system_.wrenches.assign(world.size() + 1, Wrench{});
  if (share <= 0) return system_.contacts.set_impulses({});
  {
    const Scratch::Frame frame(scratch_);
    std::pmr::vector<ContactBatch::Impulse> start(contacts.points.size(), &scratch_);
    recall(multipliers, world, contacts, share * step_, start);
    system_.contacts.set_impulses(start);
  }
  const Scratch::Frame frame(scratch_);
  if (solver_.sweeps_by_colour) system_.wrenches.assign(world.size() + 1, Wrench{});
  system_.contacts.add_impulses(system_.wrenches);
  system_.apply_wrenches();
  if (solver_.sweeps_by_colour) system_.wrenches = std::pmr::vector<Wrench>(&scratch_);
  cut_.exchange(system_.bodies);
}

// Two stages: velocities first, from the full multipliers of the last step, with existing penetration left alone; then positions.
// A share of what the second had to add leaks into what the first starts from next time. Or positions alone, from a share of the
// old multipliers that must not pass 1/2: an unconverged position stage that starts from all of them gains energy.
StepReport Simulation::solve() {
  build_system();
  const SolverSettings& settings = scene_.solver;
  const bool two_stages = settings.stages != Stages::position;
  StepReport report;
  warm_start(two_stages ? 1 : settings.warm_start);
  std::pmr::vector<ContactBatch::Impulse> impulses(contacts.points.size(), &scratch_);
  if (two_stages) {
    report.iterations = run_stage(Stage::Kind::velocity, settings.iterations / 2).iterations;
    system_.contacts.keep_impulses(settings.stages == Stages::joint, impulses);
  }
  report.iterations += run_stage(Stage::Kind::position, settings.iterations - report.iterations).iterations;
  report.residual = system_.contacts.residual(system_.bodies);
  const double leak = settings.leak >= 0 ? settings.leak : solver_.leak(settings.iterations);
  report.sliding = system_.contacts.leak_impulses(leak, system_.counted, impulses);
  remember(multipliers, world, contacts, impulses, step_);
  MPI_Allreduce(MPI_IN_PLACE, &report.residual, 1, MPI_DOUBLE, MPI_MAX, halo_.comm());
  MPI_Allreduce(MPI_IN_PLACE, &report.sliding, 1, MPI_INT64_T, MPI_SUM, halo_.comm());
  report.converged = report.residual <= tolerance_;
  return report;
}

// q = q_l (+) h v for home bodies, and for kinematic ones on every rank.
void Simulation::finalise() {
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (i >= world.homes && i < world.first_static()) continue;
    if (world.properties[i].motion == Motion::fixed) continue;
    const Vec3 gyroscopic = system_.isotropic[i] ? Vec3(Vec3::Zero()) : system_.gyroscopic[i];
    world.set_state(i, finish_motion(world.properties[i], world.state(i), system_.bodies[i], gyroscopic, step_, scene_.planar));
  }
}

std::size_t Simulation::bytes() const {
  return bytes_of(world.id) + world.properties.bytes() + bytes_of(world.position) + bytes_of(world.orientation) +
         bytes_of(world.velocity) + bytes_of(world.angular_velocity) + bytes_of(multipliers.manifolds) +
         bytes_of(multipliers.points) + bytes_of(multipliers.places) + bytes_of(contacts.manifolds) + bytes_of(contacts.points) +
         halo_.bytes() + scratch_.bytes();
}

}  // namespace unibody
