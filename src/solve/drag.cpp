#include "solve/drag.hpp"

#include <algorithm>
#include <cmath>

#include "core/capacity.hpp"
#include "solve/surface_triangles.hpp"

namespace unibody {

namespace {

// The loss of a step from speed s to s' with s - s' = k p s'^2, per p: s (1 - s'/s) / p. The bound keeps its square finite.
double loss(double speed, double k, double part) {
  const double x = std::min(1e300, 4 * k * part * speed), root = std::sqrt(1 + x);
  return speed * x / ((1 + root) * (1 + root)) / part;
}

}  // namespace

bool Drag::any() const {
  return scene_.air_density > 0 &&
         std::any_of(scene_.surfaces.begin(), scene_.surfaces.end(), [](const Surface& s) { return s.drag > 0; });
}

void Drag::build(const World& world, const Surfaces& surfaces) {
  triangles_.clear();
  for (const SurfaceFace& face : surfaces.faces) {
    const double drag = scene_.surfaces[static_cast<std::size_t>(face.surface)].drag;
    if (drag > 0) triangles_.push_back({face.nodes, 0.5 * scene_.air_density * drag, face.home});
  }
  sort_by_ids(world, triangles_);
}

void Drag::apply(const World& world, double time, double step, std::size_t homes, std::span<SolverBody> bodies) const {
  std::vector<double> area(world.size(), 0);  // m^2, of all triangles at a node; complete at the nodes of homes' triangles
  for (const Triangle& t : triangles_)
    for (const Slot s : t.nodes) area[static_cast<std::size_t>(s)] += 0.5 * doubled_area(world, t).norm();
  const Vec3 wind = scene_.wind.mean(time, time + step);
  std::vector<Vec3> change(homes, Vec3::Zero());
  for (const Triangle& t : triangles_) {
    const Vec3 normal = doubled_area(world, t);
    const double length = normal.norm();
    if (!t.home || !(length > 0)) continue;
    Vec3 momentum = Vec3::Zero();
    double mass = 0, movable = 0;  // kg/m^2, of the nodes' shares
    for (const Slot s : t.nodes) {
      const auto i = static_cast<std::size_t>(s);
      const double share = world.properties[i].mass / area[i];
      momentum += share * Eigen::Map<const Vec3>(bodies[i].v), mass += share;
      if (bodies[i].inverse_mass > 0) movable += share;
    }
    if (!(movable > 0)) continue;
    const Vec3 n = normal / length;
    const double speed = n.dot(momentum / mass - wind);
    const double lost = loss(std::abs(speed), step * t.coefficient / mass, movable / mass);
    for (const Slot s : t.nodes) {
      const auto i = static_cast<std::size_t>(s);
      if (i < homes && bodies[i].inverse_mass > 0) change[i] -= (0.5 * length / area[i] * std::copysign(lost, speed)) * n;
    }
  }
  for (std::size_t i = 0; i < homes; ++i) Eigen::Map<Vec3>(bodies[i].v) += change[i];
}

std::size_t Drag::bytes() const { return bytes_of(triangles_); }

}  // namespace unibody
