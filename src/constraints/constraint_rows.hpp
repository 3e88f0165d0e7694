// What the passes of ConstraintBatch are made of: the bodies of a block, its rows' residuals, a step of its multipliers, and what
// that does to the bodies. Included by constraint_kernels.hpp alone.
#pragma once

#include "constraints/constraint_batch.hpp"

namespace unibody {

namespace constraint_kernels {

// Solves A d = b for symmetric positive semidefinite A (lower triangle), four at once, by L D L^T without pivots; a row without
// mass or compliance gives d = 0.
template <std::size_t n>
[[gnu::always_inline]] inline std::array<Vec4d, n> solve_symmetric(std::array<std::array<Vec4d, n>, n> a,
                                                                   std::array<Vec4d, n> b) {
  if constexpr (n == 1) {
    return {b[0] * inverse_or_zero(a[0][0])};
  } else {
    std::array<Vec4d, n> inverse;
    for (std::size_t j = 0; j < n; ++j) {
      inverse[j] = inverse_or_zero(a[j][j]);
      for (std::size_t i = j + 1; i < n; ++i) {
        const Vec4d l = a[i][j] * inverse[j];
        for (std::size_t k = j + 1; k <= i; ++k) a[i][k] -= l * a[k][j];
        b[i] -= l * b[j];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
      b[i] = b[i] * inverse[i];
    }
    return b;
  }
}

}  // namespace constraint_kernels

// A body's record is read as a row of four, x = x_l + h v in all but its fourth component, and rows are turned into lanes. A
// Jacobi sweep, which moves no body, finds the rows ready (`moved`). What two bodies do to each other depends on the difference
// of their places alone: one row to turn, and the second body stands at the origin.
template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law, bool moved>
inline typename ConstraintBatch<C>::Ends ConstraintBatch<C>::gather(const Block& block, const StepStart& start,
                                                                    std::span<const SolverBody> bodies) {
  Ends ends{};
  const double ahead = law == Law::linear ? 0 : start.step;
  const Vec4d step{ahead, ahead, ahead, 0};
  const auto velocity = [&](Slot s) { return *reinterpret_cast<const Vec4dView*>(&bodies[s]); };  // and 1/m
  const auto place = [&](Slot s) { return moved ? start.moved_places[s] : start.places[s] + step * velocity(s); };
  const auto turned = [](auto&& row_of_lane) {
    Vec4d x = row_of_lane(0), y = row_of_lane(1), z = row_of_lane(2), w = row_of_lane(3);
    transpose(x, y, z, w);
    return std::pair(Vec3x4{x, y, z}, w);
  };
  for (std::size_t e = 0; e < stencil; ++e) {
    const auto& s = block.slot[e];
    if constexpr (is_pair) {
      for (std::size_t l = 0; l < lanes; ++l) ends.weight[e][l] = start.places[s[l]][3];
    } else {
      std::tie(ends.x[e], ends.weight[e]) = turned([&](std::size_t l) { return place(s[l]); });
      if constexpr (law != Law::stiff) ends.u[e] = turned([&](std::size_t l) { return velocity(s[l]); }).first;
    }
  }
  if constexpr (is_pair) {
    const auto &s = block.slot[0], &t = block.slot[1];
    ends.x[0] = turned([&](std::size_t l) { return place(s[l]) - place(t[l]); }).first;
    if constexpr (law != Law::stiff) ends.u[0] = turned([&](std::size_t l) { return velocity(s[l]) - velocity(t[l]); }).first;
  }
  return ends;
}

template <ConstraintType C>
template <typename ConstraintBatch<C>::Law law>
inline typename ConstraintBatch<C>::Solution ConstraintBatch<C>::residual_of(std::size_t b, const Ends& ends,
                                                                             const Rows<stencil, rows>& at,
                                                                             const Solution& lambda, const StepStart& start,
                                                                             Vec4d over_step) const {
  // Both ways give the same bits for a stiff constraint: which of them is taken depends on what else this rank has.
  Solution r;
  const double step = start.step;
  for (std::size_t k = 0; k < rows; ++k) {
    if constexpr (law == Law::linear) {
      const Softness s = softness_of(b);
      Vec4d rate = broadcast(0);
      for (std::size_t e = 0; e < stencil; ++e) rate += dot(at.gradient[k][e], ends.u[e]);
      Mask4 has_law = (s.compliance[k] > broadcast(0)) | (s.damping > broadcast(0));
      if (is_unilateral<C>) has_law = has_law | (at.value[k] >= broadcast(0));  // open: it may close within the step
      const Vec4d value = at.value[k] * select(has_law, broadcast(1), broadcast(start.stabilisation));
      const Vec4d whole = broadcast(step) + s.damping;
      r[k] = (value + s.compliance[k] * lambda[k] * over_step + whole * rate) * (broadcast(1) / whole);
    } else if constexpr (law == Law::soft) {
      const Softness& s = softness_[b];
      Vec4d rate = broadcast(0);
      for (std::size_t e = 0; e < stencil; ++e) rate += dot(at.gradient[k][e], ends.u[e]);
      r[k] = (at.value[k] + s.compliance[k] * lambda[k] * over_step + s.damping * rate) *
             (broadcast(1) / (broadcast(step) + s.damping));
    } else {
      r[k] = at.value[k] * over_step;
    }
  }
  return r;
}

// The step -P^-1 r, P = sum over the bodies of weight D^T D, plus E / (h (h + rho)): with weight c_b / m_b it bounds the whole
// system from above, with 1 / m_b it is the constraint's own block.
template <ConstraintType C>
template <bool soft>
inline typename ConstraintBatch<C>::Solution ConstraintBatch<C>::solve_block(std::size_t b, const Rows<stencil, rows>& at,
                                                                             const Ends& ends, const Solution& r,
                                                                             double step) const {
  if constexpr (has_unit_gradients<C>) return {-r[0] * inverses_[b]};
  std::array<std::array<Vec4d, rows>, rows> P;
  Solution right;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto of_end = [&](std::size_t e) { return ends.weight[e] * dot(at.gradient[i][e], at.gradient[j][e]); };
      P[i][j] = of_end(0);
      for (std::size_t e = 1; e < stencil; ++e) P[i][j] += of_end(e);
    }
    if constexpr (soft) {
      const Softness s = softness_of(b);
      P[i][i] += s.compliance[i] / (broadcast(step) * (broadcast(step) + s.damping));
    }
    right[i] = -r[i];
  }
  return constraint_kernels::solve_symmetric<rows>(P, right);
}

