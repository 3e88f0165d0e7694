// All constraints of one type on this rank, four to a block, and the passes that solvers make over them (paper, Algorithm 1).
//
// Row k of a constraint: r_k = (c_k + E_k lambda_k / h + rho D_k^T u) / (h + rho), m/s, with c and D taken anew at x = x_l + h u
// in every pass; unknowns are impulses lambda = h gamma (N s). That is the residual of implicit Euler with compliance E and
// damping rho, divided by h + rho: so scaled its derivative by lambda is symmetric, also where the damping differs from row to
// row. At velocity level c and D are those of x_l, and c + h D_k^T u stands for c_k; of a row without compliance and damping that
// is broken at x_l only the share gamma of c is to be taken out.
//
// The incremental form applies each change of lambda along the D of its pass and leaves it there, so its fixed point is implicit
// Euler up to the turning of D within the step. The total form brings each body's impulse p to D lambda with the D of the last
// pass: r grows by s D^T W (D lambda - p), and D change + s (D lambda - p) is what is applied. The share s is 1 in solids that
// start a step in this form; else turned_share(), with which it converges however much a pull exceeds the masses.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "constraints/batch.hpp"
#include "constraints/constraint_type.hpp"
#include "constraints/direction_sum.hpp"

namespace unibody {

template <ConstraintType C>
class ConstraintBatch : public BatchDefaults {
 public:
  static constexpr std::string_view name = C::name;
  static constexpr std::size_t stencil = C::stencil, rows = C::rows, parameter_count = C::parameter_names.size();
  static constexpr bool lasts = true, stencils_last = true;
  using Type = C;
  using Multipliers = std::array<double, rows>;
  using History = std::vector<Multipliers>;  // of each constraint that is here
  using Key = std::array<Id, stencil>;       // the bodies' ids

  struct Block {
    std::array<std::array<Slot, lanes>, stencil> slot;
    std::array<Vec4d, parameter_count> parameters;
  };
  struct Softness {
    std::array<Vec4d, rows> compliance;  // m/N
    Vec4d damping;                       // s
  };
  using BlockVisitor = std::function<void(std::size_t, const Vec4d&)>;  // number of a block, residual of each lane (m/s)

  static void for_each_element(const Elements& elements, const std::function<void(const Key&, std::span<const Id>)>& f);

  // Calls f(colour, slots of the bodies) for each constraint, in its colour (in one of its own where the order is sequential).
  static void for_each_stencil(const BuildContext& context, const std::function<void(std::int32_t, std::span<const Slot>)>& f);
  static void count(const BuildContext& context, std::span<std::int32_t> counts);

  // Lays the constraints out: by colour for Gauss-Seidel, by runs of ids and by colour within a run for the Jacobi solvers.
  void build(const BuildContext& context);

  // Lays out the constraints in the given order; groups[g] is the end of group g in `order`, and no block spans two groups. An
  // empty lane ties the body that is nobody to itself. `slots(i)` are those of constraint i, counted(i) whether this rank
  // counts it in sums over all.
  void lay_out(std::span<const Constraint<C>> constraints, std::span<const std::uint32_t> order,
               std::span<const std::uint32_t> groups, Slot nobody, Form form,
               const std::function<std::array<Slot, stencil>(std::uint32_t)>& slots,
               const std::function<bool(std::uint32_t)>& counted);

  void start_step() { has_inverses_ = false; }

  std::size_t colours() const { return group_end_.size(); }
  bool needs_all(std::size_t) const { return false; }

  // Index = that of the constraint in the list.
  void set_multipliers(std::span<const Multipliers> multipliers, double share = 1);  // of these; empty: all zero
  void get_multipliers(std::span<Multipliers> multipliers) const;
  void start_from(const History& history, const WarmStart& warm);
  void remember(History& history, double) const;

