#include "step/accuracy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/errors.hpp"
#include "core/largest.hpp"
#include "step/step_report.hpp"

namespace unibody {

namespace {

// Frames between two samples, and while their ratios differ by more than a factor.
constexpr double frames_between = 25, few_frames = 5, steady_factor = 1.4;

// Until the next sample the run reckons with so many times the ratio that a sample finds: it changes as things come to touch
// and to rest.
constexpr double reserve = 1.5;

// So many roundings of a place may the sums of a solve come to.
constexpr double roundings = 256;

// Below this share of the tolerance the residual is as good as none, and its ratio to the error that of two roundings.
constexpr double telling_share = 1e-3;

}  // namespace

void check_accuracy(const RankState& state) {
  if (!state.scene.solver.accuracy) return;
  double extent = 0;  // m, from the origin
  for (std::size_t i = 0; i < state.world.homes; ++i)
    extent = std::max(extent, state.world.position[i].cwiseAbs().maxCoeff() + bounding_radius(state.world.properties[i].shape));
  extent = largest_of_ranks(state.comm(), extent);
  const double size = state.traits.smallest_size, least = roundings * std::numeric_limits<double>::epsilon() * extent / size;
  if (!(*state.scene.solver.accuracy < least)) return;
  std::array<char, 256> text{};
  std::snprintf(
      text.data(), text.size(),
      ": key 'solver.accuracy': found %g, expected at least %.1e: the smallest body that moves measures %g m, places reach "
      "%g m from the origin, and a number has 16 digits",
      *state.scene.solver.accuracy, least, size, extent);
  throw InputError(state.scene.path + text.data());
}

bool samples_error(const RankState& state) {
  if (!state.scene.solver.accuracy) return false;
  return state.when.steps_done >= state.history.error_ratio.next;
}

void estimate_by_ratio(const RankState& state, StepReport& report) {
  report.estimated_error = report.residual * std::max(1.0, state.history.error_ratio.ratio);
}

void take_sample(RankState& state, double distance, double tolerance, StepReport& report) {
  report.estimated_error = std::max(report.residual, distance);
  ErrorRatio& known = state.history.error_ratio;
  if (!(report.residual > telling_share * tolerance)) return;
  const double found = reserve * distance / report.residual, before = known.next < 0 ? found : known.ratio;
  const bool steady = found <= steady_factor * before && before <= steady_factor * found;
  const double frames = steady ? frames_between : few_frames;
  known.ratio = std::max(found, std::sqrt(found * before));
  known.next = state.when.steps_done + std::llround(frames * state.traits.frame / state.when.whole_step);
}

}  // namespace unibody
