// Scenes from text, for the tests of the reader.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "scene/scene.hpp"

namespace unibody {

// A file that lives as long as the object.
class TextFile {
 public:
  explicit TextFile(const std::string& text, const std::string& ending = ".yaml") {
    static int number = 0;
    path_ = ::testing::TempDir() + "scene_" + std::to_string(getpid()) + "_" + std::to_string(number++) + ending;
    std::ofstream(path_) << text;
  }
  ~TextFile() { std::remove(path_.c_str()); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline Scene scene_from(const std::string& text, const std::vector<Override>& overrides = {}) {
  return read_scene(TextFile(text).path(), overrides);
}

// The message of the InputError, with FILE and FOLDER in place of the file's name and folder; "" if there was none.
inline std::string fault_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  const TextFile file(text);
  try {
    read_scene(file.path(), overrides);
  } catch (const InputError& error) {
    std::string message = error.what();
    if (message.rfind(file.path(), 0) == 0) message.replace(0, file.path().size(), "FILE");
    const std::string folder = ::testing::TempDir();
    if (const auto at = message.find(folder); at != std::string::npos && message.find("FILE") == 0)
      message.replace(at, folder.size(), "FOLDER/");
    return message;
  }
  return "";
}

inline const std::string ball = "bodies:\n  - shape: {sphere: {radius: 0.1}}\n    mass: 2\n";

}  // namespace unibody
