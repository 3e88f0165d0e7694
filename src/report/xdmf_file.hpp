// An XDMF file of a run's frames, which readers such as ParaView open: it says what lies where in an HDF5 file beside it. It is
// whole after each frame.
#pragma once

#include <cstdint>
#include <string>

#include "core/types.hpp"

namespace unibody {

// Not collective: one rank writes. Members say whether the disk took it, and do nothing more once it did not.
class XdmfFile {
 public:
  XdmfFile() = default;
  ~XdmfFile();
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;

  bool start(const std::string& path);    // a new file, in the place of one that is there
  bool append(const std::string& frame);  // the grids of one frame
  bool close();                           // nothing may follow

 private:
  int file_ = -1;         // file descriptor
  std::int64_t end_ = 0;  // where the closing tags start
};

// An array of an HDF5 file, by its path there. precision: bytes a number.
std::string xdmf_item(const std::string& file, const std::string& path, Id rows, int columns, const char* type, int precision);
// kind: Scalar, Vector, Matrix; centre: Node, Cell.
std::string xdmf_attribute(const std::string& name, const char* kind, const char* centre, const std::string& item);
std::string xdmf_time(double time);  // s

}  // namespace unibody
