#include "library/live_simulation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "changes/changes.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "report/state_hash.hpp"

namespace unibody {

namespace {

Motion motion_of(const BodyGroup& group, Id id) { return group.make(id - group.first).properties.motion; }

void put(const World& world, std::size_t slot, LiveSimulation::Field field, double* to) {
  const auto put_vector = [to](const Vec3& v) { std::copy_n(v.data(), 3, to); };
  switch (field) {
    case LiveSimulation::Field::position:
      return put_vector(world.position[slot]);
    case LiveSimulation::Field::velocity:
      return put_vector(world.velocity[slot]);
    case LiveSimulation::Field::angular_velocity:
      return put_vector(world.angular_velocity_of(slot));
    case LiveSimulation::Field::orientation: {
      const Quat q = world.orientation_of(slot);
      to[0] = q.w(), to[1] = q.x(), to[2] = q.y(), to[3] = q.z();
    }
  }
}

// Combines the entries of `bits` over all ranks, by their bits, so that every rank has them all. Before, each entry must be 0 on
// the ranks that don't know it, and the same on all others.
void unite(MPI_Comm comm, std::span<std::uint64_t> bits) {
  constexpr std::size_t at_once = std::size_t{1} << 28;
  for (std::size_t first = 0; first < bits.size(); first += at_once)
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, bits.data() + first, static_cast<int>(std::min(at_once, bits.size() - first)),
                            MPI_UINT64_T, MPI_BOR, comm));
}

std::vector<double> doubles_of(std::span<const std::uint64_t> bits) {
  std::vector<double> numbers(bits.size());
  std::ranges::transform(bits, numbers.begin(), [](std::uint64_t b) { return std::bit_cast<double>(b); });
  return numbers;
}

Vec3 vector_at(std::span<const double> numbers, std::size_t k) {
  return {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
}

}  // namespace

std::vector<Id> ids_named(const Scene& scene, const std::string& name) {
  std::vector<Id> ids;
  for (const BodyGroup& group : scene.groups)
    for (Id k = 0; k < group.count && group.name == name; ++k) ids.push_back(group.first + k);
  if (ids.empty())
    throw InputError("found body '" + name + "', expected the name of an entry of the scene's bodies, cloths, threads or solids");
  return ids;
}

LiveSimulation::LiveSimulation(MPI_Comm comm, const Scene& scene, const std::string& checkpoint, const std::string& continue_from)
    : scene_(scene), first_(scene) {
  if (!checkpoint.empty() && !continue_from.empty())
    throw InputError("found both a checkpoint and continue_from, expected one of them");
  options_.continue_from = continue_from;
  check_ranks_of_solver(comm, scene);
  for (const Event& event : scene.events)
    if (event.when && event.action != Event::Action::end)
      throw InputError(event.when->place +
                       ": found an event that depends on a column of report.csv, expected events at a time: a " +
                       "simulation that a program steps through writes no report.csv");
  check_mpi(MPI_Comm_dup(comm, &comm_));
  try {
    start(checkpoint);
  } catch (...) {
    close();
    throw;
  }
}

LiveSimulation::~LiveSimulation() { close(); }

void LiveSimulation::close() {
  running_.reset();
  if (comm_ != MPI_COMM_NULL) static_cast<void>(MPI_Comm_free(&comm_));  // in vain: it stays until the end
}

void LiveSimulation::check_open() const {
  if (!is_open()) throw InputError("the simulation is closed: found a call of it, expected none");
}

void LiveSimulation::start(const std::string& checkpoint) {
  const std::vector<Joint> joints = scene_.joints;
  scene_.joints = first_.joints;  // the checkpoint is of the scene as it was given
  scene_.friction_in_time = first_.friction_in_time;
  options_.restart = checkpoint;
  std::unique_ptr<RunningScene> other;
  try {
    other = std::make_unique<RunningScene>(comm_, scene_, options_);
    other->fix_scene();
    other->start();
  } catch (...) {
    scene_.joints = joints;
    throw;
  }
  scene_.joints = joints;
  for (const Event& event : scene_.events)
    for (const std::size_t joint : event.joints) scene_.joints[joint].target = first_.joints[joint].target;
  repeat_past(scene_, other->simulation.history);
  running_ = std::move(other);
  probes_.emplace(scene_.probes, step_length(), scene_.period);
  flows_.clear(), latest_.clear(), impulses_.clear(), report_.clear();
}

