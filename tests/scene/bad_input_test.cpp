// What the reader refuses: every fault names file and line (or the -set), the key, the value found and what was expected.
#include "scene/bad_input.hpp"

namespace unibody::bad_input_test {
namespace {

class ReadSceneRefuses : public testing::TestWithParam<BadInput> {};

TEST_P(ReadSceneRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text, GetParam().overrides), GetParam().message); }

const std::vector<BadInput> bad_files{
    {"empty_file", "", "FILE:1: found nothing, expected a map of sections (title, time, bodies, ...)"},
    {"a_word", "hello", "FILE:1: found hello, expected a map of sections (title, time, bodies, ...)"},
    {"a_list", "- 1\n- 2\n", "FILE:1: found [1, 2], expected a map of sections (title, time, bodies, ...)"},
    {"not_yaml", "title: x\ntime: {frame: 1\nbodies: 3\n",
     "FILE:3: not YAML: the '{' of line 2 is not closed, expected a '}' (end of map flow not found)"},
    {"not_yaml_list", "title: 'a [b'  # {\nbodies: [{mass: 1}, {shape: {sphere: {radius: 1}}}\n",
     "FILE:3: not YAML: the '[' of line 2 is not closed, expected a ']' (end of sequence flow not found)"},
    {"not_yaml_tab", "time:\n\tframe: 0.01\n",
     "FILE:2: not YAML: the line begins with a tab, expected spaces: YAML takes no tabs there (illegal map value)"},
    {"not_yaml_tab_in_list", "title: x\nbodies:\n\t- mass: 1\n",
     "FILE:3: not YAML: the line begins with a tab, expected spaces: YAML takes no tabs there (illegal block entry)"},
    {"not_yaml_indentation", "time:\n  frame: 0.01\n frames: 3\n",
     "FILE:3: not YAML: the line begins with 1 space, expected 0 or 2 as lines above it (end of map not found)"},
    {"not_yaml_indentation_in_list", "bodies:\n  - shape: {sphere: {radius: 1}}\n   mass: 1\n",
     "FILE:3: not YAML: the line begins with 3 spaces, expected 0, 2 or 4 as lines above it (end of sequence not found)"},
    {"not_yaml_too_deep", "bodies:\n  - shape: {sphere: {radius: 1}}  # round\n\n     mass: 1\n",
     "FILE:4: not YAML: the line begins with 5 spaces, expected 0, 2 or 4 as lines above it (end of map not found)"},
    {"not_yaml_too_deep_for_a_value", "time:\n  frame: 0.01\n    frames: 3\nbodies: []\n",
     "FILE:3: not YAML: the line begins with 4 spaces, expected 0 or 2 as lines above it (illegal map value)"},
    {"not_yaml_colon", "title: a pile: large\nbodies: []\n",
     "FILE:1: not YAML: the line has a second ': ', expected quotes around a text that holds one (illegal map value)"},
    {"two_documents", "title: x\n---\ntitle: y\n", "FILE:2: found text after the scene's end, expected one YAML document"},
    {"begins_with_a_comma", ", title: x\n", "FILE:1: found text after the scene's end, expected one YAML document"},
    {"no_bodies", "title: x\n", "FILE:1: key 'bodies': found nothing, expected a list of bodies and generators"},
    {"place_beyond_all_numbers",
     "bodies:\n  - shape: {box: {size: [1, 1, 1]}}\n    mass: 1\n"
     "    lattice: {count: 9, columns: [1, 1], spacing: [1, 1, 1], rotation_jitter: 1.0e+300}\n",
     "FILE:2: key 'bodies[0]': found a place of body 0 that is not finite, expected smaller numbers"},
    {"bodies_empty", "title: x\nbodies: []\n",
     "FILE:2: key 'bodies': found a list of 0, expected a list of bodies and generators"},
    {"bodies_a_map", "bodies: {mass: 1}\n", "FILE:1: key 'bodies': found a map, expected a list of bodies and generators"},
    {"unknown_section", "title: x\ntmie: {step: 1}\n",
     "FILE:2: key 'tmie': found an unknown key (did you mean time?), expected title, time, planar, periodic, gravity, wind, "
     "air_density, "
     "solver, output, "
     "materials, bodies, cloths, threads, solids, joints, bonds, couplings, probes, outlets or events"},
    {"unknown_key", "time:\n  frames: 3\n  stp: 1\n",
     "FILE:3: key 'time.stp': found an unknown key, expected frame, frames or substeps"},
    {"key_twice", "title: a\ntime: {frame: 1}\ntitle: b\n",
     "FILE:3: key 'title': found the key a second time, expected each key once"},
    {"title_a_list", "title: [1, 2]\n", "FILE:1: key 'title': found [1, 2], expected a text"},
    {"section_without_value", "time:\n" + ball,
     "FILE:1: key 'time': found nothing, expected a map with the keys frame, frames or substeps"},
    {"key_of_two_lines", "\"a\\nb\": 1\n",
     "FILE:1: key 'a?b': found an unknown key, expected title, time, planar, periodic, gravity, wind, air_density, solver, "
     "output, "
     "materials, bodies, cloths, threads, solids, joints, bonds, couplings, probes, outlets or events"},
    {"value_missing", "time: {frame: }\n", "FILE:1: key 'time.frame': found nothing, expected a number > 0 (s)"},
};

