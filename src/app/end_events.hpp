// Events of a scene that end its run.
#pragma once

#include <span>
#include <string>

#include "report/report.hpp"
#include "scene/scene.hpp"

namespace unibody {

// Throws InputError where an event is of a column that report.csv does not have, or that depends on the machine.
void check_end_events(const Scene& scene, std::span<const NamedValue> constraint_columns);

// The first event that ends the run after this frame; null: none does. The same on every rank.
const EndEvent* end_event_of(const Scene& scene, const FrameReport& report);

std::string told(const EndEvent& event);  // "kinetic_energy is below 0.001"

}  // namespace unibody
