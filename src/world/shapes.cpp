#include "world/shapes.hpp"

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

// All kinds of shapes, in the order of ShapeKind.
constexpr const ShapeType* shape_types[] = {&sphere_type,  &box_type,      &plane_type, &disc_type,     &particle_type,
                                            &capsule_type, &cylinder_type, &hull_type,  &compound_type, &mesh_type};
static_assert(std::size(shape_types) == shape_names.size());

}  // namespace

const ShapeType& type_of(ShapeKind kind) { return *shape_types[static_cast<std::size_t>(kind)]; }

double bounding_radius(const Shape& shape) { return type_of(shape.kind).bounding_radius(shape); }
Vec3 bounding_half_extents(const Shape& shape, const Mat3& rotation) { return type_of(shape.kind).half_extents(shape, rotation); }
Vec3 bounding_half_extents(const Shape& shape, const Quat& orientation) {
  return bounding_half_extents(shape, orientation.toRotationMatrix());
}
double volume(const Shape& shape) { return type_of(shape.kind).volume(shape); }
Vec3 inertia(const Shape& shape, double mass) { return type_of(shape.kind).inertia(shape, mass); }
double smallest_size(const Shape& shape) { return type_of(shape.kind).smallest_size(shape); }

double reduced_radius(const Shape& a, const Shape& b) {
  const double of_a = is_round(a) ? 1 / a.size.x() : 0, of_b = is_round(b) ? 1 / b.size.x() : 0;
  return of_a + of_b > 0 ? 1 / (of_a + of_b) : 0;
}

Quat frame_of(const Shape& shape) {
  if (shape.kind == ShapeKind::hull) return shape_library().hulls[shape.data].frame;
  if (shape.kind == ShapeKind::compound) return shape_library().compounds[shape.data].frame;
  return Quat::Identity();
}

}  // namespace unibody
