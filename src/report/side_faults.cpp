#include "report/side_faults.hpp"

#include <algorithm>

#include "report/report.hpp"

namespace unibody {

namespace {

// What a column of the report counts, where it counts such faults; an empty `what`: it does not.
SideFault kind_of(const std::string& column) {
  const std::string inverted = "inverted[";
  if (column.starts_with(inverted))
    return {"tetrahedra of " + column.substr(inverted.size(), column.find(']') - inverted.size()) + " inside out",
            "their law does not turn them back, solids[].least_volume does"};
  if (column.starts_with("crossings "))
    return {"edges of cloths or threads through faces", "more iterations or time.substeps may keep them apart"};
  if (column.starts_with("held_bodies "))
    return {"bodies held back that would have passed through what is fixed or driven",
            "more iterations, a shorter time.frame or more time.substeps tell better where they go"};
  return {};
}

}  // namespace

std::vector<SideFault> side_faults(const FrameReport& report) {
  std::vector<SideFault> found;
  for (const NamedValue& column : report.constraint_columns) {
    SideFault fault = kind_of(column.name);
    if (fault.what.empty() || !column.known || column.value <= 0) continue;
    fault.most = fault.at_end = static_cast<std::int64_t>(column.value), fault.most_frame = report.step;
    found.push_back(std::move(fault));
  }
  return found;
}

void SideFaults::add(const FrameReport& report) {
  for (SideFault& kind : kinds) kind.at_end = 0;
  for (const SideFault& found : side_faults(report)) {
    const auto same = std::ranges::find(kinds, found.what, &SideFault::what);
    if (same == kinds.end()) {
      kinds.push_back(found);
      continue;
    }
    same->at_end = found.at_end;
    if (found.most > same->most) same->most = found.most, same->most_frame = found.most_frame;
  }
}

std::string told(const SideFault& fault) { return std::to_string(fault.most) + " " + fault.what; }

std::string told(const SideFaults& faults) {
  std::string text;
  for (const SideFault& kind : faults.kinds)
    text += "not as the scene has it: " + told(kind) + " in frame " + std::to_string(kind.most_frame) + ", " +
            std::to_string(kind.at_end) + " at the end; " + kind.remedy + "\n";
  return text;
}

Json json_of(const SideFaults& faults) {
  Json list = Json::array();
  for (const SideFault& kind : faults.kinds)
    list.push(Json::object()
                  .set("what", kind.what)
                  .set("most", kind.most)
                  .set("most_frame", kind.most_frame)
                  .set("at_end", kind.at_end));
  return list;
}

}  // namespace unibody
