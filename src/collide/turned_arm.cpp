#include "collide/turned_arm.hpp"

#include <cmath>

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr double near = 1e-3;  // of the smallest size

// Whether a point of a convex shape's frame lies where the shape reaches furthest in a direction.
bool is_furthest(const Shape& shape, const Vec3& point, const Vec3& outwards) {
  const ConvexFunctions& convex = *type_of(shape.kind).convex;
  const double slack = near * smallest_size(shape);
  const double reach = outwards.dot(convex.support(shape, outwards)) + convex.rounding(shape);
  return std::abs(reach - outwards.dot(point)) < slack && convex.contains(shape, (1 - near) * (point - slack * outwards));
}

// The least turn that leads a direction to where `turn` leads it: what is the same all around it does not show the rest.
Mat3 swing_of(const Mat3& turn, const Vec3& axis) { return Quat::FromTwoVectors(axis, turn * axis).toRotationMatrix(); }

}  // namespace

Vec3 turned_arm(const World& world, Slot slot, const Vec3& arm, const Vec3& outwards, const Mat3& turn) {
  const auto i = static_cast<std::size_t>(slot);
  const Shape& shape = world.properties[i].shape;
  const Mat3 R = world.orientation_of(i).toRotationMatrix();
  // Of a part in place; whether it is the one that is touched.
  const auto turned_with = [&](const Shape& part, const Vec3& place, const Mat3& axes, Vec3& result) {
    const ConvexFunctions* convex = type_of(part.kind).convex;
    const bool is_cylinder = part.kind == ShapeKind::cylinder;
    if (!convex || !(is_cylinder || convex->rounding(part) > 0)) return false;
    if (!is_furthest(part, axes.transpose() * (arm - place), axes.transpose() * outwards)) return false;
    const Vec3 offset = convex->rounding(part) * outwards;
    result =
        is_cylinder ? Vec3(turn * place + swing_of(turn, axes.col(2)) * (arm - place)) : Vec3(turn * (arm - offset) + offset);
    return true;
  };
  Vec3 result = turn * arm;
  if (shape.kind != ShapeKind::compound) {
    turned_with(shape, Vec3::Zero(), R, result);
    return result;
  }
  for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
    if (turned_with(part.shape, R * part.place, R * part.turn.toRotationMatrix(), result)) break;
  return result;
}

}  // namespace unibody
