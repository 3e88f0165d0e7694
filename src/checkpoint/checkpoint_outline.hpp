// What a checkpoint tells of the scene that wrote it: which entry made which bodies. A run of another scene finds by it the
// bodies that it goes on with.
#pragma once

#include <mpi.h>

#include <array>
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
  // A joint that has broken: the two bodies, of which the second may be -1, the world; what kind of joint it was.
  struct BrokenJoint {
    std::array<Id, 2> ids{-1, -1};
    int kind = 0;
  };
  bool planar = false;
  bool lacks_bodies = false;           // since the checkpoint that the scene's run went on from lacked them
  std::vector<std::string> materials;  // by number
  std::vector<Entry> entries;          // ascending ids
  std::vector<BrokenJoint> broken;
};

// Writes the outline into a checkpoint that is open for writing. Returns false where the disk fails. Collective.
[[nodiscard]] bool write_outline(MPI_Comm comm, hid_t file, const SceneOutline& outline);

// Throws std::runtime_error where the file has none, as those of earlier versions, or one that is none of `bodies` bodies. Not
// collective.
SceneOutline read_outline(hid_t file, Id bodies);

}  // namespace unibody
