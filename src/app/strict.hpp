// Option -strict: a step that is off by more than it may be stops the run.
#pragma once

#include <cstdint>

#include "report/convergence.hpp"
#include "report/report.hpp"
#include "step/step_report.hpp"

namespace unibody {

// Throws InputError where no step could be within the tolerance.
void check_tolerance(const Convergence& convergence);

// The natural residual (m) from which on a step's worst constraint is to be named, for stop_if_wrong() to name it.
double least_named(const Convergence& convergence);

// Throws RunError where the step has not converged, or is off by more than its part of the accuracy that is asked for.
void stop_if_wrong(const Scene& scene, const Convergence& convergence, const StepReport& step, std::int64_t frame);

// Throws RunError where tetrahedra are inside out or edges go through faces at the frame's end.
void stop_if_sides_are_lost(const FrameReport& report);

}  // namespace unibody