// D lambda, of the first `ends` bodies.
template <ConstraintType C>
template <std::size_t ends>
inline typename ConstraintBatch<C>::Impulses ConstraintBatch<C>::times(const Rows<stencil, rows>& at, const Solution& lambda) {
  Impulses impulse;
  for (std::size_t e = 0; e < ends; ++e) {
    impulse[e] = at.gradient[0][e] * lambda[0];
    for (std::size_t k = 1; k < rows; ++k) impulse[e] = impulse[e] + at.gradient[k][e] * lambda[k];
  }
  return impulse;
}

// The share s of D lambda - p that a pass takes over, 1 / (1 + g): what moves an end across a row turns D, and D lambda with it,
// as if sum_k h |lambda_k| |d2c_k/dx2| were a stiffness, here bounded by each row's D^T W D over the length that makes it a
// distance. All of it at once, each end would be thrown g times as far to the other side.
template <ConstraintType C>
inline Vec4d ConstraintBatch<C>::turned_share(std::size_t b, const Rows<stencil, rows>& at, const Ends& ends,
                                              const Solution& lambda, double step) const {
  if (!eases_) return broadcast(1);
  constexpr double curvature = rows == 1 && !is_link<C> ? 2 : 1;  // of angles and areas; strains' is 1 (Green)
  Vec4d pull = broadcast(0);
  for (std::size_t k = 0; k < rows; ++k) {
    Vec4d moved = broadcast(0);
    for (std::size_t e = 0; e < stencil; ++e)
      moved += has_unit_gradients<C> ? ends.weight[e] : ends.weight[e] * dot(at.gradient[k][e], at.gradient[k][e]);
    pull += moved * abs(lambda[k]);
  }
  const Vec4d last = blocks_[b].parameters[parameter_count - 1], length = is_link<C> ? at.value[0] + last : last;
  return length * inverse_or_zero(length + broadcast(curvature * step) * pull);
}

