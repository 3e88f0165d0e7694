#include "app/column_events.hpp"

#include <algorithm>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "scene/setting.hpp"

namespace unibody {

void check_event_columns(const Scene& scene, std::span<const NamedValue> constraint_columns) {
  FrameReport report;
  report.constraint_columns.assign(constraint_columns.begin(), constraint_columns.end());
  for (NamedValue& column : report.constraint_columns) column.known = true;
  for (const Event& event : scene.events) {
    if (!event.when || report_value(report, event.when->column)) continue;
    throw InputError(event.when->place + ": found " + event.when->column +
                     did_you_mean(event.when->column, report_names(constraint_columns)) +
                     ", expected a column of report.csv that is the same on any machine, as kinetic_energy");
  }
}

const Event* note_events(const Scene& scene, const FrameReport& report, Past& past) {
  const Event* end = nullptr;
  for (std::size_t e = 0; e < scene.events.size(); ++e) {
    const Event& event = scene.events[e];
    const bool ends = event.action == Event::Action::end;
    bool holds = ends && !event.when && event.time <= report.time + 1e-9 * scene.time.frame;
    if (event.when && (ends || past.events[e] == 0)) {
      const std::optional<double> value = report_value(report, event.when->column);
      holds = value && event.when->holds(report.time, *value);
      if (holds && !ends) past.events[e] = report.step + 1;
    }
    if (holds && ends && end == nullptr) end = &event;
  }
  return end;
}

std::string told(const Event& event) {
  if (!event.when) return "its time is " + settings::text_of(event.time) + " s";
  return event.when->column + " is " + (event.when->above ? "above " : "below ") + settings::text_of(event.when->value);
}

}  // namespace unibody
