// Tables of a run that goes on in its own folder.
#pragma once

#include <cstdint>
#include <string>

namespace unibody {

// Throws std::runtime_error where there is a file with another first line. Not collective.
void check_header(const std::string& path, const std::string& header);

// Keeps the lines up to a frame of a table whose first line is `header` and whose other lines begin with a frame's number; what
// a killed run left half written goes as well. Returns whether there is such a file. Throws std::runtime_error where its first
// line is another one, or the disk fails; the file is then as it was. Not collective.
bool keep_rows(const std::string& path, const std::string& header, std::int64_t last_frame);

}  // namespace unibody
