// Drag of the air on the triangles of cloths, along their normals.
//
// Each node's mass is shared out among its triangles in proportion to their areas. With u_n the normal velocity of a triangle's
// centre of mass against the wind, the air pushes with F = -rho/2 C A |u_n| u_n n and accelerates the triangle's share of its
// nodes as one, so that an even sheet stays flat; a node takes the mean of its triangles by those shares. Implicit in u_n: a
// triangle comes to rest against the air at most, and the kinetic energy in the frame of the wind never grows, at any
// coefficient. A pinned node feels its part of the force and stays as it is.
#pragma once

#include <span>
#include <vector>

#include "collide/surfaces.hpp"
#include "constraints/solver_body.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

class Drag {
 public:
  explicit Drag(const Scene& scene) : scene_(scene) {}

  // Whether some surface of the scene feels the air.
  bool any() const;

  // Finds the triangles that feel it; whenever slots have moved. The surfaces must be those of this world.
  void build(const World& world, const Surfaces& surfaces);

  // Changes the predicted velocities (m/s) of home bodies by what the air does in a step (s) from a time (s) on. The same bits on
  // any number of ranks: guests must hold their predicted velocities, and hold them still when this returns.
  void apply(const World& world, double time, double step, std::size_t homes, std::span<SolverBody> bodies) const;

  std::size_t bytes() const;

 private:
  struct Triangle {
    std::array<Slot, 3> nodes;
    double coefficient;  // kg/m^3, rho C / 2
    bool home;           // one of its nodes is
  };
  const Scene& scene_;
  std::vector<Triangle> triangles_;  // in the order of their nodes' ids
};

}  // namespace unibody