int LiveSimulation::rank() const {
  check_open();
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm_, &rank));
  return rank;
}

int LiveSimulation::ranks() const {
  check_open();
  int size = 1;
  check_mpi(MPI_Comm_size(comm_, &size));
  return size;
}

std::int64_t LiveSimulation::steps_done() const {
  check_open();
  return running_->simulation.when.steps_done;
}

void LiveSimulation::step() {
  check_open();
  Simulation& simulation = running_->simulation;
  const int substeps = scene_.time.substeps;
  const std::int64_t frame = simulation.when.steps_done / substeps + 1;
  const int substep = static_cast<int>(simulation.when.steps_done % substeps);
  if (substep == 0) running_->start_frame(frame);
  probes_->start_frame(simulation.world);
  StepRequest request;
  request.impulses = true;
  StepReport step = running_->step(request, frame, substep);
  impulses_ = std::move(step.impulses);
  tell_probes(impulses_);
  report_.push_back(
      {simulation.when.steps_done, step.iterations, step.sliding, step.impacts, time(), step.residual, step.converged});
  if (substep + 1 < substeps) return;
  simulation.detect();
  running_->imbalance();
  running_->rebalance();
}

void LiveSimulation::tell_probes(std::span<const ContactImpulse> impulses) {
  if (scene_.probes.empty()) return;
  probes_->add_step(impulses);
  latest_ = probes_->columns(comm_, running_->simulation.world);
  if (flows_.empty())
    for (const NamedValue& column : latest_) flows_.emplace_back(column.name, 0);
  for (std::size_t k = 0; k < latest_.size(); ++k) flows_[k].second += latest_[k].value;
}

std::vector<ForceRow> LiveSimulation::contact_forces() const {
  check_open();
  std::vector<ForceRow> rows;
  for (const ContactImpulse& c : impulses_) {
    ForceRow& row = rows.emplace_back();
    const Vec3 force = c.impulse / step_length();
    std::ranges::copy(c.ids, row.bodies), std::ranges::copy(c.shares, row.shares);
    std::copy_n(c.point.data(), 3, row.point), std::copy_n(c.normal.data(), 3, row.normal);
    std::copy_n(force.data(), 3, row.force), row.friction = c.friction;
  }
  return rows;
}

std::vector<std::pair<std::string, double>> LiveSimulation::probe(const std::string& name) const {
  check_open();
  const auto is_named = [&](const Probe& p) { return p.name == name; };
  const auto probe = std::ranges::find_if(scene_.probes, is_named);
  if (probe == scene_.probes.end()) {
    std::string names;
    for (const Probe& p : scene_.probes) names += (names.empty() ? "" : ", ") + p.name;
    throw InputError("found probe '" + name + "', expected " +
                     (names.empty() ? "none: the scene has no probes" : "one of " + names));
  }
  const bool sums = probe->kind == Probe::Kind::flow, latest = is_of_contacts(*probe);
  Probes alone(std::span(&*probe, 1), step_length(), scene_.period);
  alone.start_frame(running_->simulation.world);
  Totals values;
  for (const NamedValue& column : alone.columns(comm_, running_->simulation.world)) {
    const auto total = std::ranges::find_if(flows_, [&](const auto& f) { return f.first == column.name; });
    double now = column.known ? column.value : std::nan("");
    if (latest) {
      const auto last = std::ranges::find(latest_, column.name, &NamedValue::name);
      now = last == latest_.end() ? std::nan("") : last->value;
    }
    values.emplace_back(column.name.substr(name.size() + 1), sums ? (total == flows_.end() ? 0 : total->second) : now);
  }
  return values;
}

std::vector<double> LiveSimulation::gathered(Field field) const {
  check_open();
  const World& world = running_->simulation.world;
  const std::size_t n = width(field);
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(scene_.body_count()) * n);
  const auto add = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::array<double, 4> numbers{};
      put(world, i, field, numbers.data());
      for (std::size_t k = 0; k < n; ++k)
        bits[static_cast<std::size_t>(world.id[i]) * n + k] = std::bit_cast<std::uint64_t>(numbers[k]);
    }
  };
  add(0, world.homes), add(world.first_static(), world.size());
  unite(comm_, bits);
  std::vector<double> numbers = doubles_of(bits);
  if (!scene_.bodies_come_and_go()) return numbers;
  std::vector<std::uint64_t> present(static_cast<std::size_t>(scene_.body_count()));
  for (std::size_t i = 0; i < world.size(); ++i) present[static_cast<std::size_t>(world.id[i])] = 1;
  unite(comm_, present);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (present[i / n] == 0) numbers[i] = std::nan("");
  return numbers;
}

