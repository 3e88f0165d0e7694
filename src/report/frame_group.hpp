// The group /frames of a result file, which has an object for each frame, named by the frame's number.
//
// HDF5 keeps the names of a group in several places of the file and changes one after the other, so that a run killed between two
// of them leaves a group that nothing can read. Beside the file there is therefore a list of where each frame lies, PATH.links:
// a frame is on the disk before the list has it, the list has it before the group does, and "=" follows when the group is whole
// again. A list that does not end so tells the next run to make the group anew from it. The list is removed with close().
#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/hdf5.hpp"

namespace unibody {

// Members are collective over the ranks that have the file open, but for holds(), and throw std::runtime_error where HDF5 or the
// disk fails, unless they return whether all went well.
class FrameGroup {
 public:
  // Makes the group in a new file.
  void create(MPI_Comm comm, hid_t file, const std::string& path);
  // Opens the group of a file that is there, and takes the frames after `kept_to` out of it.
  void extend(MPI_Comm comm, hid_t file, const std::string& path, std::int64_t kept_to);

  // Names an object of the file that has no name yet: a frame that is written.
  [[nodiscard]] bool add(hid_t object, std::int64_t frame);
  [[nodiscard]] bool close();
  void let_go() { static_cast<void>(group_.close()); }  // where a run ends by a fault: the list stays

  operator hid_t() const { return group_; }
  const std::vector<std::int64_t>& kept() const { return kept_; }  // the frames that were there before this run, ascending
  bool holds(std::int64_t frame) const { return std::ranges::binary_search(kept_, frame); }

  // Of one rank, before the file is opened. Where its list says that a run was killed while it changed the group, makes the group
  // anew; returns whether it did.
  static bool mend(const std::string& path);

 private:
  bool note(const std::string& text);  // rank 0: adds to the list
  bool is_first() const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  hid_t file_ = H5I_INVALID_HID;
  h5::Handle group_;
  std::string list_;  // path
  std::vector<std::int64_t> kept_;
};

}  // namespace unibody
