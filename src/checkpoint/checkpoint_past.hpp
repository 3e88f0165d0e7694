// What a checkpoint keeps of a run beside its bodies and multipliers: what an accuracy has found out, what has happened of the
// scene's events, inlets and outlets, and which joints have broken.
#pragma once

#include <mpi.h>

#include "core/hdf5.hpp"
#include "step/history.hpp"

namespace unibody {

// Writes the accuracy's findings, the past of events, inlets and outlets, and the joints that have broken; a run without them
// writes nothing. The function returns whether all was written, and throws std::runtime_error where HDF5 fails. It is collective.
bool write_past(MPI_Comm comm, hid_t file, const History& history);

// history.past says how many events, inlets and outlets the scene has. Throws std::runtime_error where the file says anything
// else, or what cannot be. joints: how many the scene has.
void read_past(hid_t file, std::size_t joints, History& history);

}  // namespace unibody
