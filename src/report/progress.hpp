// The line that tells a person how far the run is.
#pragma once

#include <cstdint>
#include <string>

#include "report/report.hpp"

namespace unibody {

class Progress {
 public:
  // Frames (first, last] will be run. Prints on rank 0 only: on a terminal one line with a bar that is overwritten, else a
  // line every five seconds. `bodies` is how many there are in a scene whose report has no column of that name.
  Progress(int rank, std::int64_t first, std::int64_t last, Id bodies);

  void frame_done(const FrameReport& report);

 private:
  int rank_;
  bool terminal_;
  std::int64_t first_, last_;
  Id bodies_;
  double body_frames_ = 0;  // bodies that were there, summed over the frames
  double start_, printed_;
};

}  // namespace unibody
