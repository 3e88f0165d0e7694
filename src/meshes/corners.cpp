#include "meshes/corners.hpp"

namespace unibody {

bool is_convex(std::span<const Vec3> polygon) {
  const std::size_t n = polygon.size();
  const auto twice_area = [&](std::size_t i, std::size_t j, std::size_t k) -> Vec3 {
    return (polygon[j % n] - polygon[i % n]).cross(polygon[k % n] - polygon[i % n]);
  };
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 2; i < n; ++i) normal += twice_area(0, i - 1, i);
  if (!(normal.squaredNorm() > 0)) return false;  // as much turns left as right
  const double straight = -1e-9 * normal.squaredNorm();
  for (std::size_t i = 0; i < n; ++i) {
    if (!(twice_area(i, i + 1, i + 2).dot(normal) >= straight)) return false;
    if (i >= 2 && !(twice_area(0, i - 1, i).dot(normal) >= straight)) return false;
  }
  return true;
}

}  // namespace unibody
