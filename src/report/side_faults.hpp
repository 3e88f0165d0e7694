// Where bodies have lost a side: tetrahedra that are inside out, edges that go through faces, and bodies that would have gone
// through what is fixed or driven. A solve can converge in such a state, which is then not the scene's: a run says so in its last
// lines and in summary.json, whatever its residuals are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/json.hpp"

namespace unibody {

struct FrameReport;

// How many there were of one kind.
struct SideFault {
  std::string what;  // "tetrahedra of rubber inside out"
  std::string remedy;
  std::int64_t most = 0, most_frame = 0, at_end = 0;  // of all frames; the first frame with so many; in the last frame
};

// Those of one frame, by the columns of its report: only kinds of which there is one.
std::vector<SideFault> side_faults(const FrameReport& report);

// Those of all frames.
struct SideFaults {
  std::vector<SideFault> kinds;

  void add(const FrameReport& report);
};

// "12 tetrahedra of rubber inside out"
std::string told(const SideFault& fault);

// A line for each kind, with its end.
std::string told(const SideFaults& faults);

Json json_of(const SideFaults& faults);

}  // namespace unibody
