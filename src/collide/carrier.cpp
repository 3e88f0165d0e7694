#include "collide/carrier.hpp"

#include <algorithm>

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

// Of the smallest size: how far around a point its surface is looked at, and how far below. A tilt of up to a thousandth counts
// as flat; what is round with the radius of that size sinks by ten times as much.
constexpr double around = 0.02, below = 2e-5;

bool holds(const Shape& shape, const Vec3& point) {
  if (shape.kind != ShapeKind::compound) return type_of(shape.kind).convex->contains(shape, point);
  return std::ranges::any_of(shape_library().compounds[shape.data].parts, [&](const Compound::Part& part) {
    return type_of(part.shape.kind).convex->contains(part.shape, part.turn.conjugate() * (point - part.place));
  });
}

// Whether a body's surface is flat around one of its points, of which `outwards` leads away.
bool is_flat(const World& world, const Manifold& m, Slot slot, const Vec3& point, const Vec3& outwards) {
  const auto i = static_cast<std::size_t>(slot);
  const Shape& shape = world.properties[i].shape;
  if (shape.kind == ShapeKind::plane || shape.kind == ShapeKind::mesh) return true;
  if (is_round(shape) || shape.kind == ShapeKind::particle) return false;
  const double size = smallest_size(shape);
  const Quat to_body = world.orientation_of(i).conjugate();
  const Vec3 inside = point - below * size * outwards - place_of(world, m, slot);
  const Vec3 s = outwards.unitOrthogonal(), t = outwards.cross(s);
  return std::ranges::all_of(std::array{s, Vec3(-s), t, Vec3(-t)},
                             [&](const Vec3& side) { return holds(shape, to_body * (inside + around * size * side)); });
}

}  // namespace

double share_of_first(const World& world, const Manifold& m, const ContactPoint& point) {
  const Vec3 half_gap = 0.5 * point.gap * m.normal;
  const bool flat_a = is_flat(world, m, m.slot_a, point.position + half_gap, -m.normal);
  const bool flat_b = is_flat(world, m, m.slot_b, point.position - half_gap, m.normal);
  if (flat_a != flat_b) return flat_a ? 0 : 1;
  const auto moves = [&](Slot s) { return world.properties[static_cast<std::size_t>(s)].is_dynamic(); };
  return moves(m.slot_a) == moves(m.slot_b) ? 0.5 : moves(m.slot_a) ? 1 : 0;
}

}  // namespace unibody
