#include "scene/mesh_keys.hpp"

#include "meshes/weld.hpp"

namespace unibody {

namespace keys {

Key scale() { return number("scale", "", positive, 1, "factor on the lengths of a mesh from a file"); }

Key up() { return choice("up", {"z", "y"}, "z", "which axis of a mesh from a file points up: its y axis becomes z"); }

Key weld() {
  return number("weld", "", {0, 0.1}, usual_weld,
                "nodes of a mesh from a file are one where they are nearer to each other than this share of its longest side; 0: "
                "none");
}

}  // namespace keys

void MeshScale::apply(std::vector<Vec3>& nodes) const {
  for (Vec3& x : nodes) {
    if (y_is_up) x = Vec3(x.x(), -x.z(), x.y());
    x *= factor;
  }
}

MeshScale read_mesh_scale(const KeyedMap& entry) { return {entry.number("scale"), entry.choice("up") == 1}; }

double read_weld(const KeyedMap& entry, const char* mesh) {
  if (!entry.has(mesh)) entry.none_of({"weld"}, "without a mesh from a file");
  return entry.number("weld");
}

}  // namespace unibody
