#include "solve/centre_constraints.hpp"

#include <algorithm>

namespace unibody {

void find_sharers(const Batches& batches, const SolveState& state, std::span<double> sharers, std::pmr::memory_resource* memory) {
  const auto& counts = state.counts;
  std::pmr::vector<DirectionSum> sums((counts.size() + lanes - 1) / lanes * lanes, DirectionSum{}, memory);
  for_each_constraint_batch(batches, [&](auto, const auto& batch) { batch.add_directions(state.start(), state.bodies, sums); });
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

double geometric_stiffness(Batches& batches, const SolveState& state, const BatchHistories& history) {
  double most = 0;
  for_each_constraint_batch(batches, [&]<class C>(auto, ConstraintBatch<C>& batch) {
    most = std::max(most, batch.geometric_stiffness(state.start(), history.of<ConstraintBatch<C>>()));
  });
  return most;
}

void set_form(Batches& batches, Form form, bool of_solids_alone) {
  for_each_constraint_batch(batches, [&]<class C>(auto, ConstraintBatch<C>& batch) {
    batch.set_form(of_solids_alone && !fills_space<C> ? Form::incremental : form);
  });
}

bool moves_beyond(const Batches& batches, double share, const SolveState& state) {
  bool beyond = false;
  for_each_constraint_batch(batches, [&]<class C>(auto, const ConstraintBatch<C>& batch) {
    if constexpr (joins_edges<C>)
      beyond = beyond || (batch.form() == Form::total && batch.moves_beyond(share, state.start(), state.bodies));
  });
  return beyond;
}

}  // namespace unibody
