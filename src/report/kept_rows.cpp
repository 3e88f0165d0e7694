#include "report/kept_rows.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "core/disk.hpp"

namespace unibody {

namespace {

bool is_of_frame(const std::string& line, std::int64_t last_frame) {
  std::int64_t frame = 0;
  const char* end = line.data() + line.size();
  const auto [next, error] = std::from_chars(line.data(), end, frame);
  return error == std::errc() && next != end && *next == ',' && frame <= last_frame;
}

}  // namespace

void check_header(const std::string& path, const std::string& header) {
  std::ifstream file(path);
  std::string line;
  if (std::getline(file, line) && line != header)
    throw std::runtime_error("'" + path + "' has other columns than this run writes: choose another output directory");
}

bool keep_rows(const std::string& path, const std::string& header, std::int64_t last_frame) {
  std::ifstream old(path);
  std::string line;
  if (!std::getline(old, line)) return false;
  check_header(path, header);
  const std::string part = path + ".part";
  std::ofstream kept(part);
  kept << header << '\n';
  // A line without its end is one that was being written.
  while (std::getline(old, line) && !old.eof())
    if (is_of_frame(line, last_frame)) kept << line << '\n';
  kept.close();
  if (!kept) throw std::runtime_error("cannot write '" + part + "': is the disk full?");
  publish_file(part, path);
  return true;
}

}  // namespace unibody
