#include "step/turning.hpp"

#include <algorithm>
#include <cmath>

#include "core/largest.hpp"

namespace unibody {

std::pmr::vector<Vec4d> velocities_of(std::span<const SolverBody> bodies, std::pmr::memory_resource* memory) {
  std::pmr::vector<Vec4d> velocities(bodies.size(), Vec4d{}, memory);
  for (std::size_t i = 0; i < bodies.size(); ++i) velocities[i] = *reinterpret_cast<const Vec4dView*>(bodies[i].v);
  return velocities;
}

Turning::Turning(RankState& state, const System& system, std::span<const Vec4d> predicted)
    : missing_(system.bodies.size(), Vec4d{}, &state.scratch) {
  for_each_batch(system.batches, [&](auto, const auto& batch) { batch.add_applied(system, missing_); });
  double most = 0;
  for (std::size_t i = 0; i < missing_.size(); ++i) {
    const SolverBody& b = system.bodies[i];
    const bool moves = i < system.homes && state.world.properties[i].shape.kind == ShapeKind::particle && b.inverse_mass > 0;
    const Vec4d gained = *reinterpret_cast<const Vec4dView*>(b.v) - (moves ? predicted[i] : Vec4d{});
    missing_[i] = moves ? broadcast(b.inverse_mass) * missing_[i] - gained : Vec4d{};
    const Vec4d m = missing_[i];
    const double square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
    most = std::max(most, or_infinity(square));
  }
  distance_ = largest_of_ranks(state.comm(), system.step * std::sqrt(most));
}

void Turning::apply(RankState& state, System& system) const {
  for_each_constraint_batch(system.batches, [&](auto, auto& batch) { batch.take_total_form(system); });
  for (std::size_t i = 0; i < system.homes; ++i)
    for (int k = 0; k < 3; ++k) system.bodies[i].v[k] += missing_[i][k];
  state.exchange.refresh(system.bodies);
}

namespace {

// Of what was missing, the most that the total form may leave in all rows: those of stiff links are solved slower in it.
constexpr double most_left = 0.1;

// m, over all ranks.
double residual_of_rows(const RankState& state, const System& system) {
  double largest = 0;
  for (const double residual : residuals(system)) largest = std::max(largest, or_infinity(residual));
  return largest_of_ranks(state.comm(), largest);
}

}  // namespace

TurningLeft take_out_turning(RankState& state, System& system, std::span<const Vec4d> predicted, double tolerance, int iterations,
                             const std::function<int(int)>& run) {
  const Scratch::Frame frame(state.scratch);
  const Turning turning(state, system, predicted);
  TurningLeft left{turning.distance()};
  if (iterations <= 0 || !(left.distance > tolerance)) return left;
  if (!(residual_of_rows(state, system) <= std::max(tolerance, left.distance))) return left;
  const std::vector<SolverBody> bodies(system.bodies.begin(), system.bodies.end());
  const Batches batches = system.batches;
  turning.apply(state, system);
  left.iterations = run(iterations);
  if (residual_of_rows(state, system) <= std::max(tolerance, most_left * left.distance)) {
    left.distance = Turning(state, system, predicted).distance();
    return left;
  }
  std::ranges::copy(bodies, system.bodies.begin());
  system.batches = batches;
  return left;
}

}  // namespace unibody
