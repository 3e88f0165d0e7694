// The passes of ConstraintBatch. Included where its types are made, in constraint_batch.cpp, alone.
#pragma once

#include "constraints/constraint_batch.hpp"
#include "constraints/constraint_rows.hpp"

namespace unibody {

// A link as long as 0 has no direction to keep, and starts from nothing.
template <ConstraintType C>
inline void ConstraintBatch<C>::bound_stiffness(std::size_t b, const Rows<stencil, rows>& at, double most, double step) {
  if constexpr (is_link<C>) {
    const Vec4d length = at.value[0] + blocks_[b].parameters[0];
    const Vec4d bound = length * inverses_[b] * broadcast(most / step);
    lambda_[b][0] = max(min(lambda_[b][0], bound), -bound);
  }
}

// In two passes, as in sweep().
template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law, bool total>
void ConstraintBatch<C>::add_multipliers(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                                         double most_stiffness) {
  std::array<Rows<stencil, rows>, ahead> at;
  const bool bounds = is_link<C> && most_stiffness < HUGE_VAL;
  for (std::size_t first = 0; first < blocks_.size(); first += ahead) {
    const std::size_t count = std::min(ahead, blocks_.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const Block& block = blocks_[first + i];
      Rows<stencil, rows> now;
      C::evaluate(block.parameters, gather<law, false>(block, start, bodies).x, now);
      if (bounds) bound_stiffness(first + i, now, most_stiffness, start.step);
      keep_gradients<total>(now, at[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Solution& lambda = lambda_[first + i];
      add(blocks_[first + i], take_impulses<total>(first + i, at[i], lambda, lambda, broadcast(1)), impulses);
    }
  }
}

template <ConstraintType C>
void ConstraintBatch<C>::add_impulses(SolveState& state, const WarmStart& warm, double most_stiffness) {
  if (warm.share > 0 && !blocks_.empty()) add_impulses(state.start(), state.bodies, state.impulses, most_stiffness);
}

template <ConstraintType C>
void ConstraintBatch<C>::add_impulses(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                                      double most_stiffness) {
  if (is_link<C> && most_stiffness < HUGE_VAL) take_inverses(start);
  if (form_ == Form::total)
    start.is_linear() ? add_multipliers<Law::linear, true>(start, bodies, impulses, most_stiffness)
                      : add_multipliers<Law::stiff, true>(start, bodies, impulses, most_stiffness);
  else
    start.is_linear() ? add_multipliers<Law::linear, false>(start, bodies, impulses, most_stiffness)
                      : add_multipliers<Law::stiff, false>(start, bodies, impulses, most_stiffness);
}

// D lambda along the directions at the bodies' present places, on the first ends.
template <ConstraintType C>
template <std::size_t ends>
typename ConstraintBatch<C>::Impulses ConstraintBatch<C>::present_impulses(std::size_t b, const StepStart& start,
                                                                           std::span<const SolverBody> bodies) const {
  const Block& block = blocks_[b];
  Rows<stencil, rows> at;
  C::evaluate(
      block.parameters,
      start.is_linear() ? gather<Law::linear, false>(block, start, bodies).x : gather<Law::stiff, false>(block, start, bodies).x,
      at);
  return times<ends>(at, y_.empty() ? lambda_[b] : y_[b]);
}

template <ConstraintType C>
void ConstraintBatch<C>::add_applied(const SolveState& state, std::span<Vec4d> impulses) const {
  constexpr std::size_t ends = std::tuple_size_v<ImpulseRows>;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Impulses all = form_ == Form::total ? applied_[b] : present_impulses<ends>(b, state.start(), state.bodies);
    add(blocks_[b], in_rows<ends>(all), impulses);
  }
}

template <ConstraintType C>
void ConstraintBatch<C>::take_total_form(const SolveState& state) {
  if (form_ == Form::total) return;
  form_ = Form::total, eases_ = true;
  applied_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) applied_[b] = present_impulses<stencil>(b, state.start(), state.bodies);
}

// By how much the impulses that an end misses would change its velocity (m/s), the most: across the rows too, which see only what
// is along them.
template <ConstraintType C>
Vec4d ConstraintBatch<C>::missing_speed(std::size_t b, const Impulses& missing, std::span<const SolverBody> bodies) const {
  Vec4d most = broadcast(0);
  for (std::size_t e = 0; e < stencil; ++e) {
    Vec4d inverse_mass;
    for (std::size_t l = 0; l < lanes; ++l)
      inverse_mass[l] = bodies[static_cast<std::size_t>(blocks_[b].slot[e][l])].inverse_mass;
    most = max(most, inverse_mass * sqrt(dot(missing[e], missing[e])));
  }
  return most;
}

template <ConstraintType C>
double ConstraintBatch<C>::geometric_stiffness(const StepStart& start, std::span<const Multipliers> multipliers) {
  double most = 0;
  if constexpr (is_link<C>) {
    if (multipliers.empty()) return 0;
    take_inverses(start);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const Vec4d per_impulse = start.step / (blocks_[b].parameters[0] * inverses_[b]);
      for (std::size_t l = 0; l < lanes; ++l)
        if (const std::int32_t i = order_[lanes * b + l]; i >= 0)
          most = std::max(most, std::abs(multipliers[static_cast<std::size_t>(i)][0]) * per_impulse[l]);
    }
  }
  return most;
}

