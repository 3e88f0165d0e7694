#include "report/xdmf_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <utility>

namespace unibody {

namespace {

constexpr std::string_view head =
    "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
    "  <Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
constexpr std::string_view tail = "  </Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfFile::~XdmfFile() { close(); }

bool XdmfFile::start(const std::string& path) {
  file_ = ::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
  end_ = static_cast<std::int64_t>(head.size());
  const std::string text = std::string(head) + std::string(tail);
  if (file_ >= 0 && ::write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) close();
  return file_ >= 0;
}

bool XdmfFile::append(const std::string& frame) {
  if (file_ < 0) return false;
  const std::string text = frame + std::string(tail);
  if (::pwrite(file_, text.data(), text.size(), end_) != static_cast<ssize_t>(text.size())) close();
  end_ += static_cast<std::int64_t>(frame.size());
  return file_ >= 0;
}

bool XdmfFile::close() { return file_ < 0 || ::close(std::exchange(file_, -1)) == 0; }

std::string xdmf_item(const std::string& file, const std::string& path, Id rows, int columns, const char* type, int precision) {
  std::string dimensions = std::to_string(rows);
  if (columns > 1) dimensions.append(" ").append(std::to_string(columns));
  return "<DataItem Dimensions=\"" + dimensions + "\" NumberType=\"" + type + "\" Precision=\"" + std::to_string(precision) +
         "\" Format=\"HDF\">" + file + ":" + path + "</DataItem>";
}

std::string xdmf_attribute(const std::string& name, const char* kind, const char* centre, const std::string& item) {
  return "      <Attribute Name=\"" + name + "\" AttributeType=\"" + kind + "\" Center=\"" + centre + "\">" + item +
         "</Attribute>\n";
}

std::string xdmf_time(double time) {
  std::array<char, 40> seconds{};
  std::snprintf(seconds.data(), seconds.size(), "%.17g", time);
  return "      <Time Value=\"" + std::string(seconds.data()) + "\"/>\n";
}

}  // namespace unibody
