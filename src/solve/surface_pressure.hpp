// Pressure on the triangles of cloths and solids.
//
// It pushes along a triangle's normal with p times its area, a third on each node, where these are at the end of the step as the
// velocities of its start have it. On a closed surface the forces sum up to zero, and so do their moments. (About the places of
// the end: with the normals of the start, what is pressed together would be turned ever faster by the lag of its own forces.)
#pragma once

#include <span>
#include <vector>

#include "collide/surfaces.hpp"
#include "constraints/solver_body.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

class SurfacePressure {
 public:
  explicit SurfacePressure(const Scene& scene) : scene_(scene) {}

  // Whether there is some on a surface of the scene.
  bool any() const;

  // Finds the triangles on which it pushes; whenever slots have moved. The surfaces must be those of this world.
  void build(const World& world, const Surfaces& surfaces);

  // Adds to the predicted velocities (m/s) of home bodies what the mean pressures of a step (s) from a time (s) on do in it.
  // The same bits on any number of ranks.
  void apply(const World& world, double time, double step, std::size_t homes, std::span<SolverBody> bodies) const;

  std::size_t bytes() const;

 private:
  struct Triangle {
    std::array<Slot, 3> nodes;
    std::int32_t surface;  // index into the scene's
  };
  const Scene& scene_;
  std::vector<Triangle> triangles_;  // in the order of their nodes' ids; of each home node all
};

}  // namespace unibody
