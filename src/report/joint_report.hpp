// What joints do, for report.csv and for those who come for the forces.
#pragma once

#include <mpi.h>

#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "joints/joint_set.hpp"
#include "report/frame_group.hpp"
#include "report/stretch.hpp"

namespace unibody {

// Columns that say how far joints are open (m) and turned apart (rad): the largest, and the root mean square over all joints. A
// joint with a compliance opens and turns as its law says, so it counts as closed; the residual tells whether the law holds.
// Damping without compliance only slows how an opening closes. The list is empty where the scene has no joints. here: the joints
// of this rank, in the order of `slots` and `states`; residual: m, of the step. Collective; the same bits on any number of ranks.
std::vector<NamedValue> joint_columns(MPI_Comm comm, std::span<const Joint> joints, const JointList& here,
                                      std::span<const JointSlots> slots, std::span<const JointState> states, double residual);

// joints.csv and joints.h5: what each joint does, frame by frame, in order of its number.
class JointFiles {
 public:
  // Members are collective and throw RunError on every rank where the disk fails; rank 0 writes.
  // kept_to: where the files are there, their frames up to this one stay; -1: none does.
  JointFiles(MPI_Comm comm, const std::string& directory, std::span<const Joint> joints, std::int64_t kept_to = -1);
  ~JointFiles();
  JointFiles(const JointFiles&) = delete;
  JointFiles& operator=(const JointFiles&) = delete;

  // Writes the frame's rows for this rank's joints.
  void write(std::int64_t frame, double time, const JointList& list, std::span<const JointSlots> slots,
             std::span<const JointState> states);
  void close();                                                                              // nothing may follow
  bool holds(std::int64_t frame) const { return std::ranges::binary_search(kept_, frame); }  // since before this run

 private:
  struct Row;
  bool open_table(std::int64_t kept_to);  // true: it goes on with a table that is there
  void open_file(std::int64_t kept_to);
  void write_rows(std::int64_t frame, double time, const std::vector<Row>& rows);

  MPI_Comm comm_;
  int rank_ = 0;
  std::string directory_;
  std::span<const Joint> joints_;
  std::vector<std::int64_t> kept_;  // frames, ascending
  std::FILE* csv_ = nullptr;
  h5::Handle h5_;
  FrameGroup frames_;
};

}  // namespace unibody
