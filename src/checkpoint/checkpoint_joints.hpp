// The part of a checkpoint that scenes with joints have: the joints' impulses.
#pragma once

#include <mpi.h>

#include <cstdint>

#include "core/hdf5.hpp"
#include "joints/joint_set.hpp"

namespace unibody {

// Rows in order of the joints' numbers, one a joint; this rank's share, from row `first` on.
struct JointRowBlock {
  std::int64_t count = 0, first = 0;  // of all joints; of this rank's
  std::vector<JointImpulses> rows;
};

// joints: null: the scene has none. impulses: of each that is here. Collective.
JointRowBlock joint_row_block(MPI_Comm comm, const JointInput* joints, std::span<const JointImpulses> impulses);

// Writes data set `joints` where there are any; false: the disk fails. Collective.
[[nodiscard]] bool write_joint_rows(hid_t file, const JointRowBlock& block);

// The impulses of the joints that are here. Throws std::runtime_error where the table is not what it should be.
std::vector<JointImpulses> read_joint_impulses(hid_t file, const JointList& list);

}  // namespace unibody
