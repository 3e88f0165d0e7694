#include "scene/events.hpp"

namespace unibody {

namespace {

EndEvent read_end(const Value& when) {
  when.map({"column", "below", "above", "after"});
  EndEvent event;
  const Value& column = when.need("column", "the name of a column of report.csv, as kinetic_energy");
  event.column = column.string("the name of a column of report.csv, as kinetic_energy");
  event.place = *column.origin + (column.line > 0 ? ":" + std::to_string(column.line) : "") + ": key '" + column.key + "'";
  const Value *below = when.find("below"), *above = when.find("above");
  if (below && above) above->fail("above beside below", "only one of them");
  if (!below && !above) when.fail_missing("below", "a number, or above: one");
  event.above = above != nullptr;
  event.value = (above ? above : below)->number(any_number, "in the unit of the column");
  if (const Value* after = when.find("after")) event.after = after->number(not_negative, "s");
  return event;
}

}  // namespace

std::vector<std::string> event_keys() { return {"do", "when"}; }

void read_events(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("events")) {
    entry.map(event_keys());
    entry.need("do", "end").choice({"end"});
    scene.end_events.push_back(read_end(entry.need("when", "a map with column, and below or above")));
  }
}

}  // namespace unibody
