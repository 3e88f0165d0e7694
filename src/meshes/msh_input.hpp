// The words of a Gmsh file, or the numbers of its binary form, one after the other.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace unibody {

class MshInput {
 public:
  explicit MshInput(const std::string& path);

  bool binary = false;  // the numbers of whole() and real() are binary; lines and words are text in any case

  // Where the last thing that was read begins; fail() names its line, or its byte in a binary file.
  std::size_t mark() const { return mark_; }
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const { fail(found, expected, mark_); }
  [[noreturn]] void fail(const std::string& found, const std::string& expected, std::size_t mark) const;

  // The next line that isn't blank, without blanks around it; empty at the end of the file.
  std::string_view line();
  // To be called after the last number of a line: throws where more stands in it.
  void end_line() {
    if (!binary) end_text_line();
  }
  // Goes on after the line `end`.
  void skip_past(const std::string& end);

  // The next number of this line; `what` tells what it is. In binary data an integer has so many bytes.
  std::int64_t whole(int bytes, const char* what);
  double real(const char* what);  // a finite one
  std::string_view word(const char* what);
  std::int64_t text_whole(const char* what);
  void end_text_line();

 private:
  const std::string path_, bytes_;
  std::size_t at_ = 0, mark_ = 0;

  template <class Number>
  Number text_number(const char* what);
  const char* take(std::size_t bytes, const char* what);
};

}  // namespace unibody
