// Reads frames.h5 (report/output.hpp) back, on one rank and without MPI: for tools that look at results.
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "core/types.hpp"

namespace unibody {

class FramesFile {
 public:
  // `path`: the file, or a folder of results. Throws, as all members do, an InputError that names the file and says what was
  // expected of it, or std::runtime_error where HDF5 can't read what it holds.
  explicit FramesFile(const std::string& path);

  const std::string& path() const { return path_; }
  const std::vector<std::int64_t>& frames() const { return frames_; }  // ascending; never empty
  Id body_count() const { return body_count_; }

  // Faces of a cloth, or segments of a thread with -1 as the third corner.
  struct Cells {
    std::string name;
    int corners = 3;
    std::vector<std::array<Id, 3>> cells;
  };
  std::vector<Cells> surfaces() const;

  double time(std::int64_t frame) const;  // s
  // m, of all bodies; all finite, and 0 of those that are absent in the frame.
  void positions(std::int64_t frame, std::vector<Vec3>& out) const;

 private:
  void read_present(const std::string& name, const std::string& ids_name, std::vector<Vec3>& out) const;
  [[noreturn]] void refuse(const std::string& fault) const;
  h5::Handle open_array(const std::string& name, hsize_t rows, std::initializer_list<hsize_t> columns, H5T_class_t kind) const;

  std::string path_;
  h5::Handle file_;
  std::vector<std::int64_t> frames_;
  Id body_count_ = 0;
};

}  // namespace unibody
