#include "report/probes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/checked.hpp"
#include "report/loaded_bodies.hpp"

namespace unibody {

namespace {

// The sums of one probe. A flow has its count, mass and momentum along its normal; a box its count, mass, momentum, mass times
// squared speed and volume; a force its impulse and the moment of that; a stress the six sums of impulse times branch; a cell the
// impulses outwards on its lower plates and on its upper ones, and the volume of what is in it.
constexpr std::size_t sums_of_one = 7;

bool is_probed(const ProbedBodies& bodies, const World& world, std::size_t slot) {
  const BodyProperties& body = world.properties[slot];
  return world.id[slot] >= bodies.first && world.id[slot] < bodies.end && !body.is_static() &&
         (bodies.material < 0 || body.material == bodies.material);
}

// 1 or -1 where the way crosses the disc about `point` along its normal or against it, else 0.
int crossing(const Probe& probe, const Vec3& point, const Vec3& from, const Vec3& to) {
  const double before = (from - point).dot(probe.normal), after = (to - point).dot(probe.normal);
  if ((before < 0) == (after < 0)) return 0;
  const Vec3 place = from + (to - from) * (before / (before - after));
  if (!((place - point).norm() <= probe.radius)) return 0;
  return before < 0 ? 1 : -1;
}

// The sum over all images of the disc in a periodic scene. A disc without a rim is its own image along it.
int crossings(const Probe& probe, const Period& period, const Vec3& from, const Vec3& to) {
  if (!period.any()) return crossing(probe, probe.point, from, to);
  const Vec3 point = period.wrapped(probe.point);
  Image first = period.image_of(from.cwiseMin(to)), last = period.image_of(from.cwiseMax(to));
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const bool has_images = period.along(k) && (std::isfinite(probe.radius) || probe.normal[k] != 0);
    if (has_images)
      --first[axis], ++last[axis];
    else
      first[axis] = last[axis] = 0;
  }
  int sum = 0;
  for (Image i = first; i[0] <= last[0]; ++i[0])
    for (i[1] = first[1]; i[1] <= last[1]; ++i[1])
      for (i[2] = first[2]; i[2] <= last[2]; ++i[2]) sum += crossing(probe, point + period.shift(i), from, to);
  return sum;
}

bool contains(const Probe& box, const Vec3& place) {
  return (place.array() >= box.low.array()).all() && (place.array() < box.high.array()).all();
}

void add_flow(const Probe& probe, const World& world, std::span<const Vec3> start, std::span<ExactSum> sums) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!is_probed(probe.bodies, world, i)) continue;
    const int number = crossings(probe, world.period, start[i], world.position[i]);
    if (number == 0) continue;
    const double mass = number * world.properties[i].mass;
    sums[0] += number, sums[1] += mass, sums[2] += mass * world.velocity[i].dot(probe.normal);
  }
}

void add_box(const Probe& probe, const World& world, std::span<ExactSum> sums) {
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (!is_probed(probe.bodies, world, i) || !contains(probe, world.period.wrapped(world.position[i], probe.low))) continue;
    const double mass = world.properties[i].mass;
    sums[0] += 1, sums[1] += mass;
    for (int k = 0; k < 3; ++k) sums[static_cast<std::size_t>(2 + k)] += mass * world.velocity[i][k];
    sums[5] += mass * world.velocity[i].squaredNorm(), sums[6] += volume(world.properties[i].shape);
  }
}

// The part of the contact's impulse that the probe's bodies take.
double share_of(const Probe& probe, const ContactImpulse& contact) {
  double share = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (!probe.on.holds(contact.ids[k])) continue;
    bool by_those = false;  // an end of the other side is one of them
    for (std::size_t l = 0; l < 4; ++l)
      by_those = by_those || (contact.shares[k] * contact.shares[l] < 0 && probe.by.holds(contact.ids[l]));
    if (by_those) share += contact.shares[k];
  }
  return share;
}

void add_force(const Probe& probe, std::span<const ContactImpulse> impulses, std::span<ExactSum> sums) {
  for (const ContactImpulse& contact : impulses) {
    const double share = share_of(probe, contact);
    if (share == 0) continue;
    const Vec3 impulse = share * contact.impulse, moment = (contact.point - probe.point).cross(impulse);
    for (int k = 0; k < 3; ++k)
      sums[static_cast<std::size_t>(k)] += impulse[k], sums[static_cast<std::size_t>(3 + k)] += moment[k];
  }
}

