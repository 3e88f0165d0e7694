#include "partition/work.hpp"

#include <algorithm>
#include <array>

#include "collide/collide.hpp"
#include "constraints/counted.hpp"
#include "core/checked.hpp"
#include "joints/joint_types.hpp"

namespace unibody {

namespace {

double cost_of(const Manifold& m) { return work::of_a_pair + work::of_a_point * m.count; }

}  // namespace

double cost_of(const Joint& joint) {
  const std::size_t own =
      with_joint_type(static_cast<std::uint8_t>(joint.kind), []<class T>() { return static_cast<std::size_t>(T::rows); });
  const std::size_t bounded = std::size_t{joint.is_limited()} + std::size_t{joint.has_cone()} +
                              std::size_t{joint.motor != Motor::none} + std::size_t{joint.friction > 0} +
                              std::size_t{joint.is_sprung()};
  return work::of_a_joint_row * static_cast<double>(own + bounded);
}

double work_of(const StepParts& parts) {
  double sum = work::of_a_body * static_cast<double>(parts.world.homes) +
               work::of_a_pair * static_cast<double>(parts.contacts.manifolds.size()) +
               work::of_a_point * static_cast<double>(parts.contacts.points.size()) +
               work::of_a_surface_contact * static_cast<double>(parts.contacts.surface.size());
  if (parts.constraints != nullptr)
    for_each_type(*parts.constraints,
                  [&](auto, const auto& list) { sum += cost_of_type(list) * static_cast<double>(list.size()); });
  for (const std::int64_t number : parts.joints_here) sum += cost_of(parts.joints[static_cast<std::size_t>(number)]);
  return sum;
}

std::int64_t counted_work_of(const World& world, const Contacts& contacts, std::span<const std::int32_t> marks) {
  const auto is_marked = [&](Slot s) { return !marks.empty() && s >= 0 && marks[static_cast<std::size_t>(s)] != 0; };
  const auto counts = [&](const auto& contact, std::span<const Slot> slots) {
    return counts_here(world, contact) && std::ranges::none_of(slots, is_marked);
  };
  const auto marked = marks.empty() ? 0 : std::count(marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(world.homes), 1);
  double sum = work::of_a_body * static_cast<double>(world.homes - static_cast<std::size_t>(marked));
  for (const Manifold& m : contacts.manifolds)
    if (counts(m, std::array{m.slot_a, m.slot_b})) sum += cost_of(m);
  for (const SurfaceContact& c : contacts.surface)
    if (counts(c, c.slots)) sum += work::of_a_surface_contact;
  return static_cast<std::int64_t>(sum);  // the weights are whole numbers
}

std::int64_t counted_work_of(const World& world, const ConstraintSet& constraints) {
  double sum = 0;
  for_each_type(constraints, [&](auto, const auto& list) {
    const auto counted = std::ranges::count_if(list, [&](const auto& c) { return counts_here(world, c); });
    sum += cost_of_type(list) * static_cast<double>(counted);
  });
  return static_cast<std::int64_t>(sum);
}

BorderCosts border_costs(MPI_Comm comm, const StepParts& parts) {
  std::int64_t sums[4] = {static_cast<std::int64_t>(parts.world.guests), static_cast<std::int64_t>(parts.world.homes), 0,
                          counted_work_of(parts.world, parts.contacts)};
  sums[2] = static_cast<std::int64_t>(work_of({parts.world, parts.contacts, parts.constraints}));
  if (parts.constraints != nullptr) sums[3] += counted_work_of(parts.world, *parts.constraints);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_INT64_T, MPI_SUM, comm));
  const auto share = [](std::int64_t part, std::int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  };
  return {share(sums[0], sums[1]), share(sums[2] - sums[3], sums[3])};
}

std::vector<float> work_by_body(const StepParts& parts) {
  const World& world = parts.world;
  std::vector<float> cost(world.homes, static_cast<float>(work::of_a_body));
  // moving: how many of the ends move, here or elsewhere.
  const auto share_out = [&](double whole, std::span<const Slot> ends, std::size_t moving) {
    const auto share = static_cast<float>(whole / static_cast<double>(std::max<std::size_t>(1, moving)));
    for (const Slot s : ends)
      if (s >= 0 && world.is_home(s)) cost[static_cast<std::size_t>(s)] += share;
  };
  const auto moves = [&](Slot s) { return s >= 0 && !world.is_static(s); };
  for (const Manifold& m : parts.contacts.manifolds) {
    const Slot ends[] = {m.slot_a, m.slot_b};
    share_out(cost_of(m), ends, static_cast<std::size_t>(std::count_if(std::begin(ends), std::end(ends), moves)));
  }
  for (const SurfaceContact& c : parts.contacts.surface)
    share_out(work::of_a_surface_contact, c.slots,
              static_cast<std::size_t>(std::count_if(c.slots.begin(), c.slots.end(), moves)));
  // Bodies of constraints and joints may be unknown here at the start of a run: all but those found to be static count as moving.
  const auto share_out_ids = [&](double whole, const auto& ids) {
    std::array<Slot, 4> ends{-1, -1, -1, -1};
    std::size_t moving = 0;
    for (std::size_t e = 0; e < ids.size(); ++e) {
      if (ids[e] < 0) continue;
      ends[e] = world.find(ids[e]);
      moving += ends[e] < 0 || !world.is_static(ends[e]);
    }
    share_out(whole, ends, moving);
  };
  if (parts.constraints != nullptr)
    for_each_type(*parts.constraints, [&](auto, const auto& list) {
      for (const auto& c : list) share_out_ids(cost_of_type(list), c.ids);
    });
  for (const std::int64_t number : parts.joints_here) {
    const Joint& joint = parts.joints[static_cast<std::size_t>(number)];
    share_out_ids(cost_of(joint), joint.ids);
  }
  return cost;
}

}  // namespace unibody
