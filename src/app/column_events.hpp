// Events of a scene that depend on what a frame's report says, and those that end the run.
#pragma once

#include <span>
#include <string>

#include "report/report.hpp"
#include "scene/scene.hpp"
#include "step/history.hpp"

namespace unibody {

// Throws InputError where an event is of a column that report.csv does not have, or that depends on the machine.
void check_event_columns(const Scene& scene, std::span<const NamedValue> constraint_columns);

// Notes which events take effect at the start of the next frame, since their conditions hold in this one. Returns the first that
// ends the run after this frame; null: none does. The same on every rank.
const Event* note_events(const Scene& scene, const FrameReport& report, Past& past);

std::string told(const Event& event);  // "kinetic_energy is below 0.001"

}  // namespace unibody
