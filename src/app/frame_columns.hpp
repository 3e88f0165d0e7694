// The columns that report.csv has beside those of all scenes.
#pragma once

#include <vector>

#include "app/options.hpp"
#include "report/probes.hpp"
#include "report/report.hpp"
#include "step/simulation.hpp"

namespace unibody {

// What the columns are made from.
struct ColumnSources {
  const Scene& scene;
  const Options& options;
  Simulation& simulation;
  const Probes& probes;
  PhaseClock& clock;
};

// What a scene's types of bodies and constraints, its probes, inlets and outlets have to tell of a frame, and what its settings
// and the options ask for. step: the frame's last. Collective.
std::vector<NamedValue> further_columns(const ColumnSources& from, const StepReport& step, const FrameReport& report);

}  // namespace unibody
