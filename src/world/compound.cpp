#include "world/compound.hpp"

#include <algorithm>
#include <cmath>

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

Compound make_compound(std::span<const Compound::Part> parts) {
  double sum = 0;
  Vec3 centre = Vec3::Zero();
  for (const auto& p : parts) sum += volume(p.shape), centre += volume(p.shape) * p.place;
  centre /= sum;
  Mat3 second = Mat3::Zero();  // of the mass about the centre, per mass
  for (const auto& p : parts) {
    const double share = volume(p.shape) / sum;
    const Mat3 turn = (p.turn * frame_of(p.shape)).toRotationMatrix();
    const Vec3 own = p.shape.kind == ShapeKind::particle ? Vec3(Vec3::Zero()) : inertia(p.shape, 1);
    const Vec3 spread = Vec3::Constant(0.5 * own.sum()) - own, d = p.place - centre;
    second += share * (turn * spread.asDiagonal() * turn.transpose() + d * d.transpose());
  }
  return make_compound(parts, moments_of(sum, centre, second));
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