// The symmetric part of impulse times branch, the way from the second side's centre to the first's: xx, yy, zz, yz, xz, xy.
void add_stress(const Probe& probe, const Period& period, std::span<const ContactImpulse> impulses, std::span<ExactSum> sums) {
  for (const ContactImpulse& contact : impulses) {
    if (!contains(probe, period.wrapped(contact.point, probe.low))) continue;
    const auto moments = symmetric_product(contact.impulse, contact.sides[0] - contact.sides[1]);
    for (std::size_t k = 0; k < moments.size(); ++k) sums[k] += moments[k];
  }
}

// What pushes the plates apart: along each axis, of the lower one and of the upper one.
void add_cell_force(const Probe& probe, std::span<const ContactImpulse> impulses, std::span<ExactSum> sums) {
  for (const ContactImpulse& contact : impulses)
    for (std::size_t k = 0; k < 4; ++k) {
      if (!probe.on.holds(contact.ids[k])) continue;
      const int number = static_cast<int>(contact.ids[k] - probe.on.first);
      for (int axis = 0; axis < 3; ++axis) {
        const int plate = number - probe.cell->plates[static_cast<std::size_t>(axis)];
        if (probe.cell->plates[static_cast<std::size_t>(axis)] < 0 || plate < 0 || plate > 1) continue;
        const double outwards = (probe.cell->axes * Vec3::Unit(axis)).dot(contact.shares[k] * contact.impulse);
        sums[static_cast<std::size_t>(2 * axis + plate)] += plate == 1 ? outwards : -outwards;
      }
    }
}

// m: the room between the plates now. Collective.
Vec3 size_of(const TriaxialCell& cell, const IdRange& plates, MPI_Comm comm, const World& world) {
  Vec3 moved = Vec3::Zero();  // of the upper plates; each is home on one rank, and the others add zero
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (!plates.holds(world.id[i])) continue;
    const int number = static_cast<int>(world.id[i] - plates.first);
    const Vec3 place = cell.axes.conjugate() * (world.position[i] - cell.corner);
    for (int k = 0; k < 3; ++k)
      if (const int low = cell.plates[static_cast<std::size_t>(k)]; low >= 0 && number == low + 1)
        moved[k] = place[k] - world.properties[i].shape.size[k];
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, moved.data(), 3, MPI_DOUBLE, MPI_SUM, comm));
  for (int k = 0; k < 3; ++k)
    if (cell.plates[static_cast<std::size_t>(k)] < 0) moved[k] = cell.size[k];
  return moved;
}

void add_cell_volume(const Probe& probe, const Vec3& size, const World& world, std::span<ExactSum> sums) {
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (probe.on.holds(world.id[i]) || !is_probed(probe.bodies, world, i)) continue;
    const Vec3 place = probe.cell->axes.conjugate() * (world.position[i] - probe.cell->corner);
    bool inside = true;
    for (int k = 0; k < 3; ++k)
      if (probe.cell->plates[static_cast<std::size_t>(k)] >= 0) inside = inside && place[k] >= 0 && place[k] < size[k];
    if (inside) sums[6] += volume(world.properties[i].shape);
  }
}

void add_cell_columns(const Probe& probe, const Vec3& size, double frame, const double* of, std::vector<NamedValue>& columns) {
  for (int k = 0; k < 3; ++k)
    if (probe.cell->plates[static_cast<std::size_t>(k)] >= 0)
      columns.push_back({probe.name + "_size_" + "xyz"[k] + " (m)", size[k]});
  for (int k = 0; k < 3; ++k)
    if (probe.cell->plates[static_cast<std::size_t>(k)] >= 0)
      columns.push_back(
          {probe.name + "_pressure_" + "xyz"[k] + " (Pa)", 0.5 * (of[2 * k] + of[2 * k + 1]) * size[k] / (frame * size.prod())});
  columns.push_back({probe.name + "_solid_fraction (1)", of[6] / size.prod()});
}

