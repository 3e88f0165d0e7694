// How ConstraintBatch lays out its constraints, and what a step knows of them before its first pass. Included where its types are
// made, in constraint_batch.cpp, alone.
#pragma once

#include "constraints/constraint_batch.hpp"

namespace unibody {

template <ConstraintType C>
void ConstraintBatch<C>::lay_out(std::span<const Constraint<C>> constraints, std::span<const std::uint32_t> order,
                                 std::span<const std::uint32_t> groups, Slot nobody, Form form,
                                 const std::function<std::array<Slot, stencil>(std::uint32_t)>& slots,
                                 const std::function<bool(std::uint32_t)>& counted) {
  blocks_.clear(), softness_.clear(), lambda_.clear(), y_.clear(), counted_.clear(), group_end_.clear(), order_.clear();
  form_ = form;
  bool soft = false;
  for (const Constraint<C>& c : constraints)
    soft |= c.damping != 0 || std::any_of(c.compliance.begin(), c.compliance.end(), [](double e) { return e != 0; });
  std::size_t begin = 0;
  for (const std::size_t end : groups) {
    for (; begin < end; begin += std::min(lanes, end - begin)) {
      const std::size_t used = std::min(lanes, end - begin);
      Block& block = blocks_.emplace_back();
      Softness softness{};
      std::uint8_t counts = 0;
      for (std::size_t l = 0; l < lanes; ++l) {
        // An empty lane has the parameters of a full one, but is stiff, so that it never moves: nothing may show how many there
        // are.
        const std::uint32_t i = order[begin + std::min(l, used - 1)];
        for (std::size_t p = 0; p < parameter_count; ++p) block.parameters[p][l] = constraints[i].parameters[p];
        for (std::size_t k = 0; k < rows && l < used; ++k) softness.compliance[k][l] = constraints[i].compliance[k];
        if (l < used) softness.damping[l] = constraints[i].damping;
        const std::array<Slot, stencil> ends = slots(i);
        for (std::size_t e = 0; e < stencil; ++e) block.slot[e][l] = l < used ? ends[e] : nobody;
        if (l < used && counted(i)) counts |= static_cast<std::uint8_t>(1u << l);
        order_.push_back(l < used ? static_cast<std::int32_t>(i) : -1);
      }
      if (soft) softness_.push_back(softness);
      counted_.push_back(counts);
    }
    group_end_.push_back(static_cast<std::uint32_t>(blocks_.size()));
  }
  lambda_.assign(blocks_.size(), Solution{});
  has_inverses_ = false;
  applied_.assign(form == Form::total ? blocks_.size() : 0, Impulses{});
}

template <ConstraintType C>
void ConstraintBatch<C>::set_multipliers(std::span<const Multipliers> multipliers, double share) {
  if (multipliers.empty())
    lambda_.assign(blocks_.size(), Solution{});
  else
    for (std::size_t i = 0; i < order_.size(); ++i)
      for (std::size_t k = 0; k < rows; ++k)
        lambda_[i / lanes][k][i % lanes] = order_[i] < 0 ? 0 : share * multipliers[static_cast<std::size_t>(order_[i])][k];
  y_.clear();
  applied_.assign(form_ == Form::total ? blocks_.size() : 0, Impulses{});
}

template <ConstraintType C>
void ConstraintBatch<C>::get_multipliers(std::span<Multipliers> multipliers) const {
  for (std::size_t i = 0; i < order_.size(); ++i)
    if (order_[i] >= 0)
      for (std::size_t k = 0; k < rows; ++k)
        multipliers[static_cast<std::size_t>(order_[i])][k] = lambda_[i / lanes][k][i % lanes];
}

// Sets the multipliers from which the step starts. Types that start cold take nothing of a warm start whose share is left open.
template <ConstraintType C>
void ConstraintBatch<C>::start_from(const History& history, const WarmStart& warm) {
  const double own = warm.setting >= 0 ? warm.setting : starts_cold<C> ? 0 : warm.share;
  set_multipliers(own == 0 ? std::span<const Multipliers>() : history, own);
}

template <ConstraintType C>
void ConstraintBatch<C>::remember(History& history, double) const {
  get_multipliers(history);
}

// 1/P of rows whose gradients have length 1: it changes with the bodies' weights only, from step to step.
template <ConstraintType C>
void ConstraintBatch<C>::take_inverses(const StepStart& start) {
  if (!has_unit_gradients<C> || has_inverses_) return;
  has_inverses_ = true;
  inverses_.resize(blocks_.size());
  const Vec4d step = broadcast(start.step);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Vec4d P = broadcast(0);
    for (const auto& slots : blocks_[b].slot)
      for (std::size_t l = 0; l < lanes; ++l) P[l] += start.places[slots[l]][3];
    if (!softness_.empty()) P += softness_[b].compliance[0] / (step * (step + softness_[b].damping));
    inverses_[b] = inverse_or_zero(P);
  }
}

// A constraint of one row pushes along its gradient; of one of more rows it is not asked which directions they leave out.
template <ConstraintType C>
void ConstraintBatch<C>::add_directions(const StepStart& start, std::span<const SolverBody> bodies,
                                        std::span<DirectionSum> sums) const {
  if constexpr (is_link<C>) return add_lines(start, bodies, sums);
  for (const Block& block : blocks_) {
    if constexpr (rows > 1) {
      for (const auto& slots : block.slot)
        for (const Slot s : slots) sums[s].add_any(1);
    } else {
      Rows<stencil, rows> at;
      C::evaluate(block.parameters, gather<Law::linear, false>(block, start, bodies).x, at);
      std::array<Directions, stencil> directions;
      for (std::size_t e = 0; e < stencil; ++e)
        directions[e] = Directions(at.gradient[0][e], inverse_or_zero(dot(at.gradient[0][e], at.gradient[0][e])));
      // Constraint after constraint, as in add(): for each body in their order, whatever block they are in.
      for (std::size_t l = 0; l < lanes; ++l)
        for (std::size_t e = 0; e < stencil; ++e) directions[e].add_to(sums[block.slot[e][l]], l);
    }
  }
}

// Adds links to their bodies' sums of directions: both ends are pushed along one line, or along z where the two coincide. It
// takes two passes, as sweep() does.
template <ConstraintType C>
void ConstraintBatch<C>::add_lines(const StepStart& start, std::span<const SolverBody> bodies,
                                   std::span<DirectionSum> sums) const {
  std::array<Vec3x4, ahead> d;
  std::array<Vec4d, ahead> over_square;
  for (std::size_t first = 0; first < blocks_.size(); first += ahead) {
    const std::size_t count = std::min(ahead, blocks_.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      d[i] = gather<Law::linear, false>(blocks_[first + i], start, bodies).x[0];
      const Vec4d square = dot(d[i], d[i]), one = broadcast(1);
      const Mask4 apart = square > broadcast(0);
      d[i].z = select(apart, d[i].z, one);
      over_square[i] = one / select(apart, square, one);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Directions directions(d[i], over_square[i]);
      for (std::size_t l = 0; l < lanes; ++l)
        for (const auto& slots : blocks_[first + i].slot) directions.add_to(sums[slots[l]], l);
    }
  }
}

template <ConstraintType C>
std::size_t ConstraintBatch<C>::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return of(blocks_) + of(softness_) + of(lambda_) + of(y_) + of(inverses_) + of(counted_) + of(group_end_) + of(order_) +
         of(applied_);
}

}  // namespace unibody
