// Which pairs of bodies have a bridge of liquid between them. What a bridge pulls by is known before a step is solved
// (step/liquid.hpp), so that this batch has no rows. It keeps the bridges where the histories of batches are kept: through
// migration, checkpoints and changes of bodies.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "constraints/batch.hpp"
#include "constraints/pair_history.hpp"

namespace unibody {

class LiquidBatch : public BatchDefaults {
 public:
  static constexpr std::string_view name = "liquid_bridges";
  static constexpr std::string_view history_columns = "volume (m^3)";
  using History = PairHistory<1>;

  template <class F>
  static void for_each_stencil(const BuildContext&, F&&) {}
  static void count(const BuildContext&, std::span<std::int32_t>) {}
  void build(const BuildContext&) {}
  void sweep(SolveState&, const Extrapolation&, SweepSums&) {}
  std::size_t colours() const { return 0; }
  double relax(std::size_t, bool, SolveState&) { return 0; }
  template <class F>
  void for_each_unknown(F&&) {}
  double residual(const SolveState&) const { return 0; }
  void for_each_residual(const SolveState&, const ResidualVisitor&) const {}
  void start_from(const History&, const WarmStart&) {}
  void add_impulses(SolveState&, const WarmStart&, double) {}
  void remember(History&, double) const {}
  std::size_t bytes() const { return 0; }
};

}  // namespace unibody
