// The sections of a scene file.
#pragma once

#include <vector>

#include "scene/key.hpp"

namespace unibody {

struct Section {
  Key key;
  void (*read)(const Value& value, Scene& scene);
};

// In the order in which they are read: `planar`, `periodic` and `materials` stand before the bodies that lean on them.
const std::vector<Section>& sections();

const Keys& scene_keys();  // of the whole file

}  // namespace unibody
