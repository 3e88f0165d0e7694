#include "meshes/msh_input.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "meshes/mesh_file.hpp"

namespace unibody {

static_assert(std::endian::native == std::endian::little, "binary numbers are taken as they stand");

namespace {

constexpr std::string_view between_words = " \t\r\v\f";

std::string_view trimmed(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(between_words), line.size()));
  return line.substr(0, line.find_last_not_of(between_words) + 1);
}

}  // namespace

MshInput::MshInput(const std::string& path) : path_(path), bytes_(read_bytes(path, "a mesh in Gmsh's format")) {}

void MshInput::fail(const std::string& found, const std::string& expected, std::size_t mark) const {
  if (binary) fail_at(path_, 0, found + " at byte " + std::to_string(mark), expected);
  fail_at(path_, 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(mark), '\n'), found, expected);
}

std::string_view MshInput::line() {
  std::string_view text;
  while (text.empty() && at_ < bytes_.size()) {
    mark_ = at_;
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    text = trimmed(std::string_view(bytes_).substr(at_, end - at_));
    at_ = std::min(end + 1, bytes_.size());
  }
  return text;
}

void MshInput::end_text_line() {
  mark_ = at_ = std::min(bytes_.find_first_not_of(between_words, at_), bytes_.size());
  if (at_ == bytes_.size()) return;
  if (bytes_[at_] != '\n') fail(quote(line()), "the end of the line");
  ++at_;
}

void MshInput::skip_past(const std::string& end) {
  const std::size_t start = mark_;
  for (std::size_t found = bytes_.find("\n" + end, at_ - 1); found != std::string::npos;
       found = bytes_.find("\n" + end, found + 1)) {
    at_ = found + 1;
    if (line() == end) return;
  }
  fail("a section without end", "'" + end + "'", start);
}

std::string_view MshInput::word(const char* what) {
  mark_ = at_ = std::min(bytes_.find_first_not_of(between_words, at_), bytes_.size());
  if (at_ == bytes_.size()) fail("the end of the file", what);
  if (bytes_[at_] == '\n') fail("the end of the line", what);
  const std::size_t end = std::min(bytes_.find_first_of(" \t\r\v\f\n", at_), bytes_.size());
  at_ = end;
  return std::string_view(bytes_).substr(mark_, end - mark_);
}

template <class Number>
Number MshInput::text_number(const char* what) {
  const std::string_view text = word(what);
  Number number = 0;
  if (!parse(text, number)) fail(quote(text), what);
  return number;
}

double MshInput::real(const char* what) {
  double x = 0;
  if (binary) {
    std::memcpy(&x, take(sizeof x, what), sizeof x);
  } else {
    x = text_number<double>(what);
  }
  if (!std::isfinite(x)) fail(std::isnan(x) ? "nan" : "an infinite number", what);
  return x;
}

std::int64_t MshInput::text_whole(const char* what) { return text_number<std::int64_t>(what); }

std::int64_t MshInput::whole(int bytes, const char* what) {
  if (!binary) return text_whole(what);
  std::int64_t wide = 0;
  std::int32_t narrow = 0;
  if (bytes == 8) {
    std::memcpy(&wide, take(sizeof wide, what), sizeof wide);
    return wide;
  }
  std::memcpy(&narrow, take(sizeof narrow, what), sizeof narrow);
  return narrow;
}

const char* MshInput::take(std::size_t bytes, const char* what) {
  mark_ = at_;
  if (bytes > bytes_.size() - at_) fail("the end of the file", what);
  at_ += bytes;
  return bytes_.data() + mark_;
}

}  // namespace unibody
