// Shapes of rigid bodies, as plain data. A shape is centred at its centre of mass, its axes are its principal axes of inertia.
#pragma once

#include <array>
#include <string_view>

#include "core/types.hpp"

namespace unibody {

enum class ShapeKind : std::uint8_t {
  sphere,    // size.x = radius (m)
  box,       // size = half edge lengths (m)
  plane,     // half space below the body's local z axis through its position; static only
  disc,      // size.x = radius (m); planar scenes only, the axis is y
  particle,  // size.x = radius (m) at which it touches; a point mass: it does not turn
  capsule,   // size = radius, radius, half of the length with both caps (m); the axis is z
  cylinder,  // size = radius, radius, half of the length (m); the axis is z
  hull,      // size = largest coordinates (m); the convex solid of this number in the library
  compound,  // the same; shapes that move as one
  mesh,      // the same; a surface of triangles, touched from outside; static only
};

inline constexpr std::array<std::string_view, 10> shape_names{"sphere",  "box",      "plane", "disc",     "particle",
                                                              "capsule", "cylinder", "hull",  "compound", "mesh"};

struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  std::uint32_t data = 0;  // place in the library (shape_library.hpp) of a shape that needs more than three lengths
  Vec3 size = Vec3::Zero();

  Shape() = default;
  Shape(ShapeKind of_kind, const Vec3& of_size, std::uint32_t of_data = 0) : kind(of_kind), data(of_data), size(of_size) {}
};

// A sphere, disc or particle.
inline bool is_round(const Shape& shape) {
  return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::disc || shape.kind == ShapeKind::particle;
}

// Radius (m) of a sphere about the centre that holds the shape; infinite for a plane.
double bounding_radius(const Shape& shape);

// Half edges (m) of an axis-aligned box about the centre that holds the shape turned by `orientation`; infinite for a plane.
Vec3 bounding_half_extents(const Shape& shape, const Quat& orientation);
Vec3 bounding_half_extents(const Shape& shape, const Mat3& rotation);

// Volume (m^3) of a solid; area (m^2) of a disc (its density is then per area); 0 for a plane.
double volume(const Shape& shape);

// Principal moments of inertia (kg m^2) of the solid of mass `mass` (kg), body frame; 0 for a particle.
Vec3 inertia(const Shape& shape, double mass);

// Smallest length (m) of the shape: the diameter, or the shortest edge of the box around it; infinite for a plane. L of the error
// measures.
double smallest_size(const Shape& shape);

// m, R of two bodies that touch, 1/R = 1/R_a + 1/R_b, with 1/R of what is not round 0: the radius of the ball that touches a
// plane as the two touch each other. 0 where neither of them is round.
double reduced_radius(const Shape& a, const Shape& b);

// The turn from the body's axes to those in which the shape is given: of a hull or a compound. Else none.
Quat frame_of(const Shape& shape);

// Whether it is made of many that touch one by one: a compound or a mesh.
inline bool is_composite(ShapeKind kind) { return kind == ShapeKind::compound || kind == ShapeKind::mesh; }

}  // namespace unibody
