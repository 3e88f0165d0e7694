// A kind of constraint that exists in this test alone: a spring along x from the centre of body 0 to the origin. Nothing else in
// the program knows of it but the list of batches.
#pragma once

#include <array>
#include <cmath>

#include "constraints/batch.hpp"
#include "world/world.hpp"

namespace unibody {

class SpringBatch : public BatchDefaults {
 public:
  static constexpr std::string_view name = "spring_to_the_origin";
  static constexpr double stiffness = 400;             // N/m
  static constexpr double shortening = 3;              // of each step: few iterations leave it short of converged
  using Key = std::array<Id, 1>;                       // the body
  using History = std::vector<std::array<double, 1>>;  // N s

  template <class F>
  static void for_each_element(const Elements& elements, F&& f) {
    const Slot slot = elements.world.find(0);
    if (slot >= 0 && elements.world.is_home(slot)) f(Key{0}, std::array<Id, 1>{0});
  }
  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for_each_element(context.elements,
                     [&](const Key& key, std::span<const Id>) { f(0, std::array<Slot, 1>{context.world.find(key[0])}); });
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) { count_stencils<SpringBatch>(context, counts); }

  void build(const BuildContext& context) {
    slot_ = -1, lambda_ = y_ = 0, step_ = context.state.step;
    for_each_stencil(context, [&](std::int32_t, std::span<const Slot> ends) { slot_ = ends[0]; });
    if (slot_ < 0) return;
    const auto s = static_cast<std::size_t>(slot_);
    start_ = context.world.position[s].x();
    const double sharers = context.state.counts.empty() ? 1 : context.state.counts[s];
    block_ = shortening * (sharers * context.state.bodies[s].inverse_mass + 1 / (stiffness * step_ * step_));
  }
  // (x + h v + lambda / (k h)) / h: implicit Euler's.
  double rate(const SolveState& state) const {
    return (start_ + step_ * state.bodies[static_cast<std::size_t>(slot_)].v[0] + lambda_or_y_ / (stiffness * step_)) / step_;
  }
  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
    if (slot_ < 0) return;
    lambda_or_y_ = y_;
    const double r = rate(state), step = -r / block_;
    SweepTerms<double> terms;
    const double moved = update_of(extrapolation).advance(lambda_, y_, y_ + step, step, r, -r * step, step_ * std::abs(r), terms);
    add_terms(sums, terms, true);
    state.wrenches[static_cast<std::size_t>(slot_)].force[0] += moved;
  }
  std::size_t colours() const { return 1; }
  double relax(std::size_t, bool, SolveState& state) {
    if (slot_ < 0) return 0;
    lambda_or_y_ = lambda_;
    const double r = rate(state), step = -r / block_;
    SolverBody& body = state.bodies[static_cast<std::size_t>(slot_)];
    lambda_ += step, body.v[0] += body.inverse_mass * step;
    return step_ * std::abs(r);
  }
  template <class F>
  void for_each_unknown(F&& f) {
    f(std::span(&lambda_, 1));
  }
  double residual(const SolveState& state) const {
    if (slot_ < 0) return 0;
    lambda_or_y_ = lambda_;
    return step_ * std::abs(rate(state));
  }
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
    if (slot_ >= 0) visit(residual(state), std::array{slot_});
  }
  void start_from(const History& history, const WarmStart&) {
    if (slot_ >= 0 && !history.empty()) lambda_ = y_ = 0.3 * history[0][0];
  }
  void add_impulses(SolveState& state, const WarmStart&, double) {
    if (slot_ >= 0) state.wrenches[static_cast<std::size_t>(slot_)].force[0] += lambda_;
  }
  void remember(History& history, double) const {
    if (slot_ >= 0) history.at(0)[0] = lambda_;
  }
  std::size_t bytes() const { return 0; }

 private:
  Slot slot_ = -1;
  double step_ = 0, start_ = 0, block_ = 1, lambda_ = 0, y_ = 0;
  mutable double lambda_or_y_ = 0;
};

static_assert(KeyedBatch<SpringBatch>);

}  // namespace unibody
