#include "scene/periodic.hpp"

#include <cmath>

#include "core/text.hpp"
#include "scene/refuse_body.hpp"
#include "world/shapes.hpp"

namespace unibody {

namespace {

constexpr std::array axis_names{"x", "y", "z"};

void check_plane(const Scene& scene, const BodyGroup& group, Id k, const Body& plane) {
  const Vec3 normal = plane.state.orientation * Vec3::UnitZ();
  for (int axis = 0; axis < 3; ++axis)
    if (scene.period.along(axis) && std::abs(normal[axis]) > 1e-9)
      refuse_body(scene, group, k,
                  std::string("a plane whose normal has a part along ") + axis_names[static_cast<std::size_t>(axis)] +
                      ", along which the scene is periodic",
                  "planes that go on through the borders");
  if (!plane.state.angular_velocity.isZero(0) || group.motion)
    refuse_body(scene, group, k, "a plane that turns or whose motion changes in time, in a periodic scene",
                "one that is fixed or has a constant velocity");
}

void check_length(const Scene& scene, const BodyGroup& group, Id k, const Body& body) {
  const BodyProperties& p = body.properties;
  const Vec3 half = p.motion == Motion::fixed ? bounding_half_extents(p.shape, body.state.orientation.toRotationMatrix())
                                              : Vec3(Vec3::Constant(bounding_radius(p.shape)));
  for (int axis = 0; axis < 3; ++axis) {
    const double length = scene.period.length[axis];
    if (scene.period.along(axis) && !(half[axis] <= 0.25 * length))
      refuse_body(scene, group, k,
                  "a length of " + number_text(2 * half[axis]) + " m along " + axis_names[static_cast<std::size_t>(axis)] +
                      (p.motion == Motion::fixed ? "" : ", however it turns"),
                  "at most half of the period, " + number_text(0.5 * length) + " m (a floor may be a plane, or several tiles)");
  }
}

}  // namespace

const Keys& periodic_keys() {
  const auto borders = [](const char* axis, const char* about) {
    return keys::numbers(axis, 2, "m", any_number, "no borders", about);
  };
  static const Keys table{
      "periodic",
      "The borders of a cell that repeats itself: what leaves through one comes in by the opposite one.",
      {borders("x", "the least and the greatest x of the cell"), borders("y", "the least and the greatest y of the cell"),
       borders("z", "the least and the greatest z of the cell")}};
  return table;
}

void read_periodic(const Value& value, Scene& scene) {
  const KeyedMap map(value, periodic_keys());
  for (int axis = 0; axis < 3; ++axis) {
    const char* name = axis_names[static_cast<std::size_t>(axis)];
    const Value* borders = map.find(name);
    if (borders == nullptr) continue;
    if (scene.planar && axis == 1) borders->fail_expected("no such key in a planar scene");
    const std::vector<double> ends = map.numbers(name);
    if (!(ends[0] < ends[1])) borders->fail_expected("two numbers (m), the second above the first");
    scene.period.lower[axis] = ends[0], scene.period.length[axis] = ends[1] - ends[0];
  }
  if (!scene.period.any()) value.fail_expected("at least one of x, y and z with the cell's borders");
}

void check_periodic(const Value& root, const Scene& scene) {
  if (!scene.period.any()) return;
  for (const char* section : {"cloths", "threads", "solids"})
    if (const Value* found = root.find(section))
      found->fail(std::string(section) + " in a periodic scene", "bodies and joints alone beside the key periodic");
  for (const BodyGroup& group : scene.groups)
    for (Id k = 0; k < group.count; ++k) {
      const Body body = group.make(k);
      body.properties.shape.kind == ShapeKind::plane ? check_plane(scene, group, k, body) : check_length(scene, group, k, body);
    }
}

}  // namespace unibody
