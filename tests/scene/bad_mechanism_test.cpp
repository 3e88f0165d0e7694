// Faults of couplings, springs of joints, `collide` and of how mass lies in bodies: one message each.
#include "scene/scene_text.hpp"

namespace unibody::bad_mechanism_test {
namespace {

const std::string joints =
    "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\n"
    "joints:\n"
    "  - {name: axle, type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n"
    "  - {name: rail, type: slider, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n"
    "  - {name: socket, type: ball, bodies: [a, world], anchor: [0, 0, 0]}\n"
    "  - {name: axles, type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n"
    "  - {name: axles, type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n";
std::string with_coupling(const std::string& coupling) { return joints + "couplings:\n  - {" + coupling + "}\n"; }
std::string with_spring(const std::string& spring) {
  return "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\njoints:\n"
         "  - {type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1], spring: {" +
         spring + "}}\n";
}
std::string with_slider(const std::string& motor) {
  return "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\njoints:\n"
         "  - {type: slider, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1], motor: {" +
         motor + "}}\n";
}
std::string with_body(const std::string& body) { return "bodies:\n  - {name: a, " + body + "}\n"; }
const std::string ball = "shape: {sphere: {radius: 0.1}}, mass: 1, ";

// Two balls that touch, one far away, a plane and a particle.
const std::string neighbours =
    "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\n"
    "  - {name: b, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.2, 0, 0]}\n"
    "  - {name: c, shape: {sphere: {radius: 0.1}}, mass: 1, position: [2, 0, 0]}\n"
    "  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}, position: [0, 0, -5]}\n"
    "  - {name: dust, shape: {particle: {radius: 0.1}}, mass: 1, position: [0, 3, 0]}\n";
std::string with_bond(const std::string& bond) { return neighbours + "bonds:\n  - {" + bond + "}\n"; }
std::string with_joint(const std::string& joint) { return neighbours + "joints:\n  - {bodies: [a, b], " + joint + "}\n"; }
std::string with_event(const std::string& event) { return neighbours + "events:\n  - {when: {time: 1}, " + event + "}\n"; }

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class MechanismRefuses : public testing::TestWithParam<Fault> {};

TEST_P(MechanismRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::vector<Fault> faults{
    {"bond_of_nobody", with_bond("gap: 0.1"),
     "FILE:8: key 'bonds[0].bodies': found nothing, expected the name of an entry of bodies, or a list of names"},
    {"bond_of_unknown", with_bond("bodies: [a, bb]"),
     "FILE:8: key 'bonds[0].bodies[1]': found bb, a name that no entry of bodies has, expected the name of an entry of bodies, "
     "or a list of names"},
    {"bond_of_one_twice", with_bond("bodies: [a, a]"),
     "FILE:8: key 'bonds[0].bodies[1]': found a twice, expected each name once"},
    {"bond_of_a_plane", with_bond("bodies: [a, floor]"),
     "FILE:8: key 'bonds[0].bodies[1]': found floor, a plane, expected bodies that are no planes"},
    {"bond_of_a_particle", with_bond("bodies: [a, dust]"),
     "FILE:8: key 'bonds[0].bodies[1]': found fixed at a particle, which does not turn, expected a body that turns; ball, rope "
     "and spring also hold particles"},
    {"bond_of_far_bodies", with_bond("bodies: [a, c]"),
     "FILE:8: key 'bonds[0].bodies': found bodies of which no two are next to each other, expected bodies nearer than gap"},
    {"bond_with_negative_gap", with_bond("bodies: [a, b], gap: -1"),
     "FILE:8: key 'bonds[0].gap': found -1, expected a number >= 0 (m)"},
    {"strength_of_nothing", with_bond("bodies: [a, b], strength: {duration: 1}"),
     "FILE:8: key 'bonds[0].strength': found no force or torque that breaks it, expected one of the keys force, torque, tension, "
     "shear, bending or twisting"},
    {"strength_of_nought", with_bond("bodies: [a, b], strength: {tension: 0}"),
     "FILE:8: key 'bonds[0].strength.tension': found 0, expected a number > 0 (N)"},
    {"beam_beside_compliance", with_bond("bodies: [a, b], compliance: 1e-6, beam: {radius: 0.1}"),
     "FILE:8: key 'bonds[0].compliance': found compliance beside beam, expected one of the two"},
    {"beam_beside_strength", with_bond("bodies: [a, b], strength: {force: 1}, beam: {radius: 0.1}"),
     "FILE:8: key 'bonds[0].strength': found strength beside beam, expected one of the two"},
    {"beam_without_radius", with_bond("bodies: [a, b], beam: {radius: 0}"),
     "FILE:8: key 'bonds[0].beam.radius': found 0, expected a number > 0 (m)"},
    {"torque_of_a_rope", with_joint("type: rope, points: [[0, 0, 0], [0.2, 0, 0]], strength: {torque: 1}"),
     "FILE:8: key 'joints[0].strength.torque': found an unknown key, expected force or duration"},
    {"tension_of_a_joint", with_joint("type: fixed, anchor: [0.1, 0, 0], strength: {tension: 1}"),
     "FILE:8: key 'joints[0].strength.tension': found an unknown key, expected force, torque or duration"},
    {"negative_duration", with_joint("type: fixed, anchor: [0.1, 0, 0], strength: {force: 1, duration: -1}"),
     "FILE:8: key 'joints[0].strength.duration': found -1, expected a number >= 0 (s)"},
    {"release_of_nothing", with_event("do: release"),
     "FILE:8: key 'events[0].bodies': found nothing, expected the name of an entry of bodies, or a list of names"},
    {"release_of_unknown_joint", with_event("do: release, joints: glue"),
     "FILE:8: key 'events[0].joints': found glue, a name that no joint has, expected the name of a joint"},
    {"removal_of_joints", with_event("do: remove, bodies: c, joints: j"),
     "FILE:8: key 'events[0].joints': found joints beside do: remove, expected the keys bodies"},
    {"unknown_joint", with_coupling("joints: [axel, rail], ratio: 1"),
     "FILE:10: key 'couplings[0].joints[0]': found axel, a name that no joint has (did you mean axle?), expected the name of a "
     "hinge or slider"},
    {"joint_without_coordinate", with_coupling("joints: [axle, socket], ratio: 1"),
     "FILE:10: key 'couplings[0].joints[1]': found socket, a joint of type ball, expected the name of a hinge or slider"},
    {"name_of_two_joints", with_coupling("joints: [axle, axles], ratio: 1"),
     "FILE:10: key 'couplings[0].joints[1]': found axles, the name of 2 joints, expected a name of one joint"},
    {"same_joint_twice", with_coupling("joints: [axle, axle], ratio: 1"),
     "FILE:10: key 'couplings[0].joints': found the same joint twice, expected two joints"},
    {"one_joint", with_coupling("joints: [axle], ratio: 1"),
     "FILE:10: key 'couplings[0].joints': found [axle], expected a list of 2 names of hinges or sliders"},
    {"no_ratio", with_coupling("joints: [axle, rail]"),
     "FILE:10: key 'couplings[0].ratio': found nothing, expected a number (rad/rad, m/rad, rad/m or m/m)"},
    {"ratio_of_nought", with_coupling("joints: [axle, rail], ratio: 0"),
     "FILE:10: key 'couplings[0].ratio': found 0, expected a number other than 0"},
    {"spring_without_force", with_spring("rest: 10"),
     "FILE:4: key 'joints[0].spring': found neither stiffness nor damping, expected one of the two > 0"},
    {"rest_of_a_damper", with_spring("damping: 1, rest: 10"),
     "FILE:4: key 'joints[0].spring.rest': found 10, expected no such key of a damper alone"},
    {"negative_stiffness", with_spring("stiffness: -1"),
     "FILE:4: key 'joints[0].spring.stiffness': found -1, expected a number >= 0 (N m/rad)"},
    {"cell_without_room", with_body("triaxial: {size: [1, 0, 1], thickness: 0.1}"),
     "FILE:2: key 'bodies[0].triaxial.size': found [1, 0, 1], expected three numbers > 0 (m)"},
    {"cell_that_nothing_moves", with_body("triaxial: {size: [1, 1, 1], thickness: 0.1, x: {}}"),
     "FILE:2: key 'bodies[0].triaxial.x.pressure': found nothing, expected a pressure (Pa), a closing_speed (m/s), or both"},
    {"cell_that_pulls", with_body("triaxial: {size: [1, 1, 1], thickness: 0.1, x: {pressure: -1}}"),
     "FILE:2: key 'bodies[0].triaxial.x.pressure': found -1, expected a number >= 0 (Pa)"},
    {"cell_across_the_plane", "planar: true\n" + with_body("triaxial: {size: [1, 1, 1], thickness: 0.1, y: {pressure: 1}}"),
     "FILE:3: key 'bodies[0].triaxial.y': found plates along y, expected x and z alone (planar scene)"},
    {"probe_of_no_cell", with_body("triaxial: {size: [1, 1, 1], thickness: 0.1}") + "probes: [{name: p, cell: q}]\n",
     "FILE:3: key 'probes[0].cell': found q, a name that no entry of bodies has, expected the name of an entry of bodies with "
     "triaxial"},
    {"pressure_without_area", with_slider("speed: 1, max_pressure: 1"),
     "FILE:4: key 'joints[0].motor.area': found nothing, expected the area (m^2) on which max_pressure acts"},
    {"area_without_pressure", with_slider("speed: 1, max_force: 1, area: 1"),
     "FILE:4: key 'joints[0].motor.area': found 1, expected no such key without max_pressure"},
    {"force_and_pressure", with_slider("speed: 1, max_force: 1, max_pressure: 1, area: 1"),
     "FILE:4: key 'joints[0].motor.max_pressure': found max_pressure beside max_force, expected only one of max_force and "
     "max_pressure"},
    {"collide_with_nobody", with_body(ball + "collide: {}"),
     "FILE:2: key 'bodies[0].collide.with': found nothing, expected a list of names of entries, or without: one"},
    {"collide_with_and_without", with_body(ball + "collide: {with: [a], without: [a]}"),
     "FILE:2: key 'bodies[0].collide.without': found without beside with, expected only one of with and without"},
    {"collide_with_unknown", with_body(ball + "collide: {with: [b]}"),
     "FILE:2: key 'bodies[0].collide.with[0]': found b, a name that no entry has, expected the name of an entry of bodies, "
     "cloths, "
     "threads or solids"},
    {"collide_with_no_list", with_body(ball + "collide: {with: a}"),
     "FILE:2: key 'bodies[0].collide.with': found a, expected a list of names of entries, which may be empty"},
    {"densities_of_some_parts",
     with_body("shape: {compound: {parts: [{shape: {sphere: {radius: 1}}, density: 1}, {shape: {sphere: {radius: 1}}}]}}"),
     "FILE:2: key 'bodies[0].shape.compound.parts[1].density': found nothing, expected a density (kg/m^3), since other parts "
     "have "
     "one"},
    {"density_beside_densities",
     with_body("density: 1, shape: {compound: {parts: [{shape: {sphere: {radius: 1}}, density: 1}]}}"),
     "FILE:2: key 'bodies[0].density': found a density beside densities of the parts, expected the one or the other, or a mass"},
    {"no_mass", with_body("shape: {compound: {parts: [{shape: {sphere: {radius: 1}}}]}}"),
     "FILE:2: key 'bodies[0].mass': found nothing, expected a mass (kg) or a density (kg/m^3)"},
    {"densities_in_a_mix",
     with_body("density: 1, pile: {count: 1, columns: [1, 1], mix: [{shape: {compound: {parts: [{shape: {sphere: {radius: 1}}, "
               "density: 1}]}}}]}"),
     "FILE:2: key 'bodies[0].pile.mix[0].shape': found densities of parts in a mix, expected the density or mass of the entry "
     "alone"},
    {"centre_without_inertia", with_body(ball + "centre_of_mass: [0, 0, 1]"),
     "FILE:2: key 'bodies[0].inertia': found nothing, expected moments about the centre of mass (kg m^2), beside centre_of_mass"},
    {"impossible_moments", with_body(ball + "inertia: [1, 1, 1, 1, 0, 0]"),
     "FILE:2: key 'bodies[0].inertia': found [1, 1, 1, 1, 0, 0], expected six moments (kg m^2) whose principal ones are > 0, "
     "none "
     "larger than the sum of the other two"},
    {"centre_of_what_is_fixed", with_body("shape: {sphere: {radius: 0.1}}, motion: fixed, centre_of_mass: [0, 0, 1]"),
     "FILE:2: key 'bodies[0].centre_of_mass': found [0, 0, 1], expected no such key for a fixed or kinematic body"},
    {"centre_in_a_plane", "planar: true\n" + with_body(ball + "centre_of_mass: [0, 0, 1], inertia: [1, 1, 1]"),
     "FILE:3: key 'bodies[0].centre_of_mass': found [0, 0, 1], expected no such key in a planar scene"},
    {"centre_of_a_particle", with_body("shape: {particle: {radius: 0.1}}, mass: 1, centre_of_mass: [0, 0, 1]"),
     "FILE:2: key 'bodies[0].centre_of_mass': found [0, 0, 1], expected no such key for a particle: it does not turn"},
};

INSTANTIATE_TEST_SUITE_P(Faults, MechanismRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace unibody::bad_mechanism_test
