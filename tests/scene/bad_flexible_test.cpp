// Faults of cloths, threads and particles in a scene file, and of what the solver newton does not take: one message each.
#include "scene/bad_input.hpp"

namespace unibody::bad_flexible_test {
namespace {

class FlexibleRefuses : public testing::TestWithParam<BadInput> {};

TEST_P(FlexibleRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text, GetParam().overrides), GetParam().message); }

std::string with_cloth(const std::string& rest) {
  return "cloths:\n  - grid: {size: [1, 1], nodes: [4, 5]}\n    mass: 1\n    thickness: 0.01\n    " + rest + "\n";
}
std::string with_thread(const std::string& points, const std::string& rest = "mass: 1") {
  return "threads:\n  - points: " + points + "\n    segments: 9\n    radius: 0.01\n    " + rest + "\n";
}

// A cloth pinned to one of several bodies, and what its faults begin and end with.
std::string with_pin_to(const std::string& target) {
  return "bodies:\n  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - {name: twin, shape: {sphere: {radius: 1}}, mass: 1}\n  - {name: twin, shape: {sphere: {radius: 1}}, mass: 1}\n"
         "  - {name: bricks, stack: {count: 2}, shape: {sphere: {radius: 1}}, mass: 1}\n"
         "  - {name: twig, shape: {sphere: {radius: 1}}, mass: 1}\n"
         "cloths:\n  - name: sheet\n    grid: {size: [1, 1], nodes: [4, 5]}\n    mass: 1\n    thickness: 0.01\n"
         "    pins: [{node: [0, 0], " +
         target + "}]\n";
}
const std::string pin_to = "FILE:12: key 'cloths[0].pins[0].to': ";
const std::string single_body = "a body, as mast or pile[3], or its entry's place in the list";

