// How far the tetrahedra of solids are strained.
#pragma once

#include "report/stretch.hpp"

namespace unibody {

// The strains of all tetrahedra of one material.
struct Strain {
  double max = 0;                         // of the absolute principal values of Green's strain
  double volume_min = 1, volume_max = 1;  // V / V0; below 0: inverted
  std::int64_t count = 0, inverted = 0;   // tetrahedra
  double energy = 0;                      // J, elastic
};

// The strains of each material of the scene. The same bits on any number of ranks. Collective.
std::vector<Strain> measure_strain(MPI_Comm comm, const World& world, const ConstraintSet& constraints,
                                   std::size_t material_count);

// strain_max, volume_min, volume_max, inverted and elastic_energy of each material with tetrahedra. Collective.
std::vector<NamedValue> strain_columns(MPI_Comm comm, const Scene& scene, const World& world, const ConstraintSet& constraints);

}  // namespace unibody
