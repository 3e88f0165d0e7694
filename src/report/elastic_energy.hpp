// What is stored in the constraints that have a compliance.
#pragma once

#include <mpi.h>

#include "collide/contacts.hpp"
#include "constraints/constraint_types.hpp"
#include "world/material_pairs.hpp"
#include "world/world.hpp"

namespace unibody {

// J: the sum of c_k^2 / 2 E_k over the rows of links, membranes, bending, areas and tetrahedra at the present places; of stiff
// rows nothing, and of joints neither. `constraints`: those that touch this rank's home bodies, all of whose bodies are here. The
// same bits on any number of ranks. Collective.
double elastic_energy(MPI_Comm comm, const World& world, const ConstraintSet& constraints);

// J: what is stored in the overlaps of contacts that give way (constraints/compliance.hpp). Collective.
double contact_energy(MPI_Comm comm, const World& world, const Contacts& contacts, const MaterialPairs& pairs);

}  // namespace unibody
