// Convex hulls of points: their faces, and the mass properties of the solid.
#pragma once

#include <span>
#include <string>

#include "world/shapes.hpp"

namespace unibody {

struct Hull {
  struct Face {
    Vec3 normal;                 // unit, outwards
    std::uint32_t first, count;  // into face_corners
  };
  std::vector<Vec3> corners;                // m, from the centre of mass, in principal axes
  std::vector<Face> faces;                  // corners in one plane, whatever their number
  std::vector<std::uint32_t> face_corners;  // into corners, counterclockwise as seen from outside
  Vec3 size = Vec3::Zero();                 // m, the largest of each coordinate
  double radius = 0;                        // m, of the sphere about the centre that holds it
  double smallest = 0;                      // m, the shortest edge of the box around it
  double volume = 0;                        // m^3
  Vec3 inertia = Vec3::Zero();              // m^2, principal moments per mass
  Quat frame = Quat::Identity();            // principal axes -> axes in which the points were given
  Vec3 centre = Vec3::Zero();               // m, the centre of mass among the points as given
};

// Points are in m. Throws std::invalid_argument with what was found where they span no volume: fewer than four, or all within
// 1e-6 of their extent of one plane. Corners so near to one plane are of one face, of which 48 at most are listed.
Hull make_hull(std::span<const Vec3> points);

}  // namespace unibody
