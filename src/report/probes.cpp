#include "report/probes.hpp"

#include <algorithm>

#include "core/exact_sum.hpp"

namespace unibody {

namespace {

constexpr std::size_t sums_of_one =
    5;  // count, mass, and of a flow the momentum along its normal, of a box the momentum's vector

bool is_probed(const ProbedBodies& bodies, const World& world, std::size_t slot) {
  const BodyProperties& body = world.properties[slot];
  return world.id[slot] >= bodies.first && world.id[slot] < bodies.end && body.is_dynamic() &&
         (bodies.material < 0 || body.material == bodies.material);
}

// 1 or -1 where the way crosses the disc along its normal or against it, else 0.
int crossing(const Probe& probe, const Vec3& from, const Vec3& to) {
  const double before = (from - probe.point).dot(probe.normal), after = (to - probe.point).dot(probe.normal);
  if ((before < 0) == (after < 0)) return 0;
  const Vec3 place = from + (to - from) * (before / (before - after));
  if (!((place - probe.point).norm() <= probe.radius)) return 0;
  return before < 0 ? 1 : -1;
}

bool contains(const Probe& box, const Vec3& place) {
  return (place.array() >= box.low.array()).all() && (place.array() < box.high.array()).all();
}

void add_flow(const Probe& probe, const World& world, std::span<const Vec3> start, std::span<ExactSum> sums) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!is_probed(probe.bodies, world, i)) continue;
    const int sign = crossing(probe, start[i], world.position[i]);
    if (sign == 0) continue;
    const double mass = sign * world.properties[i].mass;
    sums[0] += sign, sums[1] += mass, sums[2] += mass * world.velocity[i].dot(probe.normal);
  }
}

void add_box(const Probe& probe, const World& world, std::span<ExactSum> sums) {
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (!is_probed(probe.bodies, world, i) || !contains(probe, world.position[i])) continue;
    const double mass = world.properties[i].mass;
    sums[0] += 1, sums[1] += mass;
    for (int k = 0; k < 3; ++k) sums[static_cast<std::size_t>(2 + k)] += mass * world.velocity[i][k];
  }
}

}  // namespace

void Probes::start_frame(const World& world) {
  if (std::ranges::any_of(probes_, [](const Probe& probe) { return probe.kind == Probe::Kind::flow; }))
    start_.assign(world.position.begin(), world.position.begin() + static_cast<std::ptrdiff_t>(world.homes));
}

std::vector<NamedValue> Probes::columns(MPI_Comm comm, const World& world) const {
  std::vector<NamedValue> columns;
  if (probes_.empty()) return columns;
  std::vector<ExactSum> sums(sums_of_one * probes_.size());
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const auto own = std::span(sums).subspan(sums_of_one * p, sums_of_one);
    if (probes_[p].kind == Probe::Kind::flow)
      add_flow(probes_[p], world, start_, own);
    else
      add_box(probes_[p], world, own);
  }
  const std::vector<double> totals = all_sums(comm, sums);
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const double* of = &totals[sums_of_one * p];
    const std::string& name = probes_[p].name;
    columns.push_back({name + "_count (1)", of[0]}), columns.push_back({name + "_mass (kg)", of[1]});
    if (probes_[p].kind == Probe::Kind::flow) {
      columns.push_back({name + "_momentum (kg m/s)", of[2]});
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const bool known = of[1] > 0;
      columns.push_back({name + "_velocity_" + "xyz"[k] + " (m/s)", known ? of[2 + k] / of[1] : 0, known});
    }
  }
  return columns;
}

}  // namespace unibody
