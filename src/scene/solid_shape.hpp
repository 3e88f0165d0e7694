// What blocks and tetrahedral meshes have in common as soft solids: the law that their tetrahedra follow.
#pragma once

#include <span>

#include "scene/flexible.hpp"
#include "scene/mesh_keys.hpp"

namespace unibody {

// The elasticity of the tetrahedra of a solid, or of a part of it.
struct Elasticity {
  double youngs_modulus = 0, poissons_ratio = 0;  // Pa, 1
  double damping = 0;                             // s
};

// How the energy of a tetrahedron weighs its strains: with its volume at rest, as St. Venant-Kirchhoff, or its current one.
enum class EnergyVolume { rest, current };

struct SolidLaw {
  double density = 0;  // kg/m^3
  EnergyVolume energy_volume = EnergyVolume::rest;
  Elasticity elasticity;
  std::vector<std::pair<Part, Elasticity>> regions;  // by where a tetrahedron's centroid is at the start; the last one holds
  std::optional<double> least_volume;                // of rest, that a tetrahedron is kept from falling below
  Vec3 position = Vec3::Zero();                      // of the entry's frame
  Quat orientation = Quat::Identity();

  const Elasticity& at(const Vec3& place) const;  // of the entry's frame
};

const Keys& block_keys();
MeshShape block_solid(const Value& block, const SolidLaw& law);
MeshShape mesh_solid(const Value& file, const MeshScale& scale, double weld_share, const SolidLaw& law, const Scene& scene);

struct Loads {
  std::map<Id, Vec3> constant;    // N, by node
  std::vector<PartLoad> in_time;  // by node as well
};

// Reads the forces on nodes from the entry's `loads`, a list of {within: {min, max}, force}: each force is spread over the
// triangles of the surface that lie within.
Key loads_key();
Loads read_loads(const KeyedMap& entry, const MeshShape& shape, const Nodes& nodes, const Scene& scene);

// Adds the constraints of a tetrahedron at rest with these corners, positively oriented.
void add_tetrahedron(const SolidLaw& law, const std::array<Vec3, 4>& at, const std::array<Id, 4>& ids, std::int32_t colour,
                     ConstraintSet& out);

}  // namespace unibody
