#include "scene/weld_key.hpp"

#include "meshes/weld.hpp"

namespace unibody {

double read_weld(const Value& entry, const char* mesh) {
  const Value* value = entry.find("weld");
  if (!value) return usual_weld;
  if (!entry.find(mesh)) value->fail_expected("no such key without a mesh from a file");
  return value->number({0, 0.1}, "of the mesh's extent");
}

}  // namespace unibody
