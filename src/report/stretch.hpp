// How far flexible bodies are stretched, and how far their constraints are from solved.
#pragma once

#include <mpi.h>

#include <span>
#include <string>
#include <vector>

#include "constraints/counted.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

// Relative change of length of a material's links, or of its membranes along their principal directions; bending links do not
// count.
struct Stretch {
  double max = 0, rms = 0;  // of the absolute value
  std::int64_t count = 0;   // links and principal directions
};

// The stretches of each material of the scene. The same bits on any number of ranks. Collective.
std::vector<Stretch> measure_stretch(MPI_Comm comm, const World& world, const ConstraintSet& constraints,
                                     std::size_t material_count);

// A column of the report that only some scenes have.
struct NamedValue {
  std::string name;  // with its unit
  double value = 0;
  bool known = true;  // false: an empty cell
};

// stretch_max and stretch_rms of each material with links or membranes, then the natural residual of each type of constraint that
// the scene has. `residuals`: m, of each type. Collective.
std::vector<NamedValue> constraint_columns(MPI_Comm comm, const Scene& scene, const World& world,
                                           const ConstraintSet& constraints, std::span<const double> residuals);

}  // namespace unibody
