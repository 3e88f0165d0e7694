// The text that frames.xdmf has of a frame of frames.h5 (output.hpp).
#pragma once

#include <string>
#include <vector>

#include "world/surface.hpp"

namespace unibody {

struct FramesXdmf {
  bool single = false;  // precision of the reals
  const std::vector<Surface>& surfaces;
  // Bodies come and go: their ids, sizes and shapes stand with the frame, and the nodes of surfaces by themselves.
  bool changes = false;
  Id nodes = 0;  // of surfaces, where bodies come and go

  // rows: bodies in the frame.
  std::string frame(std::int64_t number, double time, Id rows) const;

 private:
  std::string bodies(const std::string& at, Id rows) const;
  std::string cells(const std::string& at, Id rows) const;
};

}  // namespace unibody
