// How far the frames of a run are from solved, in its last lines and in summary.json.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "scene/scene.hpp"
#include "step/worst_constraint.hpp"

namespace unibody {

struct FrameReport;

// Natural residuals (m) of the frames, each of the frame's worst step.
struct Convergence {
  double tolerance = 0;      // m; 0: the solver's iterations never stop early
  double smallest_size = 0;  // m, of the smallest body that moves; infinite: none does
  std::vector<double> residuals;
  std::int64_t unconverged = 0;          // frames of which a step did not converge
  double worst_residual = 0;             // m
  std::int64_t worst_frame = 0;          // the first of those with that residual; 0: none has more than 0
  std::optional<WorstConstraint> worst;  // of that frame, where its residual is not 0

  void add(const FrameReport& report);
  // The least residual that this share of the frames, 0 to 1, is within. m
  double within(double share) const;
};

// "contacts of crate and pile[17]"
std::string told(const WorstConstraint& worst, const Scene& scene);

// Some lines, each with its end.
std::string told(const Convergence& convergence, const Scene& scene);

Json json_of(const Convergence& convergence, const Scene& scene);

}  // namespace unibody
