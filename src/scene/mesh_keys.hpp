// The keys of entries that read a mesh from a file.
#pragma once

#include "scene/key.hpp"

namespace unibody {

namespace keys {

Key scale();  // of a mesh's lengths
Key up();
Key weld();

}  // namespace keys

// What becomes of the nodes of a mesh from a file, by the keys `scale` and `up`.
struct MeshScale {
  double factor = 1;
  bool y_is_up = false;  // then its y axis becomes the scene's z, and its -z the scene's y

  void apply(std::vector<Vec3>& nodes) const;
};
MeshScale read_mesh_scale(const KeyedMap& entry);

// Reads how far nodes are welded in an entry whose mesh has the key `mesh`, as a share of the mesh's extent (meshes/weld.hpp);
// 0: nothing is welded.
double read_weld(const KeyedMap& entry, const char* mesh);

}  // namespace unibody
