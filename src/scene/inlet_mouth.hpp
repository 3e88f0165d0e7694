// Where the bodies of an inlet come in: a box, a disc, or a surface from a file.
#pragma once

#include <memory>

#include "meshes/triangle_mesh.hpp"
#include "scene/key.hpp"
#include "scene/random.hpp"
#include "scene/scene.hpp"

namespace unibody {

// Where centres may be drawn, in the entry's frame.
struct InletMouth {
  // A surface, on which each piece is as likely as its area.
  struct Face {
    TriangleMesh mesh;
    std::vector<double> areas_up_to;  // m^2, of each triangle: the sum of all up to it

    Vec3 draw(double u, double v, double w) const;  // from three numbers in [0, 1)
  };

  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, bounds; of a box all that it is
  double radius = 0;                             // m, of a disc about the origin, square to z; 0: it is none
  std::shared_ptr<const Face> face;              // null: it is none

  Vec3 draw(BodyRandom& random) const;
};

// The keys `box`, `disc` and `mesh` of an inlet, of which it has one.
std::vector<Key> inlet_mouth_keys();
InletMouth read_inlet_mouth(const KeyedMap& inlet, const Scene& scene);

}  // namespace unibody