const std::vector<BadInput> bad_values{
    {"former_name", "time:\n  step: 0.1\n",
     "FILE:2: key 'time.step': found the former name of a key, expected frame, its name since version 0.2"},
    {"word_for_a_number", "time:\n  frame: fast\n", "FILE:2: key 'time.frame': found fast, expected a number > 0 (s)"},
    {"quoted_number", "time:\n  frame: '0.1'\n", "FILE:2: key 'time.frame': found '0.1', expected a number > 0 (s)"},
    {"number_and_unit", "time:\n  frame: 16 ms\n", "FILE:2: key 'time.frame': found 16 ms, expected a number > 0 (s)"},
    {"wind_of_two", "wind: [1, 2]\n", "FILE:1: key 'wind': found [1, 2], expected a list of 3 numbers (m/s)"},
    {"wind_out_of_the_plane", "planar: true\nwind: [1, 2, 0]\n",
     "FILE:2: key 'wind': found [1, 2, 0], expected 0 as the second of three numbers (m/s; planar scene)"},
    {"air_density", "air_density: -1\n", "FILE:1: key 'air_density': found -1, expected a number >= 0 (kg/m^3)"},
    {"zero_step", "time: {frame: 0}\n", "FILE:1: key 'time.frame': found 0, expected a number > 0 (s)"},
    {"fraction_for_an_integer", "time: {frames: 1.5}\n", "FILE:1: key 'time.frames': found 1.5, expected an integer >= 0"},
    {"no_substeps", "time: {substeps: 0}\n", "FILE:1: key 'time.substeps': found 0, expected an integer >= 1"},
    {"integer_too_large", "time: {substeps: 3000000000}\n",
     "FILE:1: key 'time.substeps': found 3000000000, expected an integer <= 1000000"},
    {"nan", "gravity: [0, 0, .nan]\n", "FILE:1: key 'gravity[2]': found .nan, expected a finite number (m/s^2)"},
    {"inf", "gravity:\n  - 0\n  - .inf\n  - 0\n", "FILE:3: key 'gravity[1]': found .inf, expected a finite number (m/s^2)"},
    {"inf_as_c_writes_it", "gravity: [inf, 0, 0]\n", "FILE:1: key 'gravity[0]': found inf, expected a finite number (m/s^2)"},
    {"number_too_large", "gravity: [1e999, 0, 0]\n", "FILE:1: key 'gravity[0]': found 1e999, expected a finite number (m/s^2)"},
    {"two_for_three", "gravity: [0, 0]\n", "FILE:1: key 'gravity': found [0, 0], expected a list of 3 numbers (m/s^2)"},
    {"yes_for_true", "planar: yes\n", "FILE:1: key 'planar': found yes, expected true or false"},
    {"precision", "output: {precision: half}\n", "FILE:1: key 'output.precision': found half, expected single or double"},
    {"negative_every", "output: {every: -1}\n", "FILE:1: key 'output.every': found -1, expected an integer >= 0"},
    {"checkpoint_every", "output: {checkpoint_every: -2}\n",
     "FILE:1: key 'output.checkpoint_every': found -2, expected an integer >= -1"},
    {"solver_name", "solver: {name: sor}\n",
     "FILE:1: key 'solver.name': found sor, expected accelerated_jacobi, jacobi, gauss_seidel or newton"},
    {"nearly_a_solver", "solver: {name: gauss_siedel}\n",
     "FILE:1: key 'solver.name': found gauss_siedel (did you mean gauss_seidel?), expected accelerated_jacobi, jacobi, "
     "gauss_seidel "
     "or newton"},
    {"nearly_a_setting", "solver: {itertions: 10}\n",
     "FILE:1: key 'solver.itertions': found an unknown key (did you mean iterations?), expected name, iterations, accuracy, "
     "tolerance, "
     "acceleration, mass_sharing, level, stabilisation, stages, form, warm_start, velocity_share, leak, friction, joints, "
     "coarse, gap, "
     "order, scaling, recovery_time, recovery_speed or margin"},
    {"no_accuracy", "solver: {accuracy: 0}\n",
     "FILE:1: key 'solver.accuracy': found 0, expected auto, film (1e-2), engineering (1e-3), reference (1e-5), or number in (0, "
     "1]"},
    {"accuracy_of_more_than_the_body", "solver: {accuracy: 1.5}\n",
     "FILE:1: key 'solver.accuracy': found 1.5, expected auto, film (1e-2), engineering (1e-3), reference (1e-5), or number in "
     "(0, 1]"},
    {"accuracy_of_no_number", "solver: {accuracy: .nan}\n",
     "FILE:1: key 'solver.accuracy': found .nan, expected auto, film (1e-2), engineering (1e-3), reference (1e-5), or number in "
     "(0, 1]"},
    {"accuracy_and_tolerance", "solver:\n  accuracy: film\n  tolerance: 1.0e-5\n",
     "FILE:3: key 'solver.tolerance': found 1.0e-5, expected auto beside an accuracy, which sets the tolerance"},
    {"accuracy_of_newton", "solver: {accuracy: film, name: newton}\n",
     "FILE:1: key 'solver.accuracy': found film, expected auto for newton, whose steps are solved as far as they go"},
    {"full_warm_start", "solver: {warm_start: 1}\n",
     "FILE:1: key 'solver.warm_start': found 1, expected auto or a number in [0, 0.5]: a full warm start at position level is "
     "unstable"},
    {"more_than_a_full_warm_start", "solver: {level: velocity, warm_start: 1.5}\n",
     "FILE:1: key 'solver.warm_start': found 1.5, expected auto or a number in [0, 1]"},
    {"level", "solver: {level: acceleration}\n", "FILE:1: key 'solver.level': found acceleration, expected position or velocity"},
    {"stabilisation", "solver: {level: velocity, stabilisation: 2}\n",
     "FILE:1: key 'solver.stabilisation': found 2, expected a number in [0, 1]"},
    {"stabilisation_of_positions", "solver: {stabilisation: 0.4}\n",
     "FILE:1: key 'solver.stabilisation': found 0.4, expected level: velocity beside it (position has recovery_time)"},
    {"newton_at_velocity_level", "solver: {level: velocity, name: newton}\n",
     "FILE:1: key 'solver.name': found newton, expected an iterative solver at level: velocity"},
    {"stages_at_velocity_level", "solver:\n  stages: two\n  level: velocity\n",
     "FILE:2: key 'solver.stages': found two, expected auto at level: velocity, which has one stage"},
    {"velocity_share_at_velocity_level", "solver: {level: velocity, velocity_share: 0.5}\n",
     "FILE:1: key 'solver.velocity_share': found 0.5, expected auto at level: velocity, which has one stage"},
    {"leak_at_velocity_level", "solver: {level: velocity, leak: 0}\n",
     "FILE:1: key 'solver.leak': found 0, expected auto at level: velocity, which has one stage"},
    {"coarse_at_velocity_level", "solver: {level: velocity, coarse: true}\n",
     "FILE:1: key 'solver.coarse': found true, expected false at level: velocity, whose constraints are linear in a step"},
    {"coarse_of_newton", "solver: {name: newton, coarse: true}\n",
     "FILE:1: key 'solver.coarse': found true, expected false for newton, whose steps are solved as far as they go"},
    {"coarse_in_the_total_form", "solver: {form: total, coarse: true}\n",
     "FILE:1: key 'solver.coarse': found true, expected false for form: total"},
    {"unknown_coarse", "solver: {coarse: maybe}\n", "FILE:1: key 'solver.coarse': found maybe, expected true or false"},
    {"gap_at_velocity_level", "solver: {level: velocity, gap: reevaluated}\n",
     "FILE:1: key 'solver.gap': found reevaluated, expected frozen at level: velocity, whose constraints are linear in a step"},
    {"form_at_velocity_level", "solver: {level: velocity, form: total}\n",
     "FILE:1: key 'solver.form': found total, expected incremental at level: velocity, whose constraints are linear in a step"},
    {"negative_tolerance", "solver: {tolerance: -1}\n",
     "FILE:1: key 'solver.tolerance': found -1, expected auto or a number >= 0 (m)"},
    {"scaling", "solver: {scaling: 1.5}\n", "FILE:1: key 'solver.scaling': found 1.5, expected a number in (0, 1]"},
    {"velocity_share", "solver: {velocity_share: 1}\n",
     "FILE:1: key 'solver.velocity_share': found 1, expected auto or a number in (0, 1)"},
    {"leak", "solver: {leak: 2}\n", "FILE:1: key 'solver.leak': found 2, expected auto or a number in [0, 1]"},
    {"acceleration", "solver: {acceleration: fast}\n",
     "FILE:1: key 'solver.acceleration': found fast, expected auto, optimized, nesterov or none"},
    {"mass_sharing", "solver: {mass_sharing: none}\n",
     "FILE:1: key 'solver.mass_sharing': found none, expected directions or count"},
    {"stages", "solver: {stages: 2}\n", "FILE:1: key 'solver.stages': found 2, expected auto, two, together or position"},
    {"iterations_in_words", "solver: {iterations: many}\n",
     "FILE:1: key 'solver.iterations': found many, expected auto or an integer >= 1, <= 1000000000"},
    {"too_few_iterations_for_two_stages", "solver:\n  iterations: 1\n",
     "FILE:2: key 'solver.iterations': found 1, expected an integer >= 2 (two stages; stages: position needs 1)"},
    {"no_material", "materials: {}\n",
     "FILE:1: key 'materials': found no material, expected at least one, as wood: {friction: 0.5}"},
    {"friction_missing", "materials:\n  wood: {}\n",
     "FILE:2: key 'materials.wood.friction': found nothing, expected a number >= 0"},
    {"negative_friction", "materials: {wood: {friction: -1}}\n",
     "FILE:1: key 'materials.wood.friction': found -1, expected a number >= 0"},
    {"two_laws", "materials:\n  wood: {friction: 1, stiffness: 1, elastic_modulus: 1}\n",
     "FILE:2: key 'materials.wood': found stiffness and elastic_modulus, expected one of the two"},
    {"law_and_restitution", "materials:\n  wood: {friction: 1, stiffness: 1, restitution: 0.5}\n",
     "FILE:2: key 'materials.wood': found restitution beside stiffness, expected damping or damping_ratio, from which the "
     "rebound "
     "of such a contact follows"},
    {"damping_of_a_rigid_contact", "materials:\n  wood: {friction: 1, damping_ratio: 0.5}\n",
     "FILE:2: key 'materials.wood': found a damping of rigid contacts, expected stiffness or elastic_modulus beside it"},
    {"laws_that_do_not_mix",
     "materials:\n  wood: {friction: 1, stiffness: 1, damping: 1}\n  gum: {friction: 1, elastic_modulus: 1, damping: 1}\n",
     "FILE:1: key 'materials': found a damping of rigid contacts between gum and wood, expected stiffness or elastic_modulus "
     "beside "
     "it"},
    {"pair_of_unknown_material", "materials: {wood: {friction: 1}, pairs: [{between: [wood, iron], friction: 1}]}\n",
     "FILE:1: key 'materials.pairs[0].between[1]': found iron, expected wood"},
    {"pair_of_one", "materials: {wood: {friction: 1}, pairs: [{between: [wood, wood], friction: 1}]}\n",
     "FILE:1: key 'materials.pairs[0].between': found [wood, wood], expected two different materials"},
    {"pair_twice",
     "materials:\n  a: {friction: 1}\n  b: {friction: 1}\n  pairs:\n    - {between: [a, b], friction: 1}\n    - {between: [b, "
     "a], friction: 2}\n",
     "FILE:6: key 'materials.pairs[1].between': found [b, a] a second time, expected each pair once"},
};

