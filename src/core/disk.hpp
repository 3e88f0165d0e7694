// What HDF5 does not do for a file that must survive: finding out about a full disk before writing, and forcing bytes to it.
#pragma once

#include <cstdint>
#include <string>

namespace unibody {

// Reserves `bytes` behind the end of the file, which keeps its size; makes the file if there is none. Throws std::runtime_error
// if the disk, a quota or a limit of this process has no room. HDF5 does not survive a failed write: ask before it starts one.
void reserve_on_disk(const std::string& path, std::int64_t bytes);

// Forces the file to the disk, gives it its final name, and forces that. Throws std::runtime_error.
void publish_file(const std::string& temporary, const std::string& path);

}  // namespace unibody
