// The constraints of all types: as the scene makes them, keyed by ids, and as a step's solve works on them.
#pragma once

#include <array>
#include <memory_resource>
#include <string_view>

#include "constraints/constraint_batch.hpp"
#include "constraints/constraint_types.hpp"
#include "constraints/solver_settings.hpp"

namespace unibody {

struct World;

class ConstraintBatches {
 public:
  // Finds the bodies' slots and lays out the constraints: by colour for Gauss-Seidel (one by one where the order is sequential),
  // for the Jacobi solvers by runs of ids, and by colour within a run. `nobody`: slot of the body that is nobody. `colours`: of
  // each type, over all ranks.
  void build(const ConstraintSet& set, const World& world, Slot nobody, bool by_colour, const SolverSettings& settings,
             const ConstraintColours& colours);

  // Adds one for each constraint to the counts of its bodies.
  void count(std::span<std::int32_t> counts) const;

  // For each of the first `sharers.size()` bodies, all of whose constraints are here, the factor c_b by which the Jacobi solvers
  // divide steps (see direction_sum.hpp). counts: of constraints of all kinds, those of other kinds than these being taken to
  // push along any direction.
  void find_sharers(std::span<const std::int32_t> counts, const StepStart& start, std::span<const SolverBody> bodies,
                    std::span<double> sharers, std::pmr::memory_resource* memory) const;

  // Calls f(slots) with the bodies of each constraint.
  template <typename F>
  void for_each_stencil(F&& f) const {
    for_each_type(batches_, [&](auto, const auto& batch) { batch.for_each_stencil(f); });
  }

  // The same of one group.
  template <typename F>
  void for_each_stencil(std::size_t group, F&& f) const {
    std::size_t first = 0;
    for_each_type(batches_, [&](auto, const auto& batch) {
      if (group >= first && group < first + batch.group_count()) batch.for_each_stencil(group - first, f);
      first += batch.group_count();
    });
  }

  bool empty() const;
  // Starts from a share of these; a negative one: a third, or nothing of types that start cold.
  void set_multipliers(const ConstraintMultipliers& multipliers, double share);
  void get_multipliers(ConstraintMultipliers& multipliers, const ConstraintSet& set) const;
  void add_impulses(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                    double most_stiffness = HUGE_VAL);
  // Largest of the links on this rank with these multipliers: see ConstraintBatch.
  double geometric_stiffness(const StepStart& start, const ConstraintMultipliers& multipliers);
  void sweep_jacobi(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                    const Extrapolation& beyond, SweepSums& sums);

  // Groups of all types, one after the other: between two of them the shared bodies are exchanged.
  std::size_t group_count() const;
  double relax(std::size_t group, const StepStart& start, std::span<SolverBody> bodies);

  // Natural residual (m) of each type, on this rank.
  std::array<double, ConstraintTypes::size> residuals(const StepStart& start, std::span<const SolverBody> bodies) const;

  // Of all steps that follow. build() takes that of its settings.
  void set_form(Form form);

  // Whether the ends of an edge move against each other, in a step at these velocities, by more than this share of its length at
  // its start, on this rank.
  bool moves_beyond(double share, const StepStart& start, std::span<const SolverBody> bodies) const;

  std::size_t bytes() const;

 private:
  template <class C>
  void build_type(ConstraintBatch<C>& batch, const ConstraintList<C>& list, const World& world, Slot nobody, bool by_colour,
                  const SolverSettings& settings, std::int32_t colours);

  ConstraintTypes::Tuple<ConstraintBatch> batches_;
  std::vector<std::int32_t> counts_;  // of each body: its constraints
};

}  // namespace unibody