void add_box_columns(const Probe& probe, const double* of, std::vector<NamedValue>& columns) {
  const double mass = of[1];
  const bool known = mass > 0;
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < 3 && known; ++k) mean[k] = of[2 + k] / mass;
  for (int k = 0; k < 3; ++k) columns.push_back({probe.name + "_velocity_" + "xyz"[k] + " (m/s)", mean[k], known});
  const double spread = known ? std::max(0.0, of[5] / mass - mean.squaredNorm()) : 0;
  columns.push_back({probe.name + "_temperature (m^2/s^2)", spread / 3, known});
  columns.push_back({probe.name + "_solid_fraction (1)", of[6] / (probe.high - probe.low).prod()});
}

void add_columns(const Probe& probe, double frame, const double* of, std::vector<NamedValue>& columns) {
  if (probe.kind == Probe::Kind::stress) {
    const double volume = (probe.high - probe.low).prod();
    constexpr std::array parts{"xx", "yy", "zz", "yz", "xz", "xy"};
    for (std::size_t k = 0; k < parts.size(); ++k)
      columns.push_back({probe.name + "_stress_" + parts[k] + " (Pa)", of[k] / (frame * volume)});
    return;
  }
  const auto axes = [&](const std::string& name, const std::string& unit, const double* values) {
    for (std::size_t k = 0; k < 3; ++k) columns.push_back({probe.name + name + "xyz"[k] + unit, values[k] / frame});
  };
  if (probe.kind == Probe::Kind::force) {
    axes("_force_", " (N)", of);
    axes("_torque_", " (N m)", of + 3);
    return;
  }
  columns.push_back({probe.name + "_count (1)", of[0]}), columns.push_back({probe.name + "_mass (kg)", of[1]});
  if (probe.kind == Probe::Kind::flow)
    columns.push_back({probe.name + "_momentum (kg m/s)", of[2]});
  else
    add_box_columns(probe, of, columns);
}

}  // namespace

bool is_of_contacts(const Probe& probe) {
  return probe.kind == Probe::Kind::force || probe.kind == Probe::Kind::stress || probe.kind == Probe::Kind::cell;
}

bool Probes::wants_impulses() const { return std::ranges::any_of(probes_, is_of_contacts); }

void Probes::add_step(std::span<const ContactImpulse> impulses) {
  for (std::size_t p = 0; p < probes_.size() && !impulses_.empty(); ++p) {
    const auto own = std::span(impulses_).subspan(sums_of_one * p, sums_of_one);
    if (probes_[p].kind == Probe::Kind::force) add_force(probes_[p], impulses, own);
    if (probes_[p].kind == Probe::Kind::stress) add_stress(probes_[p], period_, impulses, own);
    if (probes_[p].kind == Probe::Kind::cell) add_cell_force(probes_[p], impulses, own);
  }
}

void Probes::start_frame(const World& world) {
  if (std::ranges::any_of(probes_, [](const Probe& probe) { return probe.kind == Probe::Kind::flow; }))
    start_.assign(world.position.begin(), world.position.begin() + static_cast<std::ptrdiff_t>(world.homes));
  if (wants_impulses()) impulses_.assign(sums_of_one * probes_.size(), ExactSum{});
}

std::vector<NamedValue> Probes::columns(MPI_Comm comm, const World& world) const {
  std::vector<NamedValue> columns;
  if (probes_.empty()) return columns;
  std::vector<ExactSum> sums(sums_of_one * probes_.size());
  std::vector<Vec3> sizes(probes_.size(), Vec3::Zero());  // of cells
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const auto own = std::span(sums).subspan(sums_of_one * p, sums_of_one);
    if (probes_[p].kind == Probe::Kind::flow) add_flow(probes_[p], world, start_, own);
    if (probes_[p].kind == Probe::Kind::box) add_box(probes_[p], world, own);
    if (is_of_contacts(probes_[p]) && !impulses_.empty()) std::copy_n(&impulses_[sums_of_one * p], sums_of_one, own.begin());
    if (probes_[p].kind != Probe::Kind::cell) continue;
    sizes[p] = size_of(*probes_[p].cell, probes_[p].on, comm, world);
    add_cell_volume(probes_[p], sizes[p], world, own);
  }
  const std::vector<double> totals = all_sums(comm, sums);
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const double* of = &totals[sums_of_one * p];
    if (probes_[p].kind == Probe::Kind::cell)
      add_cell_columns(probes_[p], sizes[p], frame_, of, columns);
    else
      add_columns(probes_[p], frame_, of, columns);
  }
  return columns;
}

}  // namespace unibody
