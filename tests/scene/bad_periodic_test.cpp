// Faults of periodic scenes: one message each.
#include "scene/scene_text.hpp"

namespace unibody::bad_periodic_test {
namespace {

const std::string ball = "bodies:\n  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 1}\n";
std::string with(const std::string& shape, const std::string& more) {
  return "periodic: {x: [0, 1]}\nbodies:\n  - {name: one, shape: {" + shape + "}, " + more + "}\n";
}

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class PeriodicRefuses : public testing::TestWithParam<Fault> {};

TEST_P(PeriodicRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::vector<Fault> faults{
    {"one_border", "periodic: {x: [1]}\n" + ball, "FILE:1: key 'periodic.x': found [1], expected a list of 2 numbers (m)"},
    {"borders_in_the_other_order", "periodic: {x: [1, 0]}\n" + ball,
     "FILE:1: key 'periodic.x': found [1, 0], expected two numbers (m), the second above the first"},
    {"no_border", "periodic: {}\n" + ball,
     "FILE:1: key 'periodic': found a map, expected at least one of x, y and z with the cell's borders"},
    {"another_axis", "periodic: {w: [0, 1]}\n" + ball, "FILE:1: key 'periodic.w': found an unknown key, expected x, y or z"},
    {"y_of_a_planar_scene", "planar: true\nperiodic: {y: [0, 1]}\n" + ball,
     "FILE:2: key 'periodic.y': found [0, 1], expected no such key in a planar scene"},
    {"a_wall_across_the_border", with("plane: {normal: [1, 0, 0]}", "motion: fixed"),
     "FILE:3: body 0 (one): found a plane whose normal has a part along x, along which the scene is periodic, expected planes "
     "that go on "
     "through the borders"},
    {"a_plane_that_turns", with("plane: {normal: [0, 0, 1]}", "motion: kinematic, angular_velocity: [0, 0, 1]"),
     "FILE:3: body 0 (one): found a plane that turns or whose motion changes in time, in a periodic scene, expected one that is "
     "fixed "
     "or has a constant velocity"},
    {"a_long_floor", with("box: {size: [1, 1, 0.1]}", "motion: fixed"),
     "FILE:3: body 0 (one): found a length of 1 m along x, expected at most half of the period, 0.5 m (a floor may be a plane, "
     "or "
     "several tiles)"},
    {"a_long_body", with("box: {size: [0.5, 0.2, 0.1]}", "mass: 1"),
     "FILE:3: body 0 (one): found a length of 0.547723 m along x, however it turns, expected at most half of the period, 0.5 m "
     "(a "
     "floor may be a plane, or several tiles)"},
    {"a_cloth",
     "periodic: {x: [0, 4]}\n" + ball +
         "cloths:\n  - {grid: {size: [1, 1], nodes: [3, 3]}, mass: 1, thickness: 0.01, "
         "links: {}}\n",
     "FILE:4: key 'cloths': found cloths in a periodic scene, expected bodies and joints alone beside the key periodic"},
};

INSTANTIATE_TEST_SUITE_P(Faults, PeriodicRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace unibody::bad_periodic_test