const std::vector<BadInput> bad_bodies{
    {"no_shape", "bodies:\n  - mass: 1\n",
     "FILE:2: key 'bodies[0].shape': found nothing, expected a map with the key sphere, box, plane, disc, particle, "
     "capsule, cylinder, hull, compound or mesh"},
    {"unknown_shape", "bodies:\n  - shape: {ball: {radius: 1}}\n",
     "FILE:2: key 'bodies[0].shape.ball': found an unknown key, expected sphere, box, plane, disc, particle, "
     "capsule, cylinder, hull, compound or mesh"},
    {"two_shapes", "bodies:\n  - shape: {sphere: {radius: 1}, box: {size: [1, 1, 1]}}\n",
     "FILE:2: key 'bodies[0].shape': found a map of 2 shapes, expected one of sphere, box, plane, disc, "
     "particle, capsule, cylinder, hull, compound or mesh"},
    {"radius_missing", "bodies:\n  - shape: {sphere: {}}\n",
     "FILE:2: key 'bodies[0].shape.sphere.radius': found nothing, expected a number > 0 (m)"},
    {"negative_radius", "bodies:\n  - shape: {sphere: {radius: -1}}\n",
     "FILE:2: key 'bodies[0].shape.sphere.radius': found -1, expected a number > 0 (m)"},
    {"flat_box", "bodies:\n  - shape: {box: {size: [1, 0, 1]}}\n",
     "FILE:2: key 'bodies[0].shape.box.size[1]': found 0, expected a number > 0 (m)"},
    {"plane_without_normal", "bodies:\n  - shape: {plane: {}}\n",
     "FILE:2: key 'bodies[0].shape.plane.normal': found nothing, expected a vector of length 1"},
    {"long_normal", "bodies:\n  - shape: {plane: {normal: [0, 0, 2]}}\n",
     "FILE:2: key 'bodies[0].shape.plane.normal': found [0, 0, 2] of length 2, expected a vector of length 1"},
    {"zero_normal", "bodies:\n  - shape: {plane: {normal: [0, 0, 0]}}\n",
     "FILE:2: key 'bodies[0].shape.plane.normal': found [0, 0, 0] of length 0, expected a vector of length 1"},
    {"disc_in_space", "bodies:\n  - shape: {disc: {radius: 1}}\n",
     "FILE:2: key 'bodies[0].shape.disc': found a disc, expected sphere, box or plane in a scene that is not planar"},
    {"negative_mass", with_body("mass: -1"), "FILE:3: key 'bodies[0].mass': found -1, expected a number > 0 (kg)"},
    {"zero_mass", with_body("mass: 0"), "FILE:3: key 'bodies[0].mass': found 0, expected a number > 0 (kg)"},
    {"no_mass", with_body("name: x"), "FILE:2: key 'bodies[0].mass': found nothing, expected a mass (kg) or a density (kg/m^3)"},
    {"mass_and_density", with_body("mass: 1\n    density: 2"),
     "FILE:4: key 'bodies[0].density': found density beside mass, expected only one of mass and density"},
    {"mass_of_a_fixed_body", with_body("mass: 1\n    motion: fixed"),
     "FILE:3: key 'bodies[0].mass': found 1, expected no such key for a fixed or kinematic body"},
    {"velocity_of_a_fixed_body", with_body("velocity: [1, 0, 0]\n    motion: fixed"),
     "FILE:3: key 'bodies[0].velocity': found [1, 0, 0], expected no such key for a fixed body"},
    {"mass_that_vanishes", "bodies:\n  - shape: {sphere: {radius: 1e-150}}\n    density: 1\n",
     "FILE:3: key 'bodies[0].density': found 1, expected a mass and an inertia > 0 and finite for a body of this size"},
    {"impossible_inertia", with_body("mass: 1\n    inertia: [1, 1, 3]"),
     "FILE:4: key 'bodies[0].inertia': found [1, 1, 3], expected three principal moments (kg m^2), none larger than the sum of "
     "the other two"},
    {"quaternion_not_unit", with_body("mass: 1\n    orientation: [1, 1, 0, 0]"),
     "FILE:4: key 'bodies[0].orientation': found [1, 1, 0, 0], expected a quaternion of length 1"},
    {"three_angles", with_body("mass: 1\n    orientation: [0, 90, 0]"),
     "FILE:4: key 'bodies[0].orientation': found [0, 90, 0], expected a list of 4 numbers (quaternion w, x, y, z)"},
    {"axis_not_unit", with_body("mass: 1\n    orientation: {axis: [0, 3, 4], angle: 1}"),
     "FILE:4: key 'bodies[0].orientation.axis': found [0, 3, 4] of length 5, expected a vector of length 1"},
    {"angle_missing", with_body("mass: 1\n    orientation: {axis: [0, 0, 1]}"),
     "FILE:4: key 'bodies[0].orientation.angle': found nothing, expected a number (degrees)"},
    {"dynamic_plane", "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, motion: dynamic}\n",
     "FILE:2: key 'bodies[0].motion': found dynamic, expected fixed or kinematic for a plane"},
    {"turned_plane", "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, orientation: [1, 0, 0, 0]}\n",
     "FILE:2: key 'bodies[0].orientation': found [1, 0, 0, 0], expected no orientation: a plane is turned by its normal"},
    {"unknown_motion", with_body("motion: static"),
     "FILE:3: key 'bodies[0].motion': found static, expected dynamic, fixed or kinematic"},
    {"unknown_material", with_body("mass: 1\n    material: wood"),
     "FILE:4: key 'bodies[0].material': found wood, expected default"},
    {"planar_position", "planar: true\nbodies:\n  - {shape: {disc: {radius: 1}}, mass: 1, position: [0, 1, 0]}\n",
     "FILE:3: key 'bodies[0].position': found [0, 1, 0], expected 0 as the second of three numbers (m; planar scene)"},
    {"planar_spin", "planar: true\nbodies:\n  - {shape: {disc: {radius: 1}}, mass: 1, angular_velocity: [0, 1, 2]}\n",
     "FILE:3: key 'bodies[0].angular_velocity': found [0, 1, 2], expected 0 as the first and third of three numbers (rad/s; "
     "planar scene)"},
    {"planar_turn", "planar: true\nbodies:\n  - {shape: {disc: {radius: 1}}, mass: 1, orientation: [0, 1, 0, 0]}\n",
     "FILE:3: key 'bodies[0].orientation': found [0, 1, 0, 0], expected a turn about y (planar scene)"},
    {"planar_normal", "planar: true\nbodies:\n  - {shape: {plane: {normal: [0, 1, 0]}}}\n",
     "FILE:3: key 'bodies[0].shape.plane.normal': found [0, 1, 0], expected a vector without y component (planar scene)"},
};

