// The one error measure for every program: how deep bodies stand in each other, from their poses alone.
// Depths are positive; per pair of bodies there is one, that of the deepest place.
#pragma once

#include <vector>

#include "bodies.hpp"

namespace rivals {

// One body's shape where it stands.
struct Placed {
  Shape shape;
  Vec3 size;
  Vec3 position;
  Eigen::Matrix3d axes;  // columns: the body's axes in the world
};
Placed place(const Bodies& bodies, const Frame& frame, std::size_t i);

// Penetration depth (m) of two bodies, 0 where they are apart. Boxes: the smallest overlap over the 15 separating axes.
// Sphere and box: how far the sphere must move out through the nearest face. With a plane: the depth of the deepest point.
// Discs count as spheres, which in a planar scene they equal. Two planes: 0.
double depth(const Placed& a, const Placed& b);

struct FrameErrors {
  double rms = 0, l2 = 0, max = 0;  // m, over all depths > 0: L2 = sqrt(sum d^2), RMS = L2 / sqrt(count)
  long count = 0;                   // of depths > 0
  double kinetic = 0;               // J per dynamic body
  double height = 0;                // m, mean z of the dynamic bodies
  double spread = 0;                // m, root of the mean of x^2 + y^2
  long lost = 0;                    // dynamic bodies that are not finite or whose centre is behind a plane
};
FrameErrors measure(const Bodies& bodies, const Frame& frame);

// Of a whole run. Settled: medians over the last 100 frames recorded; peak: the largest of all frames.
struct RunErrors {
  FrameErrors settled;
  double peak_l2 = 0, peak_max = 0;
  long frames = 0;
};
RunErrors summarise(const std::vector<FrameErrors>& frames);

}  // namespace rivals
