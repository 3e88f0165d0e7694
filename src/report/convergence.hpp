// How far the frames of a run are off, by the accuracy that is asked for, in its last lines and in summary.json.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "constraints/solver_settings.hpp"
#include "core/json.hpp"
#include "report/figures.hpp"
#include "scene/scene.hpp"
#include "step/worst_constraint.hpp"

namespace unibody {

struct FrameReport;

// What a frame is off by: the largest of these.
enum class Fault { error, residual, turning, penetration, joint_drift };
inline constexpr std::array<std::string_view, 5> fault_names{"estimated error", "natural residual", "turning", "penetration",
                                                             "joint drift"};

struct Off {
  double length = 0;  // m
  Fault fault = Fault::residual;
};

// What a frame is off by: the largest of what its solve left undone (its estimated error where an accuracy is asked for, else
// its natural residual), of what constraints miss of their turning, of how deep its contacts are, and of how far its joints are
// open.
Off off_by(const FrameReport& report, bool asked);

// Natural residuals (m) of the frames, each of the frame's worst step; and what each frame is off by (m).
struct Convergence {
  double tolerance = 0;                // m; 0: the solver's iterations never stop early
  double smallest_size = 0;            // m, of the smallest body that moves; infinite: none does
  double accuracy = default_accuracy;  // share of that size by which the frames are judged
  bool asked = false;                  // by the scene: the iterations were picked for it
  Figures residuals, offs;             // m
  Figures rates;                       // m/s, FrameReport::residual_rate
  std::int64_t held = 0;               // frames that are off by no more than allowed(), and in which no side was lost
  std::int64_t unconverged = 0;        // frames of which a step did not converge
  double worst_residual = 0;           // m
  std::int64_t worst_frame = 0;        // the first of those with that residual; 0: none has more than 0
  Off most_off;                        // of all frames
  std::int64_t most_off_frame = 0;
  std::optional<WorstConstraint> worst;  // of worst_frame, where its residual is not 0

  void add(const FrameReport& report);
  bool judges() const;     // there is a body that moves, and a frame
  double allowed() const;  // m
};

// "contacts of crate and pile[17]"
std::string told(const WorstConstraint& worst, const Scene& scene);

// Some lines, each with its end.
std::string told(const Convergence& convergence, const Scene& scene);

Json json_of(const Convergence& convergence, const Scene& scene);

}  // namespace unibody