  // Adds to each body the impulses D lambda (N s; x, y, z, 0) of this batch's multipliers. Before that, the multiplier of a link
  // is reduced where its geometric stiffness would exceed most_stiffness (see most_geometric_stiffness).
  void add_impulses(SolveState& state, const WarmStart& warm, double most_stiffness);
  void add_impulses(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                    double most_stiffness = HUGE_VAL);

  // Adds to each body what this batch has done to it (N s); in the incremental form D lambda with the D of where the bodies are,
  // which the solve has come to by changes along the D of each pass.
  void add_applied(const SolveState& state, std::span<Vec4d> impulses) const;

  // Goes on in the total form, from bodies to which the impulses of add_applied() have been applied.
  void take_total_form(const SolveState& state);

  // Largest geometric stiffness h |lambda| (c_a / m_a + c_b / m_b) / l of links with these multipliers, l their length at rest.
  double geometric_stiffness(const StepStart& start, std::span<const Multipliers> multipliers);

  // One iteration of a Jacobi solver, in the order of the layout: evaluate, step by P^-1, extrapolate, add to the impulses.
  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);
  void sweep(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
             const Extrapolation& extrapolation, SweepSums& sums);

  // The constraints of a colour share no moving body.
  double relax(std::size_t colour, bool backwards, SolveState& state);
  double relax(std::size_t colour, const StepStart& start, std::span<SolverBody> bodies);
  template <class F>
  void for_each_unknown(F&& f) {
    f(numbers_of(lambda_)), f(numbers_of(applied_));
  }

  // max (h + rho) |r|
  double residual(const SolveState& state) const { return residual(state.start(), state.bodies); }
  double residual(const StepStart& start, std::span<const SolverBody> bodies, const BlockVisitor* visit = nullptr) const;
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;

  // Whether two bodies of a constraint move against each other, in a step at these velocities, by more than this share of their
  // distance at its start, or by what is no number.
  bool moves_beyond(double share, const StepStart& start, std::span<const SolverBody> bodies) const;

  // Adds the directions of each constraint at the start of the step to the sums of its bodies.
  void add_directions(const StepStart& start, std::span<const SolverBody> bodies, std::span<DirectionSum> sums) const;

  // Sets the form of the next step, before set_multipliers().
  void set_form(Form form) { form_ = form, eases_ = !fills_space<C>; }
  Form form() const { return form_; }

  std::size_t size() const { return order_.size(); }
  std::size_t bytes() const;
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  // What a pass knows of the bodies of a block. `weight`: c_b / m_b for Jacobi, 1 / m_b for Gauss-Seidel.
  struct Ends {
    std::array<Vec3x4, stencil> x, u;
    std::array<Vec4d, stencil> weight;
  };
  using Solution = std::array<Vec4d, rows>;
  using Impulses = std::array<Vec3x4, stencil>;  // N s, on each end
  static constexpr bool is_pair = stencil == 2;
  using ImpulseRows = std::array<std::array<Vec4d, lanes>, is_pair ? 1 : stencil>;                  // of each end, or the first
  std::size_t begin_of(std::size_t group) const { return group == 0 ? 0 : group_end_[group - 1]; }  // in blocks
  static constexpr std::size_t ahead = rows == 1 ? 16 : 2;                                          // blocks under way at a time

  // What rows are made of: stiff ones need no velocities beside the positions; linear ones are those of the velocity level.
  enum class Law { stiff, soft, linear };

