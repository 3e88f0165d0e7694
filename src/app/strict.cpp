#include "app/strict.hpp"

#include <array>
#include <cstdio>

#include "core/errors.hpp"
#include "report/side_faults.hpp"

namespace unibody {

void check_tolerance(const Convergence& convergence) {
  if (convergence.tolerance == 0)
    throw InputError("option -strict: found solver.tolerance 0, which no step is within, expected more than 0");
}

double least_named(const Convergence& convergence) { return convergence.asked ? 0 : convergence.tolerance; }

void stop_if_wrong(const Scene& scene, const Convergence& convergence, const StepReport& step, std::int64_t frame) {
  const double allowed = convergence.allowed() / scene.time.substeps;
  const bool holds = !convergence.asked || step.estimated_error <= allowed;
  if (step.converged && holds) return;
  const double tolerance = step.plans.empty() ? convergence.tolerance : step.plans.front().tolerance;
  std::array<char, 128> by{};
  if (holds)
    std::snprintf(by.data(), by.size(), "the natural residual is %.2e m, the tolerance %.2e m", step.residual, tolerance);
  else
    std::snprintf(by.data(), by.size(), "the error is estimated as %.2e m, the accuracy allows a step %.2e m",
                  step.estimated_error, allowed);
  throw RunError("option -strict: frame " + std::to_string(frame) + " has not converged: " + by.data() +
                 (step.worst ? "; farthest from solved: " + told(*step.worst, scene) : ""));
}

void stop_if_sides_are_lost(const FrameReport& report) {
  const auto faults = side_faults(report);
  if (!faults.empty())
    throw RunError("option -strict: frame " + std::to_string(report.step) + ": found " + told(faults.front()) +
                   ", expected none; " + faults.front().remedy);
}

}  // namespace unibody
