// The plan of a step, for summary.json.
#pragma once

#include "core/json.hpp"
#include "step/plan.hpp"

namespace unibody {

// Every value of the plan, with its unit. A bound that is infinite is null.
Json json_of(const StepPlan& plan);

}  // namespace unibody