const std::vector<BadInput> bad_flexibles{
    {"thread_without_end", "threads:\n  - {points: [[0, 0, 0], [1.0e+300, 0, 0]], segments: 2, radius: 0.1, mass: 1}\n",
     "FILE:2: key 'threads[0].points[1]': found a point too far from the one before, expected a finite distance"},
    {"mesh_that_is_missing", "cloths:\n  - mesh: no/flag.obj\n    mass: 1\n    thickness: 0.01\n",
     "FILE:2: key 'cloths[0].mesh': found FOLDER/no/flag.obj, which isn't there, expected an OBJ, STL, PLY, glTF or DAE file, "
     "its path from the "
     "scene's "
     "folder"},
    {"grid_and_mesh", with_cloth("mesh: flag.obj"),
     "FILE:5: key 'cloths[0].mesh': found mesh beside grid, expected only one of grid and mesh"},
    {"neither_grid_nor_mesh", "cloths:\n  - mass: 1\n    thickness: 0.01\n",
     "FILE:2: key 'cloths[0].grid': found nothing, expected a map with size and nodes, or mesh: an OBJ, STL, PLY, glTF or DAE "
     "file"},
    {"scale_of_a_grid", with_cloth("scale: 2"), "FILE:5: key 'cloths[0].scale': found 2, expected no such key beside a grid"},
    {"grid_of_one_row", "cloths:\n  - grid: {size: [1, 1], nodes: [1, 5]}\n    mass: 1\n    thickness: 0.01\n",
     "FILE:2: key 'cloths[0].grid.nodes[0]': found 1, expected an integer >= 2"},
    {"pin_outside_the_grid", with_cloth("pins: [{node: [0, 5]}]"),
     "FILE:5: key 'cloths[0].pins[0].node[1]': found 5, expected an integer <= 4"},
    {"pin_that_names_no_node", with_cloth("pins: [{release: 1}]"),
     "FILE:5: key 'cloths[0].pins[0].node': found nothing, expected a node, or near: a point (m), or within: a box (m)"},
    {"pin_by_number_in_a_grid", with_cloth("pins: [{node: 3}]"),
     "FILE:5: key 'cloths[0].pins[0].node': found 3, expected a node [i, j] of the grid"},
    {"pin_by_node_and_place", with_cloth("pins: [{node: [0, 0], near: [0, 0, 0]}]"),
     "FILE:5: key 'cloths[0].pins[0].near': found near beside node, expected only one of node, near and within"},
    {"pin_twice", with_cloth("pins: [{node: [1, 2]}, {node: [1, 2], release: 1}]"),
     "FILE:5: key 'cloths[0].pins[1].node': found [1, 2], a node pinned before, expected each node pinned once"},
    {"pin_far_from_all_nodes", with_cloth("pins: [{near: [100.5, 0.5, 0]}]"),
     "FILE:5: key 'cloths[0].pins[0].near': found [100.5, 0.5, 0], 100 m from the nearest node, expected a point (m, world axes) "
     "within an edge's length of one, 0.416667 m"},
    {"pin_twice_by_place", with_cloth("pins: [{node: [0, 0]}, {near: [-0.6, -0.6, 0]}]"),
     "FILE:5: key 'cloths[0].pins[1].near': found [-0.6, -0.6, 0], a node pinned before, expected each node pinned once"},
    {"self_collision_of_a_cloth", with_cloth("self_collision: 1"),
     "FILE:5: key 'cloths[0].self_collision': found 1, expected true or false"},
    {"self_collision_of_a_thread", with_thread("[[0, 0, 0], [1, 0, 0]]", "mass: 1\n    self_collision: yes"),
     "FILE:6: key 'threads[0].self_collision': found yes, expected true or false"},
    {"pin_to_nobody", with_pin_to("to: twg"),
     pin_to + "found twg, a name that no entry of bodies has (did you mean twig?), expected " + single_body},
    {"pin_to_a_cloth", with_pin_to("to: sheet"),
     pin_to + "found sheet, a name that no entry of bodies has, expected " + single_body},
    {"pin_to_one_of_two", with_pin_to("to: twin"), pin_to + "found twin, the name of 2 entries, expected " + single_body},
    {"pin_to_a_generator", with_pin_to("to: bricks"),
     pin_to + "found bricks, an entry of 2 bodies, expected one of them, as bricks[0]"},
    {"pin_beyond_a_generator", with_pin_to("to: 'bricks[2]'"), pin_to + "found 'bricks[2]' of 2, expected a number below 2"},
    {"pin_to_half_a_number", with_pin_to("to: 'bricks[1'"),
     pin_to + "found 'bricks[1', a name that no entry of bodies has (did you mean bricks?), expected " + single_body},
    {"pin_to_no_number", with_pin_to("to: 'bricks[x]'"), pin_to + "found 'bricks[x]', expected " + single_body},
    {"pin_to_a_plane", with_pin_to("to: ground"), pin_to + "found ground, a plane, expected a body that is no plane"},
    {"pin_beyond_the_bodies", with_pin_to("to: 5"), pin_to + "found 5, expected an integer <= 4"},
    {"pin_to_a_list", with_pin_to("to: [1, 2]"), pin_to + "found [1, 2], expected " + single_body},
    {"pin_to_a_quoted_number", with_pin_to("to: '1'"),
     pin_to + "found '1', a name that no entry of bodies has, expected " + single_body},
    {"pin_without_bodies", with_cloth("pins: [{node: [0, 0], to: 0}]"),
     "FILE:5: key 'cloths[0].pins[0].to': found 0 in a scene without bodies, expected " + single_body},
    {"pin_twice_to_bodies", with_pin_to("to: twig}, {node: [0, 0], to: pole"),
     "FILE:12: key 'cloths[0].pins[1].node': found [0, 0], a node pinned before, expected each node pinned once"},
    {"pin_twice_to_a_dynamic_body", with_pin_to("to: twig}, {node: [0, 0]"),
     "FILE:12: key 'cloths[0].pins[1].node': found [0, 0], a node pinned before, expected each node pinned once"},
    {"negative_drag", with_cloth("drag: -1"), "FILE:5: key 'cloths[0].drag': found -1, expected a number >= 0"},
    {"pressure_that_is_infinite", with_cloth("pressure: .inf"),
     "FILE:5: key 'cloths[0].pressure': found .inf, expected a finite number (Pa)"},
    {"pressure_in_time_without_a_table", with_cloth("pressure: {frequency: 2}"),
     "FILE:5: key 'cloths[0].pressure.frequency': found an unknown key, expected table, between, periodic, sine or expression"},
    {"pressure_of_a_thread", with_thread("[[0, 0, 0], [1, 0, 0]]", "mass: 1\n    pressure: 1"),
     "FILE:6: key 'threads[0].pressure': found an unknown key, expected name, position, orientation, velocity, material, pins, "
     "points, "
     "segments, radius, mass, stretch, bending or self_collision"},
    {"drag_of_a_thread", with_thread("[[0, 0, 0], [1, 0, 0]]", "mass: 1\n    drag: 1"),
     "FILE:6: key 'threads[0].drag': found an unknown key, expected name, position, orientation, velocity, material, pins, "
     "points, "
     "segments, radius, mass, stretch, bending or self_collision"},
    {"links_beside_membrane", with_cloth("links: {}\n    membrane: {youngs_modulus: 1, poissons_ratio: 0}"),
     "FILE:6: key 'cloths[0].membrane': found membrane beside links, expected only one of links and membrane"},
    {"area_beside_membrane", with_cloth("membrane: {youngs_modulus: 1, poissons_ratio: 0}\n    area: {stiffness: 1}"),
     "FILE:6: key 'cloths[0].area': found area beside a membrane, expected no such key: a membrane resists changes of area "
     "itself"},
    {"area_beside_stiff_links", with_cloth("area: {stiffness: 1}"),
     "FILE:5: key 'cloths[0].area': found area beside stiff links on all sides of the triangles, expected links with a stiffness "
     "(N/m) or with diagonals: none"},
    {"area_beside_stiff_links_of_a_mesh", "cloths:\n  - mesh: flag.obj\n    mass: 1\n    thickness: 0.01\n    area: {}\n",
     "FILE:5: key 'cloths[0].area': found area beside stiff links on all sides of the triangles, expected links with a stiffness "
     "(N/m)"},
    {"area_a_number", with_cloth("links: {stiffness: 1}\n    area: 3"),
     "FILE:6: key 'cloths[0].area': found 3, expected a map with the keys stiffness or damping"},
    {"negative_area_stiffness", with_cloth("links: {stiffness: 1}\n    area: {stiffness: -1}"),
     "FILE:6: key 'cloths[0].area.stiffness': found -1, expected a number > 0 (N/m)"},
    {"negative_area_damping", with_cloth("links: {diagonals: none}\n    area: {damping: -1}"),
     "FILE:6: key 'cloths[0].area.damping': found -1, expected a number >= 0 (s)"},
    {"area_of_a_thread", with_thread("[[0, 0, 0], [1, 0, 0]]", "mass: 1\n    area: {stiffness: 1}"),
     "FILE:6: key 'threads[0].area': found an unknown key, expected name, position, orientation, velocity, material, pins, "
     "points, segments, radius, mass, stretch, bending or self_collision"},
    {"negative_stiffness", with_cloth("links: {stiffness: -1}"),
     "FILE:5: key 'cloths[0].links.stiffness': found -1, expected a number > 0 (N/m)"},
    {"negative_damping", with_cloth("links: {damping: -1}"),
     "FILE:5: key 'cloths[0].links.damping': found -1, expected a number >= 0 (s)"},
    {"poissons_ratio", with_cloth("membrane: {youngs_modulus: 1, poissons_ratio: 1}"),
     "FILE:5: key 'cloths[0].membrane.poissons_ratio': found 1, expected a number in (-1, 1)"},
    {"thickness_missing", "cloths:\n  - grid: {size: [1, 1], nodes: [4, 5]}\n    mass: 1\n",
     "FILE:2: key 'cloths[0].thickness': found nothing, expected a number > 0 (m)"},
    {"mass_of_a_cloth_missing", "cloths:\n  - grid: {size: [1, 1], nodes: [4, 5]}\n    thickness: 1\n",
     "FILE:2: key 'cloths[0].mass': found nothing, expected a mass (kg) or a mass_per_area (kg/m^2)"},
    {"planar_cloth", "planar: true\n" + with_cloth("links: {}"),
     "FILE:2: key 'cloths': found cloths in a planar scene, expected planar: false: a cloth needs all three directions"},
    {"thread_of_one_point", with_thread("[[0, 0, 0]]"),
     "FILE:2: key 'threads[0].points': found a list of 1, expected a list of at least 2 points"},
    {"thread_that_stands_still", with_thread("[[0, 0, 0], [0, 0, 0]]"),
     "FILE:2: key 'threads[0].points[1]': found the point before it again, expected a point at a distance"},
    {"pin_beyond_a_thread", with_thread("[[0, 0, 0], [1, 0, 0]]", "mass: 1\n    pins: [{node: 10}]"),
     "FILE:6: key 'threads[0].pins[0].node': found 10, expected an integer <= 9"},
    {"particle_with_inertia", "bodies:\n  - shape: {particle: {radius: 0.1}}\n    mass: 1\n    inertia: [1, 1, 1]\n",
     "FILE:4: key 'bodies[0].inertia': found [1, 1, 1], expected no such key for a particle: it does not turn"},
};

