#include "report/damaged_files.hpp"

#include <array>
#include <filesystem>
#include <stdexcept>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/hdf5.hpp"
#include "report/frame_group.hpp"

namespace unibody {

namespace {

namespace fs = std::filesystem;

// Why the file cannot be read; empty: it can.
std::string damage_of(const fs::path& path) {
  const h5::Quiet quiet;
  try {
    const h5::Handle file = h5::open_file(path.string());
    const h5::Handle frames(H5Gopen2(file, "frames", H5P_DEFAULT), H5Gclose, "open group frames");
    for (const std::int64_t frame : h5::member_numbers(file, "frames")) {
      const h5::Handle object(H5Oopen(frames, h5::numbered(frame).c_str(), H5P_DEFAULT), H5Oclose,
                              "open frame " + std::to_string(frame));
      static_cast<void>(h5::read_double(object, "time"));
    }
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return {};
}

// After mending what a kill left. Why the file cannot be read even so; empty: it can.
std::string mended(const fs::path& path) {
  try {
    FrameGroup::mend(path.string());
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return damage_of(path);
}

fs::path free_name(const fs::path& path) {
  const std::string begin = (path.parent_path() / path.stem()).string() + "-damaged", end = path.extension().string();
  fs::path name = begin + end;
  for (int k = 2; fs::exists(name); ++k) name = begin + "-" + std::to_string(k) + end;
  return name;
}

}  // namespace

std::vector<std::string> set_aside_damaged_files(MPI_Comm comm, const std::string& directory) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::vector<std::string> warnings;
  std::string fault;
  if (rank == 0) try {
      for (const char* name : std::array{"frames.h5", "joints.h5", "contacts.h5"}) {
        const fs::path path = fs::path(directory) / name;
        const std::string damage = fs::exists(path) ? mended(path) : "";
        if (damage.empty()) continue;
        const fs::path kept = free_name(path);
        fs::rename(path, kept);
        warnings.push_back("'" + path.string() + "' is damaged (" + damage +
                           "), as a kill in the middle of a write may leave it: it is now '" + kept.string() +
                           "', and a new file begins with the frame of the checkpoint");
      }
    } catch (const fs::filesystem_error& e) {
      fault = std::string("cannot rename a damaged file: ") + e.what();
    }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw RunError(fault);
  return warnings;
}

}  // namespace unibody
