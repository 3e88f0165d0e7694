// What a checkpoint tells of its scene: whose its bodies are. A run of another scene finds its own among them by it.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "core/types.hpp"

namespace unibody {

struct SceneOutline {
  // Bodies of consecutive ids that one entry of the scene made.
  struct Entry {
    Id first = 0, count = 0;
    std::string name;  // may be empty
  };
  bool planar = false;
  std::vector<std::string> materials;  // by number
  std::vector<Entry> entries;          // ascending ids
};

// Writes the outline into an open checkpoint. Returns whether the disk took it. Collective.
[[nodiscard]] bool write_outline(MPI_Comm comm, hid_t file, const SceneOutline& outline);

// Throws std::runtime_error where the file has none, as those of earlier versions, or one that is none of `bodies` bodies. Not
// collective.
SceneOutline read_outline(hid_t file, Id bodies);

}  // namespace unibody