const std::vector<BadInput> bad_generators{
    {"two_generators", with_body("mass: 1\n    stack: {count: 2}\n    points: [[0, 0, 0]]"),
     "FILE:4: key 'bodies[0].stack': found a second generator beside points, expected one generator an entry"},
    {"no_count", with_body("mass: 1\n    stack: {}"),
     "FILE:4: key 'bodies[0].stack.count': found nothing, expected an integer >= 1"},
    {"count_of_zero", with_body("mass: 1\n    stack: {count: 0}"),
     "FILE:4: key 'bodies[0].stack.count': found 0, expected an integer >= 1"},
    {"lattice_without_spacing", with_body("mass: 1\n    lattice: {count: 8, columns: [2, 2]}"),
     "FILE:4: key 'bodies[0].lattice.spacing': found nothing, expected a list of 3 numbers > 0 (m)"},
    {"columns", with_body("mass: 1\n    lattice: {count: 8, columns: 2}"),
     "FILE:4: key 'bodies[0].lattice.columns': found 2, expected a list of 2 integers >= 1"},
    {"negative_jitter", with_body("mass: 1\n    lattice: {count: 8, columns: [2, 2], spacing: [1, 1, 1], jitter: -1}"),
     "FILE:4: key 'bodies[0].lattice.jitter': found -1, expected a number >= 0 (m)"},
    {"offsets", with_body("mass: 1\n    stack: {count: 3, offsets: [0, 1]}"),
     "FILE:4: key 'bodies[0].stack.offsets': found [0, 1], expected a list of 3 numbers (m, along x)"},
    {"wall_of_spheres", with_body("mass: 1\n    wall: {bricks: 3, courses: 2}"),
     "FILE:4: key 'bodies[0].wall': found bricks that aren't boxes, expected shape: {box: ...}"},
    {"planes_in_a_stack", "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, stack: {count: 2}}\n",
     "FILE:2: key 'bodies[0].shape': found a plane in a stack, expected a shape that can move"},
    {"shape_beside_a_pile", with_body("mass: 1\n    pile: {count: 1}"),
     "FILE:2: key 'bodies[0].shape': found an unknown key, expected name, material, position, orientation, collide, start, mass, "
     "density, "
     "motion, "
     "velocity, angular_velocity, path, surface_velocity, surface_angular_velocity, anisotropic_friction, force, torque or pile"},
    {"scale_upside_down",
     "bodies:\n  - density: 1\n    pile: {count: 1, columns: [1, 1], mix: [{shape: {sphere: {radius: 1}}, scale: [2, 1]}]}\n",
     "FILE:3: key 'bodies[0].pile.mix[0].scale': found [2, 1], expected the smaller of the two factors first"},
    {"mass_of_a_container", "bodies:\n  - container: {size: [1, 1]}\n    mass: 1\n",
     "FILE:3: key 'bodies[0].mass': found an unknown key, expected name, material, position, orientation, collide, start or "
     "container"},
    {"container_without_size", "bodies:\n  - container: {}\n",
     "FILE:2: key 'bodies[0].container.size': found nothing, expected a list of 2 numbers > 0 (m), in a planar scene of 1"},
    {"narrow_rim", "bodies:\n  - hopper: {opening: [1, 1], rim: [2, 0.5], height: 1, thickness: 0.1}\n",
     "FILE:2: key 'bodies[0].hopper.rim': found [2, 0.5], expected a rim at least as wide as the opening (m)"},
};

