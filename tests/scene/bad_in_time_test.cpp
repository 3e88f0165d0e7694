// Faults of values in time in a scene file: one message each.
#include "scene/scene_text.hpp"

namespace unibody::bad_in_time_test {
namespace {

std::string moved(const std::string& keys, const std::string& motion = "kinematic") {
  return "bodies:\n  - {shape: {sphere: {radius: 0.1}}, motion: " + motion + ", " + keys + "}\n";
}
std::string driven(const std::string& motor) {
  return "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\njoints:\n"
         "  - {type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1], motor: {" +
         motor + ", max_torque: 1}}\n";
}

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class TimeRefuses : public testing::TestWithParam<Fault> {};

TEST_P(TimeRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::vector<Fault> faults{
    {"two_components", moved("velocity: [1, 0]"),
     "FILE:2: key 'bodies[0].velocity': found [1, 0], expected a list of 3 numbers, or of values in time, or a table (m/s)"},
    {"times_of_gravity", "gravity: [0, 0, [[1, -9], [1, -8]]]\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'gravity[2][1][0]': found 1, expected a time after that of the row before (s)"},
    {"gravity_out_of_the_plane",
     "planar: true\ngravity: [0, {sine: {amplitude: 1, frequency: 1}}, -9.81]\n" + moved("velocity: [0, 0, 0]"),
     "FILE:2: key 'gravity': found a list of 3, expected 0 as the second component (planar "
     "scene)"},
    {"friction_below_zero", "materials: {m: {friction: [[0, 0.5], [1, -0.1]]}}\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'materials.m.friction[1][1]': found -0.1, expected a number >= 0"},
    {"friction_of_a_sine_below_zero",
     "materials: {m: {friction: {sine: {amplitude: 0.3, frequency: 1, mean: 0.2}}}}\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'materials.m.friction.sine': found a map, expected a sine whose values are all >= 0"},
    {"stiction_below_zero", "materials: {m: {friction: 0.5, stiction: -0.1}}\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'materials.m.stiction': found -0.1, expected a number >= 0"},
    {"no_stiction_speed", "materials: {m: {friction: 0.5, stiction: 0.1, stiction_speed: 0}}\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'materials.m.stiction_speed': found 0, expected a number > 0 (m/s)"},
    {"force_on_a_kinematic_body", moved("force: [0, 0, [[0, 1], [1, 2]]]"),
     "FILE:2: key 'bodies[0].force': found a list of 3, expected no such key for a fixed or kinematic body"},
    {"row_of_a_force", moved("mass: 1, force: {table: [[0, 1, 2]]}", "dynamic"),
     "FILE:2: key 'bodies[0].force.table[0]': found [0, 1, 2], expected a row [time (s), x, y, z (N)]"},
    {"unit_of_a_torque", moved("mass: 1, torque: [0, 0, {sine: {frequency: 1}}]", "dynamic"),
     "FILE:2: key 'bodies[0].torque[2].sine.amplitude': found nothing, expected a number (N m)"},
    {"no_formula", moved("velocity: [{expression: 2 * x}, 0, 0]"),
     "FILE:2: key 'bodies[0].velocity[0].expression': found '2 * x' (Unexpected token \"x\" found at position 4.), expected a "
     "formula "
     "of the time t (s) (m/s)"},
    {"formula_without_a_value", "time: {frame: 0.5, frames: 8}\n" + moved("velocity: [0, {expression: sqrt(2 - t)}, 0]"),
     "FILE:3: key 'bodies[0].velocity[1].expression': found 'sqrt(2 - t)' = no number at t = 2.0625 s, expected a number (m/s) "
     "at all "
     "times of the run"},
    {"formula_out_of_range", "materials: {m: {friction: {expression: 0.1 - t}}}\n" + moved("velocity: [0, 0, 0]"),
     "FILE:1: key 'materials.m.friction.expression': found '0.1 - t' = -0.002 at t = 0.102 s, expected a number >= 0 at all "
     "times of "
     "the run"},
    {"formula_beside_a_sine", moved("velocity: [{expression: t, sine: {amplitude: 1, frequency: 1}}, 0, 0]"),
     "FILE:2: key 'bodies[0].velocity[0].expression': found expression beside sine, expected one of table, sine and expression"},
    {"surface_of_a_particle", "bodies:\n  - {shape: {particle: {radius: 0.1}}, mass: 1, surface_velocity: [1, 0, 0]}\n",
     "FILE:2: key 'bodies[0].surface_velocity': found [1, 0, 0], expected no such key for a particle: a point has no surface"},
    {"grooves_of_a_particle",
     "bodies:\n  - {shape: {particle: {radius: 0.1}}, mass: 1, anisotropic_friction: {axis: [1, 0, 0], across: 0.5}}\n",
     "FILE:2: key 'bodies[0].anisotropic_friction': found a map, expected no such key for a particle: a point has no surface"},
    {"grooves_without_an_axis", moved("anisotropic_friction: {across: 0.5}"),
     "FILE:2: key 'bodies[0].anisotropic_friction.axis': found nothing, expected a vector of length 1"},
    {"grooves_too_smooth", moved("anisotropic_friction: {axis: [1, 0, 0], across: 0}"),
     "FILE:2: key 'bodies[0].anisotropic_friction.across': found 0, expected a number in [0.01, 100]"},
    {"grooves_in_a_cone", "solver: {friction: saxce}\n" + moved("anisotropic_friction: {axis: [1, 0, 0], across: 0.5}"),
     "FILE:3: key 'bodies[0].anisotropic_friction': found a map beside solver.friction: saxce, expected solver.friction: disc, "
     "which alone knows friction that depends on the direction"},
    {"surface_out_of_the_plane", "planar: true\n" + moved("surface_velocity: [0, 1, 0]"),
     "FILE:3: key 'bodies[0].surface_velocity': found [0, 1, 0], expected 0 as the second component (planar scene)"},
    {"surface_with_two_components", moved("surface_angular_velocity: [1, 0]"),
     "FILE:2: key 'bodies[0].surface_angular_velocity': found [1, 0], expected a list of 3 numbers, or of values in time, or a "
     "table "
     "(rad/s)"},
    {"no_number", moved("velocity: [fast, 0, 0]"),
     "FILE:2: key 'bodies[0].velocity[0]': found fast, expected a finite number (m/s)"},
    {"short_row", moved("velocity: [[[0, 1], [2]], 0, 0]"),
     "FILE:2: key 'bodies[0].velocity[0][1]': found [2], expected a row [time (s), value (m/s)]"},
    {"times_that_stand", moved("velocity: [[[0, 1], [2, 3], [2, 4]], 0, 0]"),
     "FILE:2: key 'bodies[0].velocity[0][2][0]': found 2, expected a time after that of the row before (s)"},
    {"row_of_a_vector", moved("path: {table: [[0, 0, 0, 0], [1, 2]]}"),
     "FILE:2: key 'bodies[0].path.table[1]': found [1, 2], expected a row [time (s), x, y, z (m)]"},
    {"unknown_between", moved("path: {table: [[0, 0, 0, 0], [1, 2, 0, 0]], between: cubic}"),
     "FILE:2: key 'bodies[0].path.between': found cubic, expected linear, steps or smooth"},
    {"one_periodic_row", moved("path: {table: [[0, 0, 0, 0]], periodic: true}"),
     "FILE:2: key 'bodies[0].path.periodic': found a periodic table of one row, expected two rows or more"},
    {"path_that_starts_elsewhere", moved("path: {table: [[0, 1, 0, 0], [1, 2, 0, 0]]}"),
     "FILE:2: key 'bodies[0].path': found a map, expected a path that is 0 at time 0: it starts where the body does"},
    {"path_and_velocity", moved("path: [[[0, 0], [1, 1]], 0, 0], velocity: [1, 0, 0]"),
     "FILE:2: key 'bodies[0].path': found path beside velocity, expected only one of velocity and path"},
    {"path_of_a_dynamic_body", moved("path: [[[0, 0], [1, 1]], 0, 0], mass: 1", "dynamic"),
     "FILE:2: key 'bodies[0].path': found a list of 3, expected motion: kinematic beside a path"},
    {"velocity_in_time_of_a_dynamic_body", moved("velocity: [[[0, 0], [1, 1]], 0, 0], mass: 1", "dynamic"),
     "FILE:2: key 'bodies[0].velocity[0]': found a list of 2, expected a finite number (m/s)"},
    {"out_of_the_plane", "planar: true\n" + moved("velocity: [0, {sine: {amplitude: 1, frequency: 1}}, 0]"),
     "FILE:3: key 'bodies[0].velocity': found a list of 3, expected 0 as the second component (planar scene)"},
    {"turn_out_of_the_plane", "planar: true\n" + moved("angular_velocity: [1, 0, 0]"),
     "FILE:3: key 'bodies[0].angular_velocity': found [1, 0, 0], expected 0 as the first and third component (planar scene)"},
    {"sine_without_frequency", driven("speed: {sine: {amplitude: 1}}"),
     "FILE:4: key 'joints[0].motor.speed.sine.frequency': found nothing, expected a number >= 0 (Hz)"},
    {"negative_frequency", driven("speed: {sine: {amplitude: 1, frequency: -1}}"),
     "FILE:4: key 'joints[0].motor.speed.sine.frequency': found -1, expected a number >= 0 (Hz)"},
    {"unknown_law", driven("speed: {cosine: {amplitude: 1, frequency: 1}}"),
     "FILE:4: key 'joints[0].motor.speed.cosine': found an unknown key (did you mean sine?), expected table, between, periodic, "
     "sine or expression"},
    {"sine_and_table", driven("speed: {table: [[0, 1]], sine: {amplitude: 1, frequency: 1}}"),
     "FILE:4: key 'joints[0].motor.speed.table': found table beside sine, expected one of table, sine and expression"},
    {"neither_table_nor_sine", driven("speed: {periodic: true}"),
     "FILE:4: key 'joints[0].motor.speed.table': found nothing, expected rows [time (s), value (rad/s)], sine or expression"},
    {"angle_beyond_its_range", driven("angle: [[0, 0], [1, 270]]"),
     "FILE:4: key 'joints[0].motor.angle[1][1]': found 270, expected a number in [-180, 180] (degrees)"},
    {"sine_beyond_its_range", driven("angle: {sine: {amplitude: 100, frequency: 1, mean: 100}}"),
     "FILE:4: key 'joints[0].motor.angle.sine': found a map, expected a sine whose values are all in [-180, 180] (degrees)"},
};

INSTANTIATE_TEST_SUITE_P(Faults, TimeRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace unibody::bad_in_time_test
