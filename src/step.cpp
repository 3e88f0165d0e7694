#include "step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "attach.hpp"
#include "build.hpp"
#include "collide/crowds.hpp"
#include "constraints/constraint_batches.hpp"
#include "constraints/friction.hpp"
#include "core/checked.hpp"
#include "core/room.hpp"
#include "partition/migrate.hpp"
#include "partition/migrate_constraints.hpp"
#include "partition/migrate_joints.hpp"
#include "solve/free_motion.hpp"

namespace unibody {

Simulation::Simulation(MPI_Comm comm, const Scene& scene, PhaseClock& clock, bool shares_memory)
    : scene_(scene),
      clock_(clock),
      halo_(comm),
      cut_(halo_, clock, shares_memory ? Cut::usual_letter : 0),
      shares_memory_(shares_memory),
      surfaces_(scene.surfaces),
      drag_(scene),
      solver_(find_solver(scene.solver.name)),
      resists_rolling_(acts_in_solve(scene.solver.friction) && (has_any(scene.rolling) || has_any(scene.spinning))),
      step_(scene.time.step / scene.time.substeps),
      constraint_batches_(std::make_unique<ConstraintBatches>()),
      form_(scene.solver.form) {
  collide_settings_.step = step_;
  collide_settings_.gravity = scene.gravity;
  collide_settings_.planar = scene.planar;
  collide_settings_.merge_supports = !solver_.sweeps_by_colour;
  collide_settings_.friction = scene.friction;
  if (has_any(scene.restitution)) collide_settings_.restitution = scene.restitution;
  collide_settings_.material_count = scene.materials.size();
}

Simulation::~Simulation() = default;

void Simulation::resolve_automatic_settings() {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < world.homes; ++i) smallest = std::min(smallest, smallest_size(world.properties[i].shape));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, halo_.comm()));
  const SolverSettings& set = scene_.solver;
  const auto resolve = [](double value, double automatic) { return value >= 0 ? value : automatic; };
  tolerance_ = resolve(set.tolerance, std::isfinite(smallest) ? automatic_tolerance * smallest : 0);
  collide_settings_.margin = resolve(set.margin, std::min(most_automatic_margin, automatic_margin * smallest));
  const double g = scene_.gravity.norm(), toss = g > 0 ? std::sqrt(2 * g * (automatic_toss * smallest)) : HUGE_VAL;
  recovery_speed_ = resolve(set.recovery_speed, std::min(most_automatic_recovery_speed, toss));
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
  crowd_ranks_ = crowd_ranks(world);
  crowded_ = any_over_ranks(!crowd_ranks_.empty());
  if (crowded_) {
    crowd_ranks_.resize(world.size(), -1);
    halo_.tell_guests(world, crowd_ranks_);
  }
  const Scratch::Frame frame(scratch_);
  Collider(&scratch_).collide(world, collide_settings_, contacts, surfaces_.empty() ? nullptr : &surfaces_, crowd_ranks_);
  leave_out_attached(scene_, world, time(), contacts);
  leave_out_jointed(scene_.joints, joints, contacts);
}

Simulation::CrowdCount Simulation::count_crowds() const {
  CrowdCount count;
  const std::span ranks(crowd_ranks_.data(), std::min(crowd_ranks_.size(), world.homes));
  for (const std::int32_t rank : ranks) count.bodies += rank >= 0, count.most = std::max<std::int64_t>(count.most, rank + 1);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.bodies, 1, MPI_INT64_T, MPI_SUM, halo_.comm()));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.most, 1, MPI_INT64_T, MPI_MAX, halo_.comm()));
  for (std::size_t i = 0; i < ranks.size(); ++i)
    if (ranks[i] + 1 == count.most && (count.one < 0 || world.id[i] < count.one)) count.one = world.id[i];
  constexpr Id none = std::numeric_limits<Id>::max();
  if (count.one < 0) count.one = none;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.one, 1, MPI_INT64_T, MPI_MIN, halo_.comm()));
  return count;
}

// A single cloth or thread, whose nodes touch nothing.
bool Simulation::is_alone() const {
  const auto touches_itself = [](const Surface& s) { return s.self_collision; };
  return scene_.groups.size() == 1 && scene_.constraint_groups.size() == 1 &&
         std::none_of(scene_.surfaces.begin(), scene_.surfaces.end(), touches_itself);
}