const std::vector<BadInput> bad_overrides{
    {"value", ball, "-set time.frames=abc: key 'time.frames': found abc, expected an integer >= 0", {{"time.frames", "abc"}}},
    {"no_value", ball, "-set time.frames=: key 'time.frames': found nothing, expected an integer >= 0", {{"time.frames", ""}}},
    {"unknown_key",
     ball,
     "-set time.frmes=3: key 'time.frmes': found an unknown key (did you mean frames?), expected frame, frames or substeps",
     {{"time.frmes", "3"}}},
    {"unknown_section",
     ball,
     "-set tim.step=3: key 'tim': found an unknown key (did you mean time?), expected title, time, planar, periodic, gravity, "
     "wind, "
     "air_density, solver, "
     "output, materials, bodies, cloths, threads, solids, joints, bonds, couplings, probes, outlets or events",
     {{"tim.step", "3"}}},
    {"place_beyond_the_end",
     ball,
     "-set bodies[1].mass=3: key 'bodies': found a list of 1, expected a list of at least 2",
     {{"bodies[1].mass", "3"}}},
    {"place_in_a_map",
     "time: {frame: 1}\n" + ball,
     "-set time[0]=3: key 'time': found a map, expected a list of at least 1",
     {{"time[0]", "3"}}},
    {"key_of_a_number",
     ball,
     "-set bodies[0].mass.x=3: key 'bodies[0].mass': found 2, expected a map, to set 'x' in it",
     {{"bodies[0].mass.x", "3"}}},
    {"not_yaml", ball, "-set gravity=[1: not YAML: end of sequence flow not found", {{"gravity", "[1"}}},
    {"empty_path",
     ball,
     "-set =1: found the path '', expected keys and places such as time.frames or bodies[0].mass",
     {{"", "1"}}},
    {"broken_path",
     ball,
     "-set bodies[x]=1: found the path 'bodies[x]', expected keys and places such as time.frames or bodies[0].mass",
     {{"bodies[x]", "1"}}},
    {"fault_of_the_file_stays_there",
     "time: {frame: -1}\n" + ball,
     "FILE:1: key 'time.frame': found -1, expected a number > 0 (s)",
     {{"time.frames", "3"}}},
};

