#include "scene/body_mass.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "world/compound.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

Vec3 read_inertia(const Value& value) {
  const Vec3 moments = value.vector(positive, inertia_keys().at("inertia").unit);
  if (!(2 * moments.maxCoeff() <= moments.sum() * (1 + 1e-12)))
    value.fail_expected("three principal moments (kg m^2), none larger than the sum of the other two");
  return moments;
}

// The moments xx, yy, zz, xy, xz, yz as a matrix (kg m^2).
Mat3 read_inertia_matrix(const Value& value) {
  const std::vector<double> m = value.numbers(6, any_number, inertia_keys().at("inertia").unit);
  Mat3 matrix;
  matrix << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(moments.minCoeff() > 0 && 2 * moments.maxCoeff() <= moments.sum() * (1 + 1e-9)))
    value.fail_expected("six moments (kg m^2) whose principal ones are > 0, none larger than the sum of the other two");
  return matrix;
}

// The shape as the file gives it, but with the entry's own centre of mass and inertia.
Shape read_own_moments(const KeyedMap& entry, const Shape& shape, double mass, const Scene& scene) {
  const Value *centre = entry.value().find("centre_of_mass"), *inertia = entry.value().find("inertia");
  const Value& given = centre ? *centre : *inertia;
  if (scene.planar) given.fail_expected("no such key in a planar scene");
  if (shape.kind == ShapeKind::particle) given.fail_expected("no such key for a particle: it does not turn");
  if (!inertia) entry.value().fail_missing("inertia", "moments about the centre of mass (kg m^2), beside centre_of_mass");
  const Mat3 about = inertia->entries.size() == 6 ? read_inertia_matrix(*inertia) : Mat3(read_inertia(*inertia).asDiagonal());
  const Mat3 second = 0.5 * about.trace() * Mat3::Identity() - about;
  Vec3 at = Vec3::Zero();
  if (centre)
    at = entry.vector("centre_of_mass");
  else if (shape.kind == ShapeKind::hull)
    at = shape_library().hulls[shape.data].centre;
  else if (shape.kind == ShapeKind::compound)
    at = shape_library().compounds[shape.data].centre;
  return shape_library().add(with_moments(shape, moments_of(volume(shape), at, second / mass)));
}

// Whether the entry gives its bodies a centre of mass or an inertia matrix other than those of a solid of one density.
bool has_own_moments(const KeyedMap& entry) {
  const Value *centre = entry.value().find("centre_of_mass"), *inertia = entry.value().find("inertia");
  return centre != nullptr || (inertia != nullptr && inertia->entries.size() == 6);
}

}  // namespace

const Keys& inertia_keys() {
  static const Keys table{
      "inertia",
      "",
      {keys::other("inertia", "kg m^2", "a list of 3 numbers > 0, or of 6 numbers", "that of the solid",
                   "principal moments of inertia, none larger than the sum of the others; or the moments "
                   "xx, yy, zz, xy, xz and yz about the centre of mass, in the axes of the shape",
                   [] {
                     return keys::any_of({keys::list_of(keys::of_range(positive), 3), keys::list_of(keys::of_type("number"), 6)});
                   }),
       keys::vector("centre_of_mass", "m", "that of the solid",
                    "where the centre of mass is in the axes of the shape; beside an inertia, which is then "
                    "in these axes, too")}};
  return table;
}

void read_amount(const KeyedMap& entry, BodyTemplate& body, const Scene& scene) {
  if (!body.properties.is_dynamic())
    return entry.none_of({"mass", "density", "inertia", "centre_of_mass", "force", "torque"}, "for a fixed or kinematic body");
  entry.only_one_of({"mass", "density"});
  body.mass = entry.number_if("mass"), body.density = entry.number_if("density");
  Shape& shape = body.properties.shape;
  check_own_mass(entry.value(), body, shape);
  if (has_own_moments(entry)) {
    const double mass = make_body(body, shape, Vec3::Zero()).properties.mass;
    shape = read_own_moments(entry, shape, mass, scene);
    body.mass = mass, body.density.reset();
    return;
  }
  if (const Value* moments = entry.value().find("inertia")) body.inertia = read_inertia(*moments);
}

void check_own_mass(const Value& entry, const BodyTemplate& body, const Shape& shape) {
  const bool has_own = own_mass(shape) > 0;
  if (has_own && body.density)
    entry.find("density")->fail("a density beside densities of the parts", "the one or the other, or a mass");
  if (!has_own && !body.mass && !body.density) entry.fail_missing("mass", "a mass (kg) or a density (kg/m^3)");
}

void check_mass(const Value& entry, const BodyTemplate& body, const Shape& shape) {
  if (!body.properties.is_dynamic()) return;
  const BodyProperties p = make_body(body, shape, Vec3::Zero()).properties;
  const double moment = shape.kind == ShapeKind::particle ? p.mass : p.inertia.minCoeff();
  if (std::min(p.mass, moment) > 0 && std::isfinite(p.mass) && p.inertia.allFinite()) return;
  const Value* amount = entry.find(body.mass ? "mass" : "density");
  (amount ? *amount : entry).fail_expected("a mass and an inertia > 0 and finite for a body of this size");
}

}  // namespace unibody
