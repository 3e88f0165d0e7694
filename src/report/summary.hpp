// summary.json: what ran, with what, how long it took and where it ended.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "partition/work.hpp"
#include "report/convergence.hpp"
#include "report/report.hpp"
#include "report/side_faults.hpp"
#include "scene/scene.hpp"
#include "step/history.hpp"
#include "step/plan.hpp"

namespace unibody {

// The wall times of one phase, a figure a frame.
struct PhaseTimes {
  std::string name;
  Figures seconds;  // of each frame
  // s, of the ranks' own totals over the frames: the larger the mean beside the maximum, the more evenly the ranks are at work.
  double least_rank = 0, mean_rank = 0, most_rank = 0;
};

// Estimated errors of the frames that were sampled.
struct ErrorSamples {
  std::int64_t count = 0, worst_frame = 0, last_frame = 0;
  StepError worst, last;  // the worst: the first of those with the largest distance

  void add(std::int64_t frame, const StepError& error);
};

struct Summary {
  std::vector<Override> overrides;
  SolverSettings solver;        // as used: with what "auto" came to
  std::vector<StepPlan> plans;  // of the last step: one, or one of each kind of islands
  std::string restarted_from;   // path of the checkpoint; empty: none
  std::string continued_from;   // the same, of another scene's
  std::int64_t first_frame = 0, last_frame = 0;
  double wall_total = 0;  // s, of the whole run
  std::vector<PhaseTimes> phases;
  FrameReport final;
  Convergence convergence;
  SideFaults side_faults;
  ErrorSamples errors;
  CoarseCounts coarse;
  std::int64_t form_left = 0;      // steps taken in the incremental form, not the total one
  std::vector<std::string> files;  // written, in the order of mention
  BorderCosts borders;             // of the last step
  std::uint64_t state_hash = 0;
  Id dynamic_bodies = 0;
  Past past;                        // what has happened of events, inlets and outlets
  std::string status = "finished";  // or why it stopped

  std::int64_t frames() const { return last_frame - first_frame; }
  void add(const FrameReport& report);
};

// How far the run is from solved and, where this was asked for or happened, what its steps' errors were estimated to be and how
// many were taken in the other form: lines for the run's end.
std::string told(const Summary& summary, const Scene& scene);

std::string summary_text(MPI_Comm comm, const Scene& scene, const Summary& summary);

// Writes the text on rank 0, under a temporary name first. Collective; throws RunError on every rank.
void write_summary(MPI_Comm comm, const std::string& path, const Scene& scene, const Summary& summary);

}  // namespace unibody
