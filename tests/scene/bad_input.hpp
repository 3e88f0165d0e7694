// One fault in a scene file: what stands there, and the whole message that it must give.
#pragma once

#include "scene/scene_text.hpp"

namespace unibody {

struct BadInput {
  const char* name;
  std::string text;
  std::string message;
  std::vector<Override> overrides = {};
};

inline void PrintTo(const BadInput& bad, std::ostream* out) { *out << bad.name; }
inline std::string case_name(const testing::TestParamInfo<BadInput>& info) { return info.param.name; }

inline std::string with_body(const std::string& rest) { return "bodies:\n  - shape: {sphere: {radius: 1}}\n    " + rest + "\n"; }

}  // namespace unibody