INSTANTIATE_TEST_SUITE_P(Files, ReadSceneRefuses, testing::ValuesIn(bad_files), case_name);
INSTANTIATE_TEST_SUITE_P(Values, ReadSceneRefuses, testing::ValuesIn(bad_values), case_name);
INSTANTIATE_TEST_SUITE_P(Bodies, ReadSceneRefuses, testing::ValuesIn(bad_bodies), case_name);
INSTANTIATE_TEST_SUITE_P(Generators, ReadSceneRefuses, testing::ValuesIn(bad_generators), case_name);
INSTANTIATE_TEST_SUITE_P(Overrides, ReadSceneRefuses, testing::ValuesIn(bad_overrides), case_name);

std::string message_of(const std::string& path) {
  try {
    read_scene(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ReadSceneFails, FilesThatCannotBeRead) {
  EXPECT_EQ(message_of("no/such.yaml"),
            "no/such.yaml: found no readable file (No such file or directory), expected a scene (YAML)");
  EXPECT_EQ(message_of("/"), "/: found no readable file (Is a directory), expected a scene (YAML)");
}

TEST(ReadSceneFails, BytesThatAreNoText) {
  const std::string message =
      fault_of(std::string("\x7f"
                           "ELF\x02\x01\x01\0\0\0\x03\0\x3e",
                           13));
  EXPECT_EQ(message.rfind("FILE", 0), 0u) << message;
}

TEST(ReadSceneFails, AnAliasThatHoldsItself) {
  const std::string message = fault_of("title: &a [*a]\n");
  EXPECT_EQ(message.rfind("FILE:1: key 'title[0][0]", 0), 0u) << message;
  EXPECT_NE(message.find("found more than 64 levels"), std::string::npos);
}

}  // namespace
}  // namespace unibody::bad_input_test