// In two passes over a few blocks at a time: what a block asks of the bodies first, what it does to them after. So the roots and
// divisions of one block are under way while the next is read.
template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law, bool total>
void ConstraintBatch<C>::sweep_as(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                                  const Extrapolation& extrapolation, SweepSums& sums) {
  std::array<Rows<stencil, rows>, ahead> at;
  std::array<Solution, ahead> r, step;
  std::array<Vec4d, ahead> share;
  const double h = start.step;  // a copy: no store of the loop can change it
  const Vec4d over_step = broadcast(1 / h);
  const Update<Vec4d> update = update_of_four(extrapolation);
  SweepTotals totals(sums.unit);
  for (std::size_t first = 0; first < blocks_.size(); first += ahead) {
    const std::size_t count = std::min(ahead, blocks_.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t b = first + i;
      const Ends ends = gather<law, true>(blocks_[b], start, bodies);
      Rows<stencil, rows> now;
      C::evaluate(blocks_[b].parameters, ends.x, now);
      r[i] = residual_of<law>(b, ends, now, y_[b], start, over_step);
      if constexpr (total) share[i] = turned_share(b, now, ends, y_[b], h), add_misfit(b, now, ends, y_[b], share[i], r[i]);
      step[i] = solve_block<law != Law::stiff>(b, now, ends, r[i], h);
      keep_gradients<total>(now, at[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Solution moved = extrapolate<law>(first + i, r[i], step[i], update, over_step, totals);
      add(blocks_[first + i], take_impulses<total>(first + i, at[i], moved, y_[first + i], share[i]), impulses);
    }
  }
  totals.add_to(sums, h);
}

// Returns the change of y.
template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law>
inline typename ConstraintBatch<C>::Solution ConstraintBatch<C>::extrapolate(std::size_t b, const Solution& r, Solution step,
                                                                             const Update<Vec4d>& update, Vec4d over_step,
                                                                             SweepTotals& totals) {
  Solution moved;
  const Vec4d part = part_taken(y_[b], step);  // of |r|, what the step takes away
  SweepTerms<Vec4d> terms = totals.start();
  for (std::size_t k = 0; k < rows; ++k) {
    Vec4d resisted = r[k];  // what the step takes away, with its sign
    if constexpr (is_unilateral<C>)
      resisted *= part;
    else
      resisted = select(step[k] != broadcast(0), r[k], broadcast(0));
    moved[k] = update.advance(lambda_[b][k], y_[b][k], y_[b][k] + step[k], step[k], r[k], -(resisted * step[k]),
                              with_damping<law>(b, abs(resisted), over_step), terms);
  }
  if (counted_[b] == all_lanes)
    totals.close(terms);
  else
    totals.close(terms, lanes_of(counted_[b]));
  return moved;
}

template <ConstraintType C>
void ConstraintBatch<C>::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  sweep(state.start(), state.bodies, state.impulses, extrapolation, sums);
}

template <ConstraintType C>
void ConstraintBatch<C>::sweep(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                               const Extrapolation& extrapolation, SweepSums& sums) {
  if (blocks_.empty()) return;
  if (y_.empty()) y_ = lambda_;
  take_inverses(start);
  const bool soft = !softness_.empty(), total = form_ == Form::total;
  if (start.is_linear())
    sweep_as<Law::linear, false>(start, bodies, impulses, extrapolation, sums);
  else if (total)
    soft ? sweep_as<Law::soft, true>(start, bodies, impulses, extrapolation, sums)
         : sweep_as<Law::stiff, true>(start, bodies, impulses, extrapolation, sums);
  else
    soft ? sweep_as<Law::soft, false>(start, bodies, impulses, extrapolation, sums)
         : sweep_as<Law::stiff, false>(start, bodies, impulses, extrapolation, sums);
}

// In two passes, as in sweep(): the blocks of a group have no moving body in common.
template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law, bool total>
double ConstraintBatch<C>::relax_group(std::size_t group, const StepStart& start, std::span<SolverBody> bodies) {
  std::array<Rows<stencil, rows>, ahead> at;
  std::array<Solution, ahead> step;
  std::array<Vec4d, ahead> share;
  const double h = start.step;  // a copy: no store of the loop can change it
  const Vec4d over_step = broadcast(1 / h);
  Vec4d change = broadcast(0);
  for (std::size_t first = begin_of(group); first < group_end_[group]; first += ahead) {
    const std::size_t count = std::min<std::size_t>(ahead, group_end_[group] - first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t b = first + i;
      const Ends ends = gather<law, false>(blocks_[b], start, bodies);
      C::evaluate(blocks_[b].parameters, ends.x, at[i]);
      Solution r = residual_of<law>(b, ends, at[i], lambda_[b], start, over_step);
      if constexpr (total)
        share[i] = turned_share(b, at[i], ends, lambda_[b], h), add_misfit(b, at[i], ends, lambda_[b], share[i], r);
      step[i] = solve_block<law != Law::stiff>(b, at[i], ends, r, h);
      const Vec4d part = part_taken(lambda_[b], step[i]);
      for (std::size_t k = 0; k < rows; ++k) {
        lambda_[b][k] += step[i][k];
        const Vec4d taken = is_unilateral<C> ? r[k] * part : select(step[i][k] != broadcast(0), r[k], broadcast(0));
        change = max(change, with_damping<law>(b, abs(taken), over_step));
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t b = first + i;
      const auto impulse = take_impulses<total>(b, at[i], step[i], lambda_[b], share[i]);
      for (std::size_t e = 0; e < stencil; ++e)
        for (std::size_t l = 0; l < lanes; ++l) {
          const Slot slot = blocks_[b].slot[e][l];
          const Vec4d moved = impulse[is_pair ? 0 : e][l] * broadcast(start.places[slot][3]);
          auto& row = *reinterpret_cast<Vec4dView*>(&bodies[slot]);
          row = is_pair && e == 1 ? row - moved : row + moved;
        }
    }
  }
  return h * horizontal_max(change);
}

template <ConstraintType C>
double ConstraintBatch<C>::relax(std::size_t colour, bool, SolveState& state) {
  return relax(colour, state.start(), state.bodies);
}

template <ConstraintType C>
double ConstraintBatch<C>::relax(std::size_t group, const StepStart& start, std::span<SolverBody> bodies) {
  if (group >= group_end_.size()) return 0;
  const bool soft = !softness_.empty();
  take_inverses(start);
  if (start.is_linear()) return relax_group<Law::linear, false>(group, start, bodies);
  if (form_ == Form::total)
    return soft ? relax_group<Law::soft, true>(group, start, bodies) : relax_group<Law::stiff, true>(group, start, bodies);
  return soft ? relax_group<Law::soft, false>(group, start, bodies) : relax_group<Law::stiff, false>(group, start, bodies);
}

template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law>
double ConstraintBatch<C>::residual_by(const StepStart& start, std::span<const SolverBody> bodies,
                                       const BlockVisitor* visit) const {
  const double h = start.step;
  const Vec4d over_step = broadcast(1 / h);
  const bool has_inverses = has_unit_gradients<C> && has_inverses_;
  Vec4d worst = broadcast(0);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Ends ends = gather<law, false>(blocks_[b], start, bodies);
    Rows<stencil, rows> at;
    C::evaluate(blocks_[b].parameters, ends.x, at);
    Solution r = residual_of<law>(b, ends, at, lambda_[b], start, over_step);
    Vec4d part = broadcast(1);
    Vec4d of_block = broadcast(0);
    if (form_ == Form::total) {
      const Impulses missing = add_misfit(b, at, ends, lambda_[b], broadcast(1), r);
      if (eases_) of_block = missing_speed(b, missing, bodies);
    }
    if constexpr (is_unilateral<C>) {
      Solution step = solve_block<false>(b, at, ends, r, h);
      part = part_taken(lambda_[b], step);
    }
    Vec4d moves = broadcast(0);  // two that cannot move leave a residual that nobody can solve
    if (has_inverses)
      moves = inverses_[b];
    else
      for (const Vec4d m : ends.weight) moves += m;
    for (const Vec4d rk : r)
      of_block = max(of_block, select(moves > broadcast(0), with_damping<law>(b, abs(rk * part), over_step), broadcast(0)));
    if (visit != nullptr) (*visit)(b, of_block);
    worst = max(worst, of_block);
  }
  return start.step * horizontal_max(worst);
}

template <ConstraintType C>
double ConstraintBatch<C>::residual(const StepStart& start, std::span<const SolverBody> bodies, const BlockVisitor* visit) const {
  if (start.is_linear()) return residual_by<Law::linear>(start, bodies, visit);
  return softness_.empty() ? residual_by<Law::stiff>(start, bodies, visit) : residual_by<Law::soft>(start, bodies, visit);
}

template <ConstraintType C>
void ConstraintBatch<C>::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  const BlockVisitor of_lanes = [&](std::size_t b, const Vec4d& residual) {
    for (std::size_t l = 0; l < lanes; ++l) {
      if (order_[b * lanes + l] < 0) continue;
      std::array<Slot, stencil> ends;
      for (std::size_t e = 0; e < stencil; ++e) ends[e] = blocks_[b].slot[e][l];
      visit(state.step * residual[l], ends);
    }
  };
  residual(state.start(), state.bodies, &of_lanes);
}

template <ConstraintType C>
bool ConstraintBatch<C>::moves_beyond(double share, const StepStart& start, std::span<const SolverBody> bodies) const {
  const auto square = [](const Vec4d& d) { return d[0] * d[0] + d[1] * d[1] + d[2] * d[2]; };
  const auto velocity = [&](Slot s) { return *reinterpret_cast<const Vec4dView*>(&bodies[s]); };
  const double longest = share * share / (start.step * start.step);  // of the squares
  for (const Block& block : blocks_)
    for (std::size_t l = 0; l < lanes; ++l)
      for (std::size_t e = 1; e < stencil; ++e)
        for (std::size_t f = 0; f < e; ++f) {
          const Slot s = block.slot[e][l], t = block.slot[f][l];
          if (!(square(velocity(s) - velocity(t)) <= longest * square(start.places[s] - start.places[t]))) return true;
        }
  return false;
}

}  // namespace unibody
