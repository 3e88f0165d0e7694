#include "scene/triaxial.hpp"

#include <array>
#include <limits>
#include <string>

#include "scene/articulated.hpp"
#include "scene/in_time.hpp"
#include "scene/joints.hpp"

namespace unibody {

namespace {

constexpr double plate_depth = 1;      // m, along y, of the plates of a planar scene
constexpr double reach = 0.5;          // of the room's size: how far plates stand out where the room may grow
constexpr double usual_closing = 0.1;  // 1/s, of the room's size
constexpr std::array axis_names{"x", "y", "z"};

const Keys& side_keys() {
  static const Keys table{"triaxial_side",
                          "What moves the upper plate along one axis.",
                          {keys::number_in_time("pressure", "Pa", not_negative, "none: as much as it takes",
                                                "the pressure with which it presses, on the area that the other plates leave"),
                           keys::number_in_time("closing_speed", "m/s", any_number, "0.1 of the side a second, with a pressure",
                                                "how fast the room closes; with a pressure the fastest that it does")}};
  return table;
}

// The axes along which there are plates.
std::vector<int> axes_of(const Scene& scene) { return scene.planar ? std::vector<int>{0, 2} : std::vector<int>{0, 1, 2}; }

struct Cell {
  TriaxialCell room;
  double thickness = 0, density = 0;
  bool planar = false;
  BodyTemplate body;
  std::array<bool, 3> moves{};  // along each axis, the upper plate

  // Plates stand over each other's edges, and over where the upper ones may move to.
  Body plate(int axis, bool upper) const {
    Vec3 middle, half;
    for (int k = 0; k < 3; ++k) {
      double low = -thickness, high = (1 + reach) * room.size[k] + thickness;
      if (k == axis) low = upper ? room.size[k] : -thickness, high = low + thickness;
      if (planar && k == 1) low = 0, high = plate_depth;
      middle[k] = 0.5 * (low + high), half[k] = 0.5 * (high - low);
    }
    if (planar) middle.y() = 0;
    BodyTemplate made = body;
    made.density = density;
    const bool is_held = !(upper && moves[static_cast<std::size_t>(axis)]);
    Body result = make_body(made, {ShapeKind::box, half}, room.corner + middle);
    if (is_held) result.properties.motion = Motion::pinned;
    return result;
  }
};

// length: m, of the room along the axis.
void read_side(const Value& value, const Scene& scene, double length, Joint& joint) {
  const KeyedMap map(value, side_keys());
  const bool presses = map.has("pressure");
  if (!presses && !map.has("closing_speed")) value.fail_missing("pressure", "a pressure (Pa), a closing_speed (m/s), or both");
  joint.motor = Motor::speed;
  joint.target = map.has("closing_speed") ? read_in_time(map, "closing_speed", scene, -1) : TimeValue(-usual_closing * length);
  joint.strength = presses ? read_in_time(map, "pressure", scene) : TimeValue(std::numeric_limits<double>::infinity());
}

Cell read_cell(const KeyedMap& map, const BodyTemplate& body, const Scene& scene) {
  Cell cell;
  cell.room.size = map.vector("size");
  if (!(cell.room.size.minCoeff() > 0)) map.need("size").fail_expected("three numbers > 0 (m)");
  cell.room.corner = {-0.5 * cell.room.size.x(), scene.planar ? 0 : -0.5 * cell.room.size.y(), 0};
  cell.thickness = map.number("thickness"), cell.density = map.number("density");
  cell.planar = scene.planar, cell.body = body;
  cell.body.properties.group = group_without_contacts(scene.body_count(), 0);
  if (const Value* side = scene.planar ? map.find("y") : nullptr) side->fail("plates along y", "x and z alone (planar scene)");
  return cell;
}

}  // namespace

const Keys& triaxial_keys() {
  static const Keys table{
      "triaxial",
      "The plates of a triaxial cell, which press on what is between them. The room stands on the origin, in the middle of its "
      "floor; "
      "the plates below do not move, those above do where their axis has an entry.",
      {keys::vector("size", "m", needed, "of the room between the plates, at the start"),
       keys::number("thickness", "m", positive, needed, "of the plates, outwards"),
       keys::number("density", "kg/m^3", positive, 7800, "of the plates"),
       keys::map("x", side_keys, "a map with pressure or closing_speed", "the plate stays", "what moves the upper plate along x"),
       keys::map("y", side_keys, "a map with pressure or closing_speed", "the plate stays", "what moves the upper plate along y"),
       keys::map("z", side_keys, "a map with pressure or closing_speed", "the plate stays",
                 "what moves the upper plate along z")}};
  return table;
}

Generated read_triaxial(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, triaxial_keys());
  Cell cell = read_cell(map, body, scene);
  Generated result;
  const std::vector<int> axes = axes_of(scene);
  std::array<std::int64_t, 3> joint_along{-1, -1, -1};
  for (const int axis : axes) {
    const auto a = static_cast<std::size_t>(axis);
    cell.room.plates[a] = static_cast<int>(result.count);
    result.count += 2;
    result.names.push_back(std::string("low_") + axis_names[a]), result.names.push_back(std::string("high_") + axis_names[a]);
    if (!map.find(axis_names[a])) continue;
    cell.moves[a] = true, joint_along[a] = static_cast<std::int64_t>(result.joint_names.size());
    result.joint_names.emplace_back(axis_names[a]);
  }
  for (const int axis : axes) {
    const auto a = static_cast<std::size_t>(axis);
    if (!cell.moves[a]) continue;
    Body plate = cell.plate(axis, true);
    plate.id = cell.room.plates[a] + 1;
    Joint joint =
        joint_between(JointKind::slider, plate, nullptr, plate.state.position, joint_axes(Vec3::Unit(axis), Vec3::Zero()));
    read_side(map.need(axis_names[a]), scene, cell.room.size[axis], joint);
    if (map.need(axis_names[a]).find("pressure")) {
      PressedArea area;
      std::size_t next = 0;
      for (std::size_t b = 0; b < 3; ++b)
        if (b != a) area.lengths[next++] = {cell.room.size[static_cast<int>(b)], joint_along[b]};
      joint.area = std::make_shared<PressedArea>(area);
    }
    result.joints.push_back(joint);
  }
  result.make = [cell, axes](Id k) { return cell.plate(axes[static_cast<std::size_t>(k / 2)], k % 2 == 1); };
  result.cell = std::make_shared<TriaxialCell>(cell.room);
  return result;
}

}  // namespace unibody