std::vector<Id> LiveSimulation::home_ids() const {
  check_open();
  const World& world = running_->simulation.world;
  return {world.id.begin(), world.id.begin() + static_cast<std::ptrdiff_t>(world.homes)};
}

std::vector<double> LiveSimulation::of_homes(Field field) const {
  check_open();
  const World& world = running_->simulation.world;
  std::vector<double> numbers(world.homes * width(field));
  for (std::size_t i = 0; i < world.homes; ++i) put(world, i, field, &numbers[i * width(field)]);
  return numbers;
}

std::vector<ContactRow> LiveSimulation::contacts() {
  check_open();
  Simulation& simulation = running_->simulation;
  simulation.detect();
  std::vector<ContactRow> rows;
  for (const Manifold& m : simulation.contacts.manifolds) {
    const World& world = simulation.world;
    const Slot first = world.is_static(m.slot_a) ? m.slot_b : m.slot_a;
    if (!world.is_home(first)) continue;
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      const ContactPoint& p = simulation.contacts.points[k];
      ContactRow row{m.id_a, m.id_b, {}, {}, p.gap, m.friction};
      std::copy_n(p.position.data(), 3, row.point), std::copy_n(m.normal.data(), 3, row.normal);
      rows.push_back(row);
    }
  }
  return rows;
}

Measures LiveSimulation::measures() {
  check_open();
  Simulation& simulation = running_->simulation;
  simulation.detect();
  return measure(comm_, simulation.world, simulation.contacts, scene_.gravity_at(time()), static_cast<double>(simulation.bytes()),
                 &scene_.pairs);
}

std::vector<JointState> LiveSimulation::joint_states() {
  check_open();
  constexpr std::size_t width = 13;
  const auto numbers_of_state = [](JointState& s) {
    return std::array<double*, width>{&s.drift,    &s.turn,      &s.coordinate, &s.force[0],  &s.force[1],
                                      &s.force[2], &s.torque[0], &s.torque[1],  &s.torque[2], &s.limit,
                                      &s.motor,    &s.friction,  &s.spring};
  };
  Simulation& simulation = running_->simulation;
  simulation.detect();  // so that the bodies of all joints here are known
  std::vector<std::uint64_t> bits(scene_.joints.size() * width);
  std::vector<JointState> here = simulation.joint_states();
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (!simulation.ties.joint_slots[i].counted) continue;
    const auto numbers = numbers_of_state(here[i]);
    const auto at = static_cast<std::size_t>(simulation.ties.joints[i]) * width;
    for (std::size_t k = 0; k < width; ++k) bits[at + k] = std::bit_cast<std::uint64_t>(*numbers[k]);
  }
  unite(comm_, bits);
  std::vector<JointState> all(scene_.joints.size());
  for (std::size_t j = 0; j < all.size(); ++j) {
    const auto numbers = numbers_of_state(all[j]);
    for (std::size_t k = 0; k < width; ++k) *numbers[k] = std::bit_cast<double>(bits[j * width + k]);
    all[j].broken = simulation.ties.joint_input.is_broken(static_cast<std::int64_t>(j));  // every rank knows all that have broken
  }
  return all;
}

std::uint64_t LiveSimulation::state_hash() const {
  check_open();
  return unibody::state_hash(comm_, running_->simulation.world);
}

void LiveSimulation::check_ids(std::span<const Id> ids, bool dynamic_alone) const {
  check_open();
  for (const Id id : ids) {
    if (id < 0 || id >= scene_.body_count())
      throw InputError("found body " + std::to_string(id) + ", expected an id from 0 to " +
                       std::to_string(scene_.body_count() - 1));
    const BodyGroup& group = scene_.group_of(id);
    const Motion motion = motion_of(group, id);
    const std::string name = "body " + std::to_string(id) + " (" + scene_.body_name(id) + ")";
    if (motion != Motion::dynamic && dynamic_alone)
      throw InputError("found " + name + ", which no force moves, expected a dynamic body");
    if (motion == Motion::fixed) throw InputError("found " + name + ", which is fixed, expected a dynamic or kinematic body");
    if (group.motion) throw InputError("found " + name + ", whose motion the scene gives in time, expected another body");
  }
}

