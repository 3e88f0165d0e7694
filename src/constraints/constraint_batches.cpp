#include "constraints/constraint_batches.hpp"

#include <algorithm>
#include <numeric>

#include "world/world.hpp"

namespace unibody {

namespace {

// A Jacobi sweep goes through the constraints of so many bodies colour by colour: one that adds to a body right after another
// did would wait for its sum, and so many bodies stay in the nearest cache.
constexpr Id ids_in_a_run = 64;

}  // namespace

template <class C>
void ConstraintBatches::build_type(ConstraintBatch<C>& batch, const ConstraintList<C>& list, const World& world, Slot nobody,
                                   bool by_colour, const SolverSettings& settings, std::int32_t colours) {
  std::vector<std::uint32_t> numbers(list.size()), groups;
  std::iota(numbers.begin(), numbers.end(), 0);
  if (by_colour && settings.order == Order::sequential) {
    groups.resize(list.size());
    std::iota(groups.begin(), groups.end(), 1);
  } else if (by_colour) {
    groups.assign(static_cast<std::size_t>(colours) + 1, 0);
    for (const Constraint<C>& c : list) ++groups[static_cast<std::size_t>(c.colour) + 1];
    std::partial_sum(groups.begin(), groups.end(), groups.begin());
    for (std::uint32_t i = 0; i < list.size(); ++i) numbers[groups[static_cast<std::size_t>(list[i].colour)]++] = i;
    groups.resize(static_cast<std::size_t>(colours));
  } else {
    groups = {static_cast<std::uint32_t>(list.size())};
    const auto key = [&](std::uint32_t i) { return std::pair(list[i].ids[0] / ids_in_a_run, list[i].colour); };
    std::stable_sort(numbers.begin(), numbers.end(), [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
  }
  const auto slots = [&](std::uint32_t i) {
    std::array<Slot, C::stencil> ends;
    for (std::size_t e = 0; e < C::stencil; ++e) ends[e] = world.find(list[i].ids[e]);
    return ends;
  };
  const auto counted = [&](std::uint32_t i) {
    for (const Id id : list[i].ids) {
      const Slot s = world.find(id);
      if (!world.is_static(s)) return world.is_home(s);
    }
    return false;
  };
  batch.build(list, numbers, groups, nobody, settings.form, slots, counted);
}

void ConstraintBatches::build(const ConstraintSet& set, const World& world, Slot nobody, bool by_colour,
                              const SolverSettings& settings, const ConstraintColours& colours) {
  for_each_type(set, [&](auto type, const auto& list) {
    build_type(std::get<type.value>(batches_), list, world, nobody, by_colour, settings, colours[type.value]);
  });
  counts_.assign(empty() ? 0 : static_cast<std::size_t>(nobody) + 1, 0);
  for_each_stencil([&](std::span<const Slot> ends) {
    for (const Slot s : ends) ++counts_[static_cast<std::size_t>(s)];
  });
}

void ConstraintBatches::count(std::span<std::int32_t> counts) const {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts[i] += counts_[i];
}

void ConstraintBatches::find_sharers(std::span<const std::int32_t> counts, const StepStart& start,
                                     std::span<const SolverBody> bodies, std::span<double> sharers,
                                     std::pmr::memory_resource* memory) const {
  std::pmr::vector<DirectionSum> sums((counts.size() + lanes - 1) / lanes * lanes, DirectionSum{}, memory);
  for_each_type(batches_, [&](auto, const auto& batch) { batch.add_directions(start, bodies, sums); });
  for (std::size_t first = 0; first < sharers.size(); first += lanes) {
    const std::size_t used = std::min(lanes, sharers.size() - first);
    Vec4d number{};
    for (std::size_t l = 0; l < used; ++l) {
      number[l] = counts[first + l];
      sums[first + l].add_any(number[l] - sums[first + l].squares[3]);
    }
    const auto four = std::span(sums).subspan(first).template first<lanes>();
    const Vec4d most = min(largest_eigenvalues(four, broadcast(least_sharing) * number), number);
    for (std::size_t l = 0; l < used; ++l) sharers[first + l] = most[l];
  }
}

bool ConstraintBatches::empty() const {
  std::size_t n = 0;
  for_each_type(batches_, [&](auto, const auto& batch) { n += batch.size(); });
  return n == 0;
}

void ConstraintBatches::set_multipliers(const ConstraintMultipliers& multipliers, double share) {
  for_each_type(batches_, [&]<class C>(auto type, ConstraintBatch<C>& batch) {
    const double own = share >= 0 ? share : starts_cold<C> ? 0 : automatic_share;
    if (own == 0) return batch.set_multipliers({});
    batch.set_multipliers(std::get<type.value>(multipliers), own);
  });
}

void ConstraintBatches::get_multipliers(ConstraintMultipliers& multipliers, const ConstraintSet& set) const {
  for_each_type(batches_, [&](auto type, const auto& batch) {
    auto& list = std::get<type.value>(multipliers);
    list.resize(std::get<type.value>(set).size());
    batch.get_multipliers(list);
  });
}

void ConstraintBatches::add_impulses(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                                     double most_stiffness) {
  for_each_type(batches_, [&](auto, auto& batch) { batch.add_impulses(start, bodies, impulses, most_stiffness); });
}

double ConstraintBatches::geometric_stiffness(const StepStart& start, const ConstraintMultipliers& multipliers) {
  double most = 0;
  for_each_type(batches_, [&](auto type, auto& batch) {
    most = std::max(most, batch.geometric_stiffness(start, std::get<type.value>(multipliers)));
  });
  return most;
}

void ConstraintBatches::sweep_jacobi(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                                     const Extrapolation& beyond, SweepSums& sums) {
  for_each_type(batches_, [&](auto, auto& batch) { batch.sweep_jacobi(start, bodies, impulses, beyond, sums); });
}

std::size_t ConstraintBatches::group_count() const {
  std::size_t n = 0;
  for_each_type(batches_, [&](auto, const auto& batch) { n += batch.group_count(); });
  return n;
}

double ConstraintBatches::relax(std::size_t group, const StepStart& start, std::span<SolverBody> bodies) {
  double change = 0;
  std::size_t first = 0;
  for_each_type(batches_, [&](auto, auto& batch) {
    if (group >= first && group < first + batch.group_count()) change = batch.relax(group - first, start, bodies);
    first += batch.group_count();
  });
  return change;
}

std::array<double, ConstraintTypes::size> ConstraintBatches::residuals(const StepStart& start,
                                                                       std::span<const SolverBody> bodies) const {
  std::array<double, ConstraintTypes::size> result{};
  for_each_type(batches_, [&](auto type, const auto& batch) { result[type.value] = batch.residual(start, bodies); });
  return result;
}

void ConstraintBatches::set_form(Form form) {
  for_each_type(batches_, [&](auto, auto& batch) { batch.set_form(form); });
}

bool ConstraintBatches::moves_beyond(double share, const StepStart& start, std::span<const SolverBody> bodies) const {
  bool beyond = false;
  for_each_type(batches_, [&]<class C>(auto, const ConstraintBatch<C>& batch) {
    if constexpr (joins_edges<C>) beyond = beyond || batch.moves_beyond(share, start, bodies);
  });
  return beyond;
}

std::size_t ConstraintBatches::bytes() const {
  std::size_t n = counts_.capacity() * sizeof(counts_[0]);
  for_each_type(batches_, [&](auto, const auto& batch) { n += batch.bytes(); });
  return n;
}

}  // namespace unibody
