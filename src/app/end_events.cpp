#include "app/end_events.hpp"

#include <algorithm>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "scene/setting.hpp"

namespace unibody {

void check_end_events(const Scene& scene, std::span<const NamedValue> constraint_columns) {
  FrameReport report;
  report.constraint_columns.assign(constraint_columns.begin(), constraint_columns.end());
  for (NamedValue& column : report.constraint_columns) column.known = true;
  for (const EndEvent& event : scene.end_events) {
    if (report_value(report, event.column)) continue;
    throw InputError(event.place + ": found " + event.column + did_you_mean(event.column, report_names(constraint_columns)) +
                     ", expected a column of report.csv that is the same on any machine, as kinetic_energy");
  }
}

const EndEvent* end_event_of(const Scene& scene, const FrameReport& report) {
  const auto ends = [&](const EndEvent& event) {
    const std::optional<double> value = report_value(report, event.column);
    return value && event.holds(report.time, *value);
  };
  const auto event = std::ranges::find_if(scene.end_events, ends);
  return event == scene.end_events.end() ? nullptr : &*event;
}

std::string told(const EndEvent& event) {
  return event.column + " is " + (event.above ? "above " : "below ") + settings::text_of(event.value);
}

}  // namespace unibody