void LiveSimulation::check_numbers(std::span<const Id> ids, std::span<const double> numbers, const char* what, bool turns) const {
  if (numbers.empty()) return;
  if (numbers.size() != 3 * ids.size())
    throw InputError(std::string(what) + ": found " + std::to_string(numbers.size()) + " numbers for " +
                     std::to_string(ids.size()) + " bodies, expected three a body");
  for (const double number : numbers)
    if (!std::isfinite(number))
      throw InputError(std::string(what) + ": found " + std::to_string(number) + ", expected finite numbers");
  if (!scene_.planar) return;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const Vec3 v = vector_at(numbers, k);
    if (turns ? v.x() != 0 || v.z() != 0 : v.y() != 0)
      throw InputError(std::string(what) + ": found a motion out of the plane, expected one within it: the scene is planar");
  }
}

void LiveSimulation::set_velocities(std::span<const Id> ids, std::span<const double> linear, std::span<const double> angular) {
  check_ids(ids, false);
  check_numbers(ids, linear, "velocity", false), check_numbers(ids, angular, "angular velocity", true);
  World& world = running_->simulation.world;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const Slot slot = world.find(ids[k]);
    if (slot < 0 || (!world.is_home(slot) && !world.is_static(slot))) continue;
    const auto i = static_cast<std::size_t>(slot);
    if (!linear.empty()) world.velocity[i] = vector_at(linear, k);
    if (!angular.empty() && world.has_rotations) world.angular_velocity[i] = vector_at(angular, k);
  }
  running_->simulation.bodies_were_changed();
}

void LiveSimulation::apply_forces(std::span<const Id> ids, std::span<const double> forces, std::span<const double> torques) {
  check_ids(ids, true);
  check_numbers(ids, forces, "force", false), check_numbers(ids, torques, "torque", true);
  World& world = running_->simulation.world;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const Slot slot = world.find(ids[k]);
    if (slot < 0 || !world.is_home(slot)) continue;
    const auto i = static_cast<std::size_t>(slot);
    const BodyProperties& body = world.properties[i];
    if (!forces.empty()) world.velocity[i] += step_length() / body.mass * vector_at(forces, k);
    if (torques.empty() || !world.has_rotations || body.shape.kind == ShapeKind::particle) continue;
    const Quat q = world.orientation_of(i);
    const Vec3 own = q.conjugate() * vector_at(torques, k);
    world.angular_velocity[i] += step_length() * (q * own.cwiseQuotient(body.inertia));
  }
  running_->simulation.bodies_were_changed();
}

void LiveSimulation::set_motor(std::int64_t joint, double target) {
  check_open();
  const auto count = static_cast<std::int64_t>(scene_.joints.size());
  const std::string found = "found joint " + std::to_string(joint);
  if (joint < 0 || joint >= count)
    throw InputError(found +
                     (count == 0 ? ", expected none: the scene has no joints" : ", expected 0 to " + std::to_string(count - 1)));
  Joint& j = scene_.joints[static_cast<std::size_t>(joint)];
  if (j.motor == Motor::none) throw InputError(found + ", which has no motor, expected one with a motor");
  if (!std::isfinite(target)) throw InputError("target: found " + std::to_string(target) + ", expected a finite number");
  j.target = target;
  running_->simulation.bodies_were_changed();
}

void LiveSimulation::write_checkpoint(const std::string& path) const {
  const std::int64_t steps = steps_done(), substeps = scene_.time.substeps;
  if (steps % substeps != 0)
    throw InputError("checkpoint: found step " + std::to_string(steps % substeps) + " of the " + std::to_string(substeps) +
                     " of a frame, expected the end of a frame");
  running_->write_checkpoint(path, steps / substeps);
}

void LiveSimulation::restore(const std::string& checkpoint) {
  check_open();
  start(checkpoint);
}

}  // namespace unibody