  // The pieces of a pass: inlined by force, since passing their results through memory costs half as much as the work.
  template <Law law, bool moved>
  [[gnu::always_inline]] static inline Ends gather(const Block& block, const StepStart& start,
                                                   std::span<const SolverBody> bodies);
  template <Law law>
  [[gnu::always_inline]] inline Solution residual_of(std::size_t b, const Ends& ends, const Rows<stencil, rows>& at,
                                                     const Solution& lambda, const StepStart& start, Vec4d over_step) const;
  template <bool soft>
  [[gnu::always_inline]] inline Solution solve_block(std::size_t b, const Rows<stencil, rows>& at, const Ends& ends,
                                                     const Solution& r, double step) const;
  template <std::size_t ends = stencil>
  [[gnu::always_inline]] static inline Impulses times(const Rows<stencil, rows>& at, const Solution& lambda);
  [[gnu::always_inline]] inline Impulses add_misfit(std::size_t b, const Rows<stencil, rows>& at, const Ends& ends,
                                                    const Solution& lambda, Vec4d share, Solution& r) const;
  [[gnu::always_inline]] inline Vec4d turned_share(std::size_t b, const Rows<stencil, rows>& at, const Ends& ends,
                                                   const Solution& lambda, double step) const;
  [[gnu::always_inline]] static inline Vec4d part_taken(const Solution& lambda, Solution& step);
  template <std::size_t ends>
  [[gnu::always_inline]] static inline ImpulseRows in_rows(Impulses& impulse);
  template <bool total>
  [[gnu::always_inline]] inline ImpulseRows take_impulses(std::size_t b, const Rows<stencil, rows>& at, const Solution& change,
                                                          const Solution& lambda, Vec4d share);
  template <bool total>
  [[gnu::always_inline]] static inline void keep_gradients(const Rows<stencil, rows>& now, Rows<stencil, rows>& at);
  [[gnu::always_inline]] static inline void add(const Block& block, const ImpulseRows& impulse, std::span<Vec4d> impulses);
  template <Law law, bool total>
  void add_multipliers(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                       double most_stiffness);
  template <std::size_t ends>
  Impulses present_impulses(std::size_t b, const StepStart& start, std::span<const SolverBody> bodies) const;
  Vec4d missing_speed(std::size_t b, const Impulses& missing, std::span<const SolverBody> bodies) const;
  inline void bound_stiffness(std::size_t b, const Rows<stencil, rows>& at, double most, double step);
  void add_lines(const StepStart& start, std::span<const SolverBody> bodies, std::span<DirectionSum> sums) const;
  void take_inverses(const StepStart& start);  // at the first pass of a step
  // (h + rho) |r| / h of a row's |r|, m/s: rows are divided by h + rho, and their residual is not.
  template <Law law>
  [[gnu::always_inline]] inline Vec4d with_damping(std::size_t b, Vec4d r, Vec4d over_step) const {
    if constexpr (law == Law::stiff) return r;
    return r * (broadcast(1) + softness_of(b).damping * over_step);
  }
  template <Law law>
  [[gnu::always_inline]] inline Solution extrapolate(std::size_t b, const Solution& r, Solution step, const Update<Vec4d>& update,
                                                     Vec4d over_step, SweepTotals& totals);
  Softness softness_of(std::size_t b) const { return softness_.empty() ? Softness{} : softness_[b]; }
  template <Law law, bool total>
  void sweep_as(const StepStart& start, std::span<const SolverBody> bodies, std::span<Vec4d> impulses,
                const Extrapolation& extrapolation, SweepSums& sums);
  template <Law law>
  double residual_by(const StepStart& start, std::span<const SolverBody> bodies, const BlockVisitor* visit) const;
  template <Law law, bool total>
  double relax_group(std::size_t group, const StepStart& start, std::span<SolverBody> bodies);

  std::vector<Block> blocks_;
  std::vector<Softness> softness_;  // of each block; empty where all is stiff and undamped
  std::vector<Solution> lambda_, y_;
  std::vector<Impulses> applied_;  // in the total form: on the bodies of each block so far
  Form form_ = Form::incremental;
  bool eases_ = !fills_space<C>;          // in the total form: passes take over a part of what has turned
  std::vector<Vec4d> inverses_;           // 1/P of each block; empty where it changes within the step
  bool has_inverses_ = false;             // of this step
  std::vector<std::uint8_t> counted_;     // of each block a bit a lane
  std::vector<std::uint32_t> group_end_;  // in blocks
  std::vector<std::int32_t> order_;       // constraint of each lane of each block, -1: empty
};

}  // namespace unibody
