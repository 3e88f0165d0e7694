// What grids and meshes have in common as cloths: the law that their links and triangles follow, and the pure functions that say
// where nodes are and what ties them together.
#pragma once

#include "meshes/triangle_mesh.hpp"
#include "scene/flexible.hpp"
#include "scene/mesh_keys.hpp"

namespace unibody {

enum class Diagonals { both, alternating, none };

struct Bending {
  bool dihedral = false;  // angles; else links across
  Spring spring;          // N/m of a link, N m/rad of an angle
};

struct Fabric {
  double youngs_modulus = 0, poissons_ratio = 0, thickness = 0;
  double damping = 0;
};

struct ClothLaw {
  double mass = 0;       // kg, of all; by area: kg/m^2
  bool by_area = false;  // a node has the mass of its share of the area; else all have the same
  Diagonals diagonals = Diagonals::both;
  std::optional<Spring> links;
  std::optional<Fabric> membrane;
  std::optional<Spring> area;  // of each triangle: its tension per relative change of area (N/m)
  std::optional<Bending> bending;
};

const Keys& grid_keys();
MeshShape grid_cloth(const Value& grid, const ClothLaw& law);
MeshShape mesh_cloth(const Value& file, const MeshScale& scale, double weld_share, const ClothLaw& law, const Scene& scene);

// Constraints at rest between nodes at these places; ids and colours are the caller's.
template <class Link>
Constraint<Link> link_at_rest(const Spring& spring, const Vec3& a, const Vec3& b) {
  Constraint<Link> c;
  c.parameters = {(a - b).norm()};
  c.compliance = {spring.compliance()}, c.damping = spring.damping;
  return c;
}
Constraint<Membrane> membrane_at_rest(const Fabric& fabric, const Vec3& a, const Vec3& b, const Vec3& c);
Constraint<Area> area_at_rest(const Spring& spring, const Vec3& a, const Vec3& b, const Vec3& c);
Constraint<Dihedral> angle_at_rest(const Spring& spring, double angle, double length);

}  // namespace unibody
