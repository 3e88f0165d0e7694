#include "solve/surface_pressure.hpp"

#include <algorithm>

#include "core/capacity.hpp"
#include "solve/surface_triangles.hpp"

namespace unibody {

bool SurfacePressure::any() const {
  return std::ranges::any_of(scene_.surfaces, [](const Surface& s) { return s.pressure.largest() > 0; });
}

void SurfacePressure::build(const World& world, const Surfaces& surfaces) {
  triangles_.clear();
  for (const SurfaceFace& face : surfaces.faces)
    if (scene_.surfaces[static_cast<std::size_t>(face.surface)].pressure.largest() > 0)
      triangles_.push_back({face.nodes, face.surface});
  sort_by_ids(world, triangles_);
}

void SurfacePressure::apply(const World& world, double time, double step, std::size_t homes, std::span<SolverBody> bodies) const {
  std::vector<double> pressures;  // Pa
  for (const Surface& surface : scene_.surfaces) pressures.push_back(surface.pressure.mean(time, time + step));
  for (const Triangle& t : triangles_) {
    const Vec3 impulse = step * pressures[static_cast<std::size_t>(t.surface)] / 6 * doubled_area(world, t, step);  // of a node
    for (const Slot s : t.nodes) {
      const auto i = static_cast<std::size_t>(s);
      if (i < homes) Eigen::Map<Vec3>(bodies[i].v) += bodies[i].inverse_mass * impulse;
    }
  }
}

std::size_t SurfacePressure::bytes() const { return bytes_of(triangles_); }

}  // namespace unibody