StepReport Simulation::step(const StepWishes& wishes) {
  detect();
  const PhaseClock::Scope scope(clock_, Phase::solve);
  const Scratch::Frame frame(scratch_);
  if (has_joints()) turning_ = turning_of_joints();
  const StepReport report = take_step(wishes);
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
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, colours_.data(), static_cast<int>(colours_.size()), MPI_INT32_T, MPI_MAX, halo_.comm()));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &constraints_of_all_, 1, MPI_INT64_T, MPI_SUM, halo_.comm()));
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

// Where nothing turns: homes and guests are particles, most of them alike.
void Simulation::predict_particles() {
  const BodyProperties* kind = nullptr;
  double inverse_mass = 0;
  Vec3 gain = Vec3::Zero();
  for (std::size_t i = 0; i < world.first_static(); ++i) {
    const BodyProperties& body = world.properties[i];
    if (&body != kind && body.is_dynamic()) {
      kind = &body;
      inverse_mass = 1 / body.mass;
      gain = step_ * (scene_.gravity + body.force / body.mass);
    }
    Eigen::Map<Vec3> v(system_.bodies[i].v);
    v = world.velocity[i];
    if (!body.is_dynamic()) continue;  // pinned
    v += gain;
    system_.bodies[i].inverse_mass = inverse_mass;
  }
}

