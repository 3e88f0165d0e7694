#include "scene/mesh_keys.hpp"

#include "meshes/weld.hpp"

namespace unibody {

namespace keys {

Key scale() { return number("scale", "", positive, 1, "factor on the lengths of a mesh from a file"); }

Key weld() {
  return number("weld", "", {0, 0.1}, usual_weld,
                "nodes of a mesh from a file are one where they are nearer to each other than this share of its longest side; 0: "
                "none");
}

}  // namespace keys

double read_weld(const KeyedMap& entry, const char* mesh) {
  if (!entry.has(mesh)) entry.none_of({"weld"}, "without a mesh from a file");
  return entry.number("weld");
}

}  // namespace unibody
