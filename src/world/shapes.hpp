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
};

inline constexpr std::array<std::string_view, 5> shape_names{"sphere", "box", "plane", "disc", "particle"};

struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  Vec3 size = Vec3::Zero();
};

inline bool is_round(const Shape& shape) { return shape.kind != ShapeKind::box && shape.kind != ShapeKind::plane; }

// Radius (m) of the smallest sphere about the centre that holds the shape; infinite for a plane.
double bounding_radius(const Shape& shape);

// Half edges (m) of the axis-aligned box about the centre that holds the shape turned by `orientation`; infinite for a plane.
Vec3 bounding_half_extents(const Shape& shape, const Quat& orientation);

// Volume (m^3) of a sphere, particle or box; area (m^2) of a disc (its density is then per area); 0 for a plane.
double volume(const Shape& shape);

// Principal moments of inertia (kg m^2) of the solid of mass `mass` (kg), body frame; 0 for a particle.
Vec3 inertia(const Shape& shape, double mass);

// Smallest length (m) of the shape: the diameter, or the shortest edge; infinite for a plane. L of the error measures.
double smallest_size(const Shape& shape);

}  // namespace unibody
