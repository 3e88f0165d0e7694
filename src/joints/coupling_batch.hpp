// The couplings of joints of a step on this rank.
//
// A coupling's row is c = (q_0 - ratio q_1) - C, with C what q_0 - ratio q_1 was when the coupling was first seen: like a joint's
// rows, c is taken at the bodies' places and attitudes after the step, and its gradient at those at its start, so that momentum
// is kept. r = c / h; the multiplier is an impulse (N m s or N s) of the first coordinate. The gradient is that of the two
// coordinates, which act between the two bodies of each joint: a carrier that turns, as of a planetary gear, gets its share.
// An angle is known up to whole turns; the history has it with them, so that gears go on through any number of turns, in steps in
// which each turns by less than half of one. Where a joint turns by more than most_turn_of_rows in a step, less of the row's
// curve is taken into account, as of joints' own rows; what that leaves is closed by the next step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "constraints/row_batch.hpp"
#include "joints/coupling.hpp"
#include "joints/joint_batch.hpp"
#include "joints/joint_side.hpp"

namespace unibody {

// The row's four ends are of the first joint, then of the second; their gradients have the ratio in them.
struct CouplingRow : Row<4, JointSide> {
  std::array<std::uint8_t, 2> types{};  // of the coordinates
  std::array<double, 2> factor{};       // 1 and -ratio
  std::array<double, 2> coordinate{};   // rad or m, at the start of the step; from start_from() on with whole turns
  double constant = 0;                  // C
};

class CouplingBatch : public RowBatch<CouplingBatch, CouplingRow> {
 public:
  // Of each coupling that is here: its impulse; the two coordinates at the start of the step, whole turns included; C; and 1 once
  // they are known.
  using History = std::vector<std::array<double, 5>>;
  static constexpr std::string_view name = "couplings";
  static constexpr bool stencils_last = true;
  static constexpr std::size_t remembered_impulses = 1;

  template <class F>
  static void for_each_element(const Elements& elements, F&& f) {
    if (elements.joints == nullptr || elements.joints->couplings.empty()) return;
    for (const std::int64_t number : *elements.joints->couplings_here)
      f(Key{number}, std::span<const Id>(elements.joints->couplings[static_cast<std::size_t>(number)].ids));
  }

  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for_each_tie(context, [&](std::int32_t colour, std::span<const Slot> bodies) { f(colour, bodies); });
  }
  static std::int32_t colours_of(const BuildContext& context);
  static std::optional<CouplingRow> row_of(const BuildContext& context, const Key& key, std::size_t number);

  void start_from(const History& history, const WarmStart& warm);
  void remember(History& history, double) const;

 private:
  friend class RowBatch<CouplingBatch, CouplingRow>;
  static void for_each_tie(const BuildContext& context, const std::function<void(std::int32_t, std::span<const Slot>)>& f);
  double open_after(const CouplingRow& row, std::span<const SolverBody> bodies, bool as_it_is) const;  // c
};

}  // namespace unibody
