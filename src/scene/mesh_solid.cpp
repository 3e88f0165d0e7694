#include "scene/solid_shape.hpp"
namespace unibody {
MeshShape mesh_solid(const Value& file, double, const SolidLaw&, const Scene&) { file.fail_expected("a block"); }
}  // namespace unibody
