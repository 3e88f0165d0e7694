// What drivers of other engines have in common: options, the clock, and the loop over frames.
//   ENGINE INPUT.h5 OUTPUT.h5 [--iterations 10] [--substeps 1] [--frames 400] [--step 0.016] [--friction 0.3] [--gravity 9.8]
//          [--chain 0] [--direct 0] [--erp2 0.2] [--split 1] [--erp SHARE] [--erv SPEED]
// --chain 1 ties the dynamic bodies to a chain (chain.hpp), which then touch nothing; --direct 1 takes an engine's direct solver
// where it has one. Of Bullet alone: --erp2, the share of a penetration that a step takes out; --split 0 solves all islands as
// one. Of DART alone: --erp, the same share, and --erv, the most speed (m/s) given to that; without them its own. Prints the
// median CPU time of a frame's steps alone; writing is not timed. Where a state is no longer finite: "diverged_frame N" instead,
// and the frames before it are in the file.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bodies.hpp"
#include "chain.hpp"

namespace rivals {

// m, half width of the box that stands for a half space where an engine's own gives too few contacts: nothing slides off it. In
// single precision a depth below it is still known to some micrometres, since depths come from distances along the normal alone.
constexpr double wide = 1000;

struct Settings {
  int iterations = 10, substeps = 1, direct = 0, tied = 0, split = 1;
  long frames = 400;
  double step = 0.016, friction = 0.3, gravity = 9.8, erp2 = 0.2, erp = -1, erv = -1;  // negative: the engine's own
  std::vector<Anchor> chain;                                                           // empty: not tied
};

// Thrown by a step that finds its state beyond use, where the engine itself would end the process.
struct Diverged {};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual void step(double dt) = 0;                                // s; may throw Diverged
  virtual void read(const Bodies& scene, Frame& frame) const = 0;  // the dynamic bodies' states
};

using MakeEngine = std::function<std::unique_ptr<Engine>(const Bodies&, const Frame& start, const Settings&)>;

// All of a driver's main: returns its exit code. `single`: the engine computes in single precision, and so its frames are stored.
int drive(int argc, char** argv, const char* name, bool single, const MakeEngine& make);

}  // namespace rivals
