// Faults of what changes a scene while it runs: inlets, outlets, events and how bodies start.
#include "scene/bad_input.hpp"

namespace unibody::bad_change_test {
namespace {

std::string with_inlet(const std::string& keys, const std::string& more = "") {
  return "bodies:\n  - name: grains\n    density: 1000\n    inlet: {" + keys + "}\n" + more;
}
const std::string mix = "mix: [{shape: {sphere: {radius: 1}}}]", box = "box: {low: [0, 0, 0], high: [1, 1, 1]}";

std::string with_event(const std::string& event) {
  return "materials: {wood: {friction: 1}, ice: {friction: 0}}\n"
         "bodies:\n  - {name: a, shape: {sphere: {radius: 1}}, mass: 1}\n"
         "  - {name: gate, shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [3, 0, 0]}\n"
         "  - {name: arm, shape: {box: {size: [1, 1, 1]}}, mass: 1, position: [9, 0, 0]}\n"
         "  - {shape: {sphere: {radius: 1}}, mass: 1}\n"
         "joints:\n  - {name: axle, type: hinge, bodies: [arm, world], anchor: [9, 0, 0], axis: [0, 1, 0], "
         "motor: {speed: 1, max_torque: 1}}\n"
         "  - {name: loose, type: ball, bodies: [arm, world], anchor: [9, 0, 0]}\n"
         "events:\n  - {" +
         event + "}\n";
}

class ChangesRefuse : public testing::TestWithParam<BadInput> {};

TEST_P(ChangesRefuse, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::string inlet_at = "FILE:4: key 'bodies[0].inlet", event_at = "FILE:11: key 'events[0]";

INSTANTIATE_TEST_SUITE_P(
    Inlets, ChangesRefuse,
    testing::Values(
        BadInput{"no_name", "bodies:\n  - density: 1\n    inlet: {}\n",
                 "FILE:3: key 'bodies[0].inlet': found an inlet without a name, expected the key `name` beside it"},
        BadInput{"no_count", with_inlet("rate: 1, " + box + ", " + mix),
                 inlet_at + ".count': found nothing, expected an integer >= 1"},
        BadInput{"no_rate", with_inlet("count: 1, " + box + ", " + mix),
                 inlet_at + ".rate': found nothing, expected bodies a second, or mass_rate (kg/s)"},
        BadInput{"two_rates", with_inlet("count: 1, rate: 1, mass_rate: 2, " + box + ", " + mix),
                 inlet_at + ".mass_rate': found mass_rate beside rate, expected only one of rate and mass_rate"},
        BadInput{"negative_rate", with_inlet("count: 1, rate: -1, " + box + ", " + mix),
                 inlet_at + ".rate': found -1, expected a number >= 0 (1/s)"},
        BadInput{
            "no_place", with_inlet("count: 1, rate: 1, " + mix),
            inlet_at + ".box': found nothing, expected a map with low and high, disc: one with radius, or mesh: one with file"},
        BadInput{"two_places", with_inlet("count: 1, rate: 1, disc: {radius: 1}, mesh: {file: none.obj}, " + mix),
                 inlet_at + ".mesh': found mesh beside disc, expected only one of box, disc and mesh"},
        BadInput{"no_such_file", with_inlet("count: 1, rate: 1, mesh: {file: none.obj}, " + mix),
                 inlet_at + ".mesh.file': found FOLDER/none.obj, which isn't there, expected an OBJ, STL, PLY, glTF or DAE file, "
                            "its path from the scene's folder"},
        BadInput{"within_what", with_inlet("count: 1, rate: 1, mesh: {file: none.obj, within: 20}, " + mix),
                 inlet_at + ".mesh.within': found 20, expected no such key without `facing`"},
        BadInput{"upside_down", with_inlet("count: 1, rate: 1, box: {low: [0, 0, 1], high: [1, 1, 0]}, " + mix),
                 inlet_at + ".box.high': found [1, 1, 0], expected a corner that is above the other one along each axis (m)"},
        BadInput{"no_mix", with_inlet("count: 1, rate: 1, " + box),
                 inlet_at + ".mix': found nothing, expected a list of shapes with share and scale"},
        BadInput{"a_plane", with_inlet("count: 1, rate: 1, " + box + ", mix: [{shape: {plane: {normal: [0, 0, 1]}}}]"),
                 inlet_at + ".mix[0].shape': found a plane in a mix, expected a shape that can move"},
        BadInput{"until_before_from", with_inlet("count: 1, rate: 1, from: 2, until: 1, " + box + ", " + mix),
                 inlet_at + ".until': found 1, expected a time after `from` (s)"},
        BadInput{"two_of_a_name",
                 with_inlet("count: 1, rate: 1, " + box + ", " + mix,
                            "  - {name: grains, density: 1, inlet: {count: 1, rate: 1, " + box + ", " + mix + "}}\n"),
                 "FILE:5: key 'bodies[1].name': found grains a second time, expected a name of its own for each inlet"},
        BadInput{"start", with_inlet("count: 1, rate: 1, " + box + ", " + mix, "    start: held\n"),
                 "FILE:5: key 'bodies[0].start': found held, expected no such key beside an inlet, whose bodies come in by "
                 "themselves"},
        BadInput{"kinematic", with_inlet("count: 1, rate: 1, " + box + ", " + mix, "    motion: kinematic\n"),
                 "FILE:3: key 'bodies[0].density': found 1000, expected no such key for a fixed or kinematic body"}),
    case_name);

std::string with_scale(const std::string& scale) {
  return with_inlet("count: 1, rate: 1, " + box + ", mix: [{shape: {sphere: {radius: 1}}, scale: " + scale + "}]");
}
const std::string scale_at = inlet_at + ".mix[0].scale";

INSTANTIATE_TEST_SUITE_P(
    Sizes, ChangesRefuse,
    testing::Values(
        BadInput{"two_laws", with_scale("{uniform: [1, 2], table: [[1, 1]]}"),
                 scale_at + ".table': found table beside uniform, expected only one of uniform, normal, log_normal and table"},
        BadInput{"no_law", with_scale("{by: mass}"),
                 scale_at + ".uniform': found nothing, expected [smallest, largest], or one of normal, log_normal, table"},
        BadInput{"no_number", with_scale("2"),
                 scale_at + "': found 2, expected [smallest, largest], or a map with uniform, normal, log_normal or table"},
        BadInput{"by_what", with_scale("{uniform: [1, 2], by: volume}"),
                 scale_at + ".by': found volume, expected number or mass"},
        BadInput{"far_out", with_scale("{normal: {mean: 1, deviation: 1.0e-3, smallest: 2, largest: 3}}"),
                 scale_at + ".normal': found a range in which the distribution has nothing, expected one nearer to its middle"},
        BadInput{"no_range", with_scale("{normal: {mean: 1, deviation: 0.1, smallest: 2, largest: 2}}"),
                 scale_at + ".normal.largest': found 2, expected a factor above the smallest"},
        BadInput{"table_descends", with_scale("{table: [[2, 1], [1, 1]]}"),
                 scale_at + ".table[1][0]': found 1, expected a factor above that of the row before"}),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    Events, ChangesRefuse,
    testing::Values(
        BadInput{"no_time", with_event("do: remove, bodies: gate, when: {after: 1}"),
                 event_at + ".when.column': found nothing, expected the name of a column of report.csv, as kinetic_energy"},
        BadInput{"time_and_column", with_event("do: remove, bodies: gate, when: {time: 1, column: x}"),
                 event_at + ".when.column': found column beside time, expected a time, or a column"},
        BadInput{"unknown", with_event("do: explode, when: {time: 1}"),
                 event_at + ".do': found explode, expected end, add, remove, fix, release, motor or friction"},
        BadInput{"no_bodies", with_event("do: remove, when: {time: 1}"),
                 event_at + ".bodies': found nothing, expected the name of an entry of bodies, or a list of names"},
        BadInput{"unknown_bodies", with_event("do: remove, bodies: gat, when: {time: 1}"),
                 event_at +
                     ".bodies': found gat, a name that no entry of bodies has (did you mean gate?), expected the name of an "
                     "entry of bodies"},
        BadInput{"jointed", with_event("do: remove, bodies: [gate, arm], when: {time: 1}"),
                 event_at + ".bodies[1]': found arm, with a joint, expected bodies without joints and nodes tied to them"},
        BadInput{"release_of_fixed", with_event("do: release, bodies: gate, when: {time: 1}"),
                 event_at + ".bodies': found gate, which the scene moves or holds, expected bodies that are dynamic (start: held "
                            "holds them)"},
        BadInput{"key_of_another", with_event("do: remove, bodies: gate, friction: 1, when: {time: 1}"),
                 event_at + ".friction': found friction beside do: remove, expected the keys bodies"},
        BadInput{"no_motor", with_event("do: motor, joints: loose, speed: 1, when: {time: 1}"),
                 event_at + ".joints': found loose, a joint without a motor, expected a joint with a motor"},
        BadInput{"no_joint", with_event("do: motor, joints: axel, speed: 1, when: {time: 1}"),
                 event_at + ".joints': found axel, a name that no joint has (did you mean axle?), expected the name of a joint"},
        BadInput{"other_target", with_event("do: motor, joints: axle, angle: 1, when: {time: 1}"),
                 event_at + ".angle': found angle of a motor that has speed, expected the key speed (rad/s)"},
        BadInput{"no_material", with_event("do: friction, between: [wood, steel], friction: 1, when: {time: 1}"),
                 event_at + ".between[1]': found steel, expected wood or ice"},
        BadInput{"negative_friction", with_event("do: friction, between: [wood, ice], friction: -1, when: {time: 1}"),
                 event_at + ".friction': found -1, expected a number >= 0"},
        BadInput{"never_added", with_body("name: a\n    mass: 1\n    start: absent"),
                 "FILE:1: key 'events': found nothing, expected one that adds a, which is absent at the start"},
        BadInput{"held_and_fast", with_body("mass: 1\n    start: held\n    velocity: [1, 0, 0]"),
                 "FILE:4: key 'bodies[0].start': found held beside a velocity, expected no velocity: bodies that are held start "
                 "from rest"},
        BadInput{"held_and_fixed", with_body("motion: fixed\n    start: held"),
                 "FILE:4: key 'bodies[0].start': found held of bodies that are not dynamic, expected present or absent"},
        BadInput{"outlet_upside_down", with_body("mass: 1") + "outlets: [{name: o, box: {low: [0, 0, 0], high: [1, 0, 1]}}]\n",
                 "FILE:4: key 'outlets[0].box.high': found [1, 0, 1], expected a corner that is above the other one along each "
                 "axis (m)"},
        BadInput{"two_outlets",
                 with_body("mass: 1") + "outlets:\n  - {name: o, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"
                                        "  - {name: o, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n",
                 "FILE:6: key 'outlets[1].name': found o a second time, expected a name of its own for each outlet"}),
    case_name);

}  // namespace
}  // namespace unibody::bad_change_test
