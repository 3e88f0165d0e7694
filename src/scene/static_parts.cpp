#include "scene/static_parts.hpp"

#include <cmath>

namespace unibody {

namespace {

constexpr double planar_depth = 1;  // m, along y, of the boards of a planar scene

// Two lengths; in a planar scene one.
Key lengths(const char* name, const char* about) {
  const auto schema = [] { return keys::list_of(keys::of_range(positive)).set("maxItems", 2); };
  return keys::other(name, "m", "a list of 2 numbers > 0 (m), in a planar scene of 1", needed, about, schema);
}

// Lengths along x and y; in a planar scene along x alone.
Vec3 read_lengths(const KeyedMap& map, const char* key, const Scene& scene) {
  const std::size_t n = scene.planar ? 1 : 2;
  const auto lengths = map.need(key).numbers(n, positive, "m");
  return {lengths[0], n == 1 ? planar_depth : lengths[1], 0};
}

// Side 0 looks along +x from -x, 1 along -x, 2 along +y, 3 along -y: the unit vector inwards.
Vec3 inwards(Id side) { return (side % 2 == 0 ? 1 : -1) * Vec3(Vec3::Unit(side / 2)); }

}  // namespace

const Keys& container_keys() {
  static const Keys table{
      "container",
      "Walls about the origin, which are planes, and a floor that bodies fall into.",
      {lengths("size", "inner widths along x and y"), keys::flag("floor", true, "there is a floor at z = 0")}};
  return table;
}

Generated read_container(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, container_keys());
  const Vec3 half = 0.5 * read_lengths(map, "size", scene);
  const Id floors = map.flag("floor") ? 1 : 0;
  const auto make = [body, half, floors](Id k) {
    if (k < floors) return make_plane(body, Vec3::Zero(), Vec3::UnitZ());
    const Vec3 inward = inwards(k - floors);
    return make_plane(body, -inward.cwiseProduct(half), inward);
  };
  return {floors + (scene.planar ? 2 : 4), make};
}

const Keys& hopper_keys() {
  static const Keys table{
      "hopper",
      "Four inclined boards with an opening below, which is about the origin.",
      {lengths("opening", "inner widths of the opening along x and y, at z = 0"),
       lengths("rim", "inner widths at the top, at least those of the opening"),
       keys::number("height", "m", positive, needed, "from the opening to the rim"),
       keys::number("thickness", "m", positive, needed, "of the boards, outwards; more than a body travels in a step")}};
  return table;
}

// Four boards between the opening (z = 0) and the rim (z = height). Each is broader than the rim, so that they meet in the
// corners; they overlap on the outside only, and below the opening they lie outside of it.
Generated read_hopper(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, hopper_keys());
  const Vec3 opening = 0.5 * read_lengths(map, "opening", scene), rim = 0.5 * read_lengths(map, "rim", scene);
  if (rim.x() < opening.x() || rim.y() < opening.y()) map.find("rim")->fail_expected("a rim at least as wide as the opening (m)");
  const double height = map.number("height"), thickness = map.number("thickness");
  const auto make = [body, opening, rim, height, thickness, planar = scene.planar](Id side) {
    const Vec3 inward = inwards(side), along = Vec3::UnitZ().cross(inward);
    const double low = opening.cwiseProduct(inward).norm(), high = rim.cwiseProduct(inward).norm();
    const Vec3 slope(high - low, 0, height);  // from the opening's edge to the rim's, outwards and up
    const Vec3 up = (slope.z() * Vec3::UnitZ() - slope.x() * inward).normalized();
    const Vec3 normal = along.cross(up) * (along.cross(up).dot(inward) >= 0 ? 1 : -1);
    const Vec3 across = along.cwiseAbs();  // +x or +y: in a planar scene boards are turned about y alone
    Mat3 axes;
    axes << across.cross(normal), across, normal;
    const double half_breadth = rim.cwiseProduct(along).norm() + (planar ? 0 : thickness);
    const Vec3 middle = 0.5 * height * Vec3::UnitZ() - 0.5 * (low + high) * inward - 0.5 * thickness * normal;
    return make_body(body, {ShapeKind::box, {0.5 * slope.norm(), half_breadth, 0.5 * thickness}}, middle,
                     Quat(axes).normalized());
  };
  return {scene.planar ? 2 : 4, make};
}

}  // namespace unibody
