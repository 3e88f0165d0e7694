// The key `orientation`.
#include <cmath>

#include "scene/body_entry.hpp"

namespace unibody {

namespace {

const Keys& turn_keys() {
  static const Keys table{
      "turn",
      "A turn about an axis.",
      {keys::direction("axis", needed, "the axis"),
       keys::number("angle", "degrees", any_number, needed, "the angle, counter-clockwise seen from the axis's tip")}};
  return table;
}

}  // namespace

Key orientation_key(const char* about) {
  const auto schema = [] { return keys::any_of({keys::list_of(keys::of_type("number"), 4), keys::reference_to(turn_keys)}); };
  return keys::other("orientation", "", "a quaternion [w, x, y, z] or a map with axis and angle (degrees)", "[1, 0, 0, 0]", about,
                     schema, {turn_keys});
}

Quat read_orientation(const Value& value, const Scene& scene) {
  Quat q;
  if (value.kind == Value::Kind::map) {
    const KeyedMap turn(value, turn_keys());
    q = Eigen::AngleAxisd(turn.number("angle") * (M_PI / 180), turn.direction("axis"));
  } else {
    if (value.kind != Value::Kind::list) value.fail_expected("a quaternion [w, x, y, z] or a map with axis and angle (degrees)");
    const auto c = value.numbers(4, any_number, "quaternion w, x, y, z");
    q = Quat(c[0], c[1], c[2], c[3]);
    if (!(std::abs(q.norm() - 1) <= 1e-3)) value.fail_expected("a quaternion of length 1");
    if (q.norm() != 1) q.normalize();
  }
  if (scene.planar && (q.x() != 0 || q.z() != 0)) value.fail_expected("a turn about y (planar scene)");
  return q;
}

}  // namespace unibody
