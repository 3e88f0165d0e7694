#include "meshes/mesh_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/errors.hpp"
#include "core/text.hpp"

namespace unibody {

std::string read_bytes(const std::string& path, const std::string& expected) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  // a folder can be opened, but not read
  if (!file || file.peek() == std::ifstream::traits_type::eof())
    fail_at(path, 0,
            file && !file.bad() ? "an empty file" : std::string("no readable file (") + std::strerror(errno ? errno : EIO) + ")",
            expected);
  std::string bytes;
  for (char part[1 << 16]; file.read(part, sizeof part), file.gcount() > 0;)
    bytes.append(part, static_cast<std::size_t>(file.gcount()));
  if (file.bad())
    fail_at(path, 0, std::string("a file that cannot be read to its end (") + std::strerror(errno) + ")", "a whole file");
  return bytes;
}

void fail_at(const std::string& path, std::int64_t line, const std::string& found, const std::string& expected) {
  const std::string where = line > 0 ? path + ":" + std::to_string(line) : path;
  throw InputError(one_line(where + ": found " + found + ", expected " + expected));
}

std::string quote(std::string_view text) {
  constexpr std::size_t longest = 60;
  return std::string("'").append(text.substr(0, longest)).append(text.size() > longest ? "...'" : "'");
}

}  // namespace unibody