// With the solver newton, which takes one flexible body alone.
std::string by_newton(const std::string& rest) { return "solver:\n  name: newton\n" + rest; }
std::string newton_found(const std::string& found) {
  return "FILE:2: key 'solver.name': found newton " + found +
         ", expected an iterative solver (newton is for one cloth, thread or solid alone, without contacts)";
}
std::string with_solid(const std::string& rest) {
  return "solids:\n  - block: {size: [1, 1, 1], cells: [1, 1, 1]}\n    density: 1\n    youngs_modulus: 1\n    poissons_ratio: 0\n"
         "    thickness: 0.01\n    " +
         rest + "\n";
}

const std::vector<BadInput> bad_for_newton{
    {"newton_and_bodies", by_newton(with_body("mass: 1")), newton_found("in a scene with bodies")},
    {"newton_and_a_body_beside_a_cloth", by_newton(with_body("mass: 1") + with_cloth("links: {}")),
     newton_found("in a scene with bodies")},
    {"newton_and_two_flexibles", by_newton(with_cloth("links: {}") + with_solid("name: jelly")),
     newton_found("in a scene with several flexible bodies")},
    {"newton_and_self_collision", by_newton(with_solid("self_collision: true")), newton_found("beside self_collision")},
    {"newton_and_least_volume", by_newton(with_solid("least_volume: 0.1")),
     newton_found("beside constraints of type inversion_guard")},
};

INSTANTIATE_TEST_SUITE_P(Flexibles, FlexibleRefuses, testing::ValuesIn(bad_flexibles), case_name);
INSTANTIATE_TEST_SUITE_P(Newton, FlexibleRefuses, testing::ValuesIn(bad_for_newton), case_name);

}  // namespace
}  // namespace unibody::bad_flexible_test