// v~ = v + h W f, into the system's bodies: of homes, and of guests as well, from the same states to the same bits. What the air
// does comes on top, for homes alone; build_system tells the guests.
void Simulation::predict() {
  const std::size_t n = world.size();
  system_.homes = world.homes, system_.first_static = world.first_static();
  system_.bodies.assign(n + 1, SolverBody{});
  system_.isotropic.assign(n + 1, 1);
  system_.rotates = world.has_rotations;
  if (!world.has_rotations) predict_particles();
  for (std::size_t i = world.has_rotations ? 0 : world.first_static(); i < n; ++i) {
    const FreeMotion motion = predict_motion(world.properties[i], world.state(i), scene_.gravity, step_, scene_.planar);
    system_.bodies[i] = motion.body;
    const bool held_in_plane = scene_.planar && has_joints();  // whose rows would tilt a disc whose inertia is a scalar
    system_.isotropic[i] = motion.isotropic && !held_in_plane;
    if (system_.isotropic[i]) continue;
    if (system_.inertia.empty()) system_.inertia.resize(n), system_.gyroscopic.resize(n);
    system_.inertia[i] = motion.isotropic ? InverseInertia{0, motion.body.inverse_inertia, 0, 0, 0, 0} : motion.inverse_inertia;
    system_.gyroscopic[i] = motion.gyroscopic;
    system_.bodies[i].inverse_inertia = 0;
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

// The contacts that resist rolling or spinning, ascending.
std::vector<RollingContact> Simulation::rolling_contacts() const {
  std::vector<RollingContact> list;
  if (!resists_rolling_) return list;
  for (std::uint32_t m = 0; m < contacts.manifolds.size(); ++m) {
    const auto material = [&](Slot s) {
      return static_cast<std::size_t>(world.properties[static_cast<std::size_t>(s)].material);
    };
    const std::size_t pair =
        material(contacts.manifolds[m].slot_a) * scene_.materials.size() + material(contacts.manifolds[m].slot_b);
    if (scene_.rolling[pair] > 0 || scene_.spinning[pair] > 0) list.push_back({m, scene_.rolling[pair], scene_.spinning[pair]});
  }
  return list;
}

// Lays out the contacts: by colour for Gauss-Seidel, in key order for the Jacobi solvers, whose sums per body follow it.
void Simulation::build_system() {
  const std::size_t n = contacts.manifolds.size();
  attached_ = attached_nodes(scene_, world, time());
  if (at_velocity_level())
    for (AttachedNode& a : attached_) a.gap *= scene_.solver.stabilisation;
  cut_.build(world, contacts, attached_);
  if (drag_.any()) cut_.exchange(system_.bodies);
  steady_turning();
  system_.counted.assign(n, 1);
  for (std::size_t m = 0; m < n; ++m) system_.counted[m] = counts_here(world, contacts.manifolds[m]);
  std::pmr::vector<std::uint32_t> order(n, &scratch_);
  std::iota(order.begin(), order.end(), 0);
  std::pmr::vector<std::int32_t>& counts = system_.counts;
  std::vector<std::uint32_t> groups;
  const std::vector<RollingContact> rolling = rolling_contacts();
  if (!solver_.sweeps_by_colour) {
    groups = {static_cast<std::uint32_t>(n)};
    counts.assign(world.size() + 1, 0);
    for (const Manifold& m : contacts.manifolds) ++counts[m.slot_a], ++counts[m.slot_b];
    for (const RollingContact& c : rolling)
      ++counts[contacts.manifolds[c.manifold].slot_a], ++counts[contacts.manifolds[c.manifold].slot_b];
    count_ends(contacts.surface, counts);
    count_ends(attached_, counts);
    constraint_batches_->count(counts);
    JointBatch::count(scene_.joints, joints, joint_slots_, counts);
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
  fill_places();
  system_.contacts.build(contacts, order, groups, world, system_.bodies, system_.inertia, system_.isotropic, counts,
                         scene_.solver, step_);
  system_.rolling.build(rolling, contacts, system_.contacts, world, system_.bodies, system_.inertia, system_.isotropic, counts,
                        scene_.solver.scaling, step_);
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
  system_.any_tree = scene_.joint_trees > 0;
  joint_batch_.build(scene_.joints, joints, joint_slots_, solver_.sweeps_by_colour, scene_.joint_colours, world, system_.bodies,
                     system_.inertia, system_.isotropic, counts, scene_.solver.scaling, step_, system_.stabilisation);
}

std::vector<JointState> Simulation::joint_states() const {
  std::vector<JointState> states;
  for (std::size_t i = 0; i < joints.size(); ++i)
    states.push_back(
        joint_state(scene_.joints[static_cast<std::size_t>(joints[i])], joint_slots_[i], world, joint_impulses[i], step_));
  return states;
}

void Simulation::fill_places() {
  system_.step = step_;
  system_.stabilisation = at_velocity_level() ? scene_.solver.stabilisation : -1;
  system_.places.clear();
  if (constraints_of_all_ == 0) return;
  system_.places.resize(world.size() + 1, Vec4d{});
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Vec3& x = world.position[i];
    system_.places[i] = Vec4d{x.x(), x.y(), x.z(), system_.bodies[i].inverse_mass};
  }
  if (!system_.counts.empty()) share_masses();
}

// Among each body's constraints, for the Jacobi solvers.
void Simulation::share_masses() {
  const Scratch::Frame frame(scratch_);
  std::pmr::vector<double> sharers(world.size() + 1, 0.0, &scratch_);
  if (scene_.solver.mass_sharing == MassSharing::count) {
    std::copy(system_.counts.begin(), system_.counts.end(), sharers.begin());
  } else {
    const auto of_homes = std::span(sharers).first(world.homes);
    constraint_batches_->find_sharers(system_.counts, system_.start(), system_.bodies, of_homes, &scratch_);
    cut_.exchange(std::span(sharers));
  }
  for (std::size_t i = 0; i < world.first_static(); ++i) system_.places[i][3] *= sharers[i];
}

// q = q_l (+) h v for home bodies, and for kinematic ones on every rank.
void Simulation::finalise() {
  for (std::size_t i = 0; i < world.homes && !world.has_rotations; ++i) {
    const SolverBody &solved = system_.bodies[i], &moving = system_.moving.empty() ? solved : system_.moving[i];
    world.velocity[i] = Eigen::Map<const Vec3>(solved.v);
    world.position[i] += step_ * Eigen::Map<const Vec3>(moving.v);
  }
  for (std::size_t i = world.has_rotations ? 0 : world.first_static(); i < world.size(); ++i) {
    if (i >= world.homes && i < world.first_static()) continue;
    if (world.properties[i].motion == Motion::fixed) continue;
    const Vec3 gyroscopic = system_.isotropic[i] ? Vec3(Vec3::Zero()) : system_.gyroscopic[i];
    const SolverBody &solved = system_.bodies[i], &moving = system_.moving.empty() ? solved : system_.moving[i];
    world.set_state(i, finish_motion(world.properties[i], world.state(i), moving, solved, gyroscopic, step_, scene_.planar));
  }
}

std::size_t Simulation::bytes() const {
  return bytes_of(world.id) + world.properties.bytes() + bytes_of(world.position) + bytes_of(world.orientation) +
         bytes_of(world.velocity) + bytes_of(world.angular_velocity) + bytes_of(world.held_orientation) +
         bytes_of(multipliers.manifolds) + bytes_of(multipliers.points) + bytes_of(multipliers.places) +
         bytes_of(contacts.manifolds) + bytes_of(contacts.points) + bytes_of(contacts.surface) + bytes_of(attached_) +
         drag_.bytes() + surfaces_.bytes() + halo_.bytes() + scratch_.bytes() + constraint_batches_->bytes() +
         joint_batch_.bytes() + bytes_of(joints) + bytes_of(joint_impulses) + bytes_of(joint_slots_);
}

}  // namespace unibody
