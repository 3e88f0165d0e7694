#include "world/compound.hpp"

#include <algorithm>
#include <cmath>

#include "world/compound_mass.hpp"
#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

Compound make_compound(std::span<const Compound::Part> parts) {
  const std::vector<double> densities(parts.size(), 1);
  const CompoundMass mass = compound_mass(parts, densities, Overlap::twice);
  return make_compound(parts, moments_of(mass.volume, mass.centre, mass.second));
}

Compound make_compound(std::span<const Compound::Part> parts, const SolidMoments& moments) {
  Compound c;
  c.volume = moments.volume, c.centre = moments.centre, c.inertia = moments.inertia, c.frame = moments.axes;
  const Quat back = c.frame.conjugate();
  for (const auto& p : parts) {
    const Compound::Part part{p.shape, back * (p.place - c.centre), (back * p.turn * frame_of(p.shape)).normalized()};
    const Vec3 reach = part.place.cwiseAbs() + bounding_half_extents(part.shape, part.turn);
    c.size = c.size.cwiseMax(reach);
    c.radius = std::max(c.radius, part.place.norm() + bounding_radius(part.shape));
    c.parts.push_back(part);
  }
  c.radius = std::min(c.radius, c.size.norm());
  c.smallest = 2 * c.size.minCoeff();
  return c;
}

Compound with_moments(const Shape& shape, const SolidMoments& moments) {
  std::vector<Compound::Part> parts;
  if (shape.kind == ShapeKind::compound) {
    const Compound& given = shape_library().compounds[shape.data];
    for (const Compound::Part& part : given.parts)
      parts.push_back({part.shape, given.centre + given.frame * part.place,
                       (given.frame * part.turn * frame_of(part.shape).conjugate()).normalized()});
  } else {
    const bool is_hull = shape.kind == ShapeKind::hull;
    parts.push_back({shape, is_hull ? shape_library().hulls[shape.data].centre : Vec3(Vec3::Zero()), Quat::Identity()});
  }
  return make_compound(parts, moments);
}

double own_mass(const Shape& shape) { return shape.kind == ShapeKind::compound ? shape_library().compounds[shape.data].mass : 0; }

namespace {

const Compound& compound_of(const Shape& s) { return shape_library().compounds[s.data]; }
double bounding(const Shape& s) { return compound_of(s).radius; }
Vec3 extents(const Shape& s, const Mat3& rotation) {
  return (rotation.cwiseAbs() * s.size).cwiseMin(Vec3::Constant(bounding(s)));
}
double own_volume(const Shape& s) { return compound_of(s).volume; }
Vec3 own_inertia(const Shape& s, double mass) { return mass * compound_of(s).inertia; }
double smallest(const Shape& s) { return compound_of(s).smallest; }

}  // namespace

const ShapeType compound_type{ShapeKind::compound, {}, nullptr, bounding, extents, own_volume, own_inertia, smallest, nullptr};

}  // namespace unibody
