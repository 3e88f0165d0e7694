#include "step/worst_constraint.hpp"

#include <algorithm>

#include "core/checked.hpp"
#include "core/largest.hpp"
#include "solve/solver.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

std::array<Id, 4> ids_of(const World& world, std::span<const Slot> slots) {
  std::array<Id, 4> ids{WorstConstraint::none, WorstConstraint::none, WorstConstraint::none, WorstConstraint::none};
  for (std::size_t e = 0; e < slots.size(); ++e)
    if (slots[e] >= 0 && static_cast<std::size_t>(slots[e]) < world.size()) ids[e] = world.id[static_cast<std::size_t>(slots[e])];
  std::ranges::sort(ids);
  return ids;
}

std::string_view kind_at(Id place) {
  std::string_view kind;
  for_each_batch_type([&]<class B>(auto k, std::type_identity<B>) {
    if (static_cast<Id>(k) == place) kind = B::name;
  });
  return kind;
}

}  // namespace

WorstConstraint worst_constraint(const System& system, const World& world) {
  WorstConstraint worst;
  for_each_acting(system, [&]<class B>(auto place, const B& batch) {
    batch.for_each_residual(system, [&](double residual, std::span<const Slot> slots) {
      if (residual < worst.residual) return;
      const WorstConstraint one{residual, B::name, static_cast<Id>(place), ids_of(world, slots)};
      if (one.precedes(worst)) worst = one;
    });
  });
  return worst;
}

WorstConstraint worst_over_ranks(MPI_Comm comm, const WorstConstraint& here) {
  WorstConstraint worst;
  worst.residual = largest_of_ranks(comm, here.residual);
  bool is_first = or_infinity(here.residual) == worst.residual;
  const auto least = [&](Id mine) {
    Id id = is_first ? mine : WorstConstraint::none;
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &id, 1, MPI_INT64_T, MPI_MIN, comm));
    is_first = is_first && id == mine;
    return id;
  };
  worst.place = least(here.place);
  for (std::size_t k = 0; k < worst.bodies.size(); ++k) worst.bodies[k] = least(here.bodies[k]);
  worst.kind = kind_at(worst.place);
  return worst;
}

}  // namespace unibody