// r += s D^T W (D lambda - p): what the rows will see of the impulses that are turned in this pass. Returns D lambda - p.
template <ConstraintType C>
inline typename ConstraintBatch<C>::Impulses ConstraintBatch<C>::add_misfit(std::size_t b, const Rows<stencil, rows>& at,
                                                                            const Ends& ends, const Solution& lambda, Vec4d share,
                                                                            Solution& r) const {
  Impulses missing = times(at, lambda);
  for (std::size_t e = 0; e < stencil; ++e) {
    missing[e] = missing[e] - applied_[b][e];
    const Vec3x4 seen = missing[e] * (share * ends.weight[e]);
    for (std::size_t k = 0; k < rows; ++k) r[k] += dot(at.gradient[k][e], seen);
  }
  return missing;
}

// Shortens the step of a unilateral row so that its multiplier does not become negative; returns which part of it is left.
template <ConstraintType C>
inline Vec4d ConstraintBatch<C>::part_taken(const Solution& lambda, Solution& step) {
  if constexpr (!is_unilateral<C>) return broadcast(1);
  const Vec4d wanted = step[0], zero = broadcast(0);
  step[0] = max(step[0], zero - lambda[0]);
  return select(wanted != zero, step[0] / select(wanted != zero, wanted, broadcast(1)), zero);
}

// Impulses on the first ends, of each lane a row of four whose last component is 0.
template <ConstraintType C>
template <std::size_t ends>
inline typename ConstraintBatch<C>::ImpulseRows ConstraintBatch<C>::in_rows(Impulses& impulse) {
  ImpulseRows in_rows;
  for (std::size_t e = 0; e < ends; ++e) {
    Vec4d none = broadcast(0);
    transpose(impulse[e].x, impulse[e].y, impulse[e].z, none);
    in_rows[e] = {impulse[e].x, impulse[e].y, impulse[e].z, none};
  }
  return in_rows;
}

// What a change of the multipliers to lambda adds to each end and lane. Of two bodies the second gets the opposite.
template <ConstraintType C>
template <bool total>
inline typename ConstraintBatch<C>::ImpulseRows ConstraintBatch<C>::take_impulses(std::size_t b, const Rows<stencil, rows>& at,
                                                                                  const Solution& change, const Solution& lambda,
                                                                                  Vec4d share) {
  Impulses added;
  if constexpr (total) {
    const Impulses all = times(at, lambda);
    const Impulses own = eases_ ? times(at, change) : all;
    for (std::size_t e = 0; e < stencil; ++e) {
      const Vec3x4 missing = (eases_ ? all[e] - own[e] : all[e]) - applied_[b][e];
      added[e] = eases_ ? own[e] + missing * share : missing;
      applied_[b][e] = eases_ ? applied_[b][e] + added[e] : all[e];
    }
  } else {
    added = times<std::tuple_size_v<ImpulseRows>>(at, change);
  }
  return in_rows<std::tuple_size_v<ImpulseRows>>(added);
}

// What take_impulses() needs: of two bodies the first one's.
template <ConstraintType C>
template <bool total>
inline void ConstraintBatch<C>::keep_gradients(const Rows<stencil, rows>& now, Rows<stencil, rows>& at) {
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t e = 0; e < (is_pair && !total ? 1 : stencil); ++e) at.gradient[k][e] = now.gradient[k][e];
}

// Constraint after constraint, whatever block it is in: for each body in the order of the constraints.
template <ConstraintType C>
inline void ConstraintBatch<C>::add(const Block& block, const ImpulseRows& impulse, std::span<Vec4d> impulses) {
  for (std::size_t l = 0; l < lanes; ++l)
    if constexpr (is_pair)
      impulses[block.slot[0][l]] += impulse[0][l], impulses[block.slot[1][l]] -= impulse[0][l];
    else
      for (std::size_t e = 0; e < stencil; ++e) impulses[block.slot[e][l]] += impulse[e][l];
}

}  // namespace unibody
