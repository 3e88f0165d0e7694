// The accuracy that a scene asks for: what is stopped by, and the ratio of error to residual by which the two belong together.
#pragma once

#include <cstdint>

#include "step/rank_state.hpp"

namespace unibody {

struct StepReport;

// Throws InputError on every rank where the scene asks for an accuracy that numbers of double precision do not bear: changes of a
// place that are lost in rounding, so far from the origin as its bodies lie. Collective.
void check_accuracy(const RankState& state);

// Whether the error of the step that is taken next is to be estimated: where the scene asks for an accuracy, in a step of every
// 25th frame, of every fifth while the ratio changes much from sample to sample, or of the first after it whose residual tells of
// an error. The same on all ranks.
bool samples_error(const RankState& state);

// What the step's residual says of its error, by the ratio that is known: StepReport::estimated_error.
void estimate_by_ratio(const RankState& state, StepReport& report);

// The error of this step has been estimated (m): renews the ratio, and what the report says.
void take_sample(RankState& state, double distance, double tolerance, StepReport& report);

}  // namespace unibody
