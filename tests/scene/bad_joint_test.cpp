// Faults of joints in a scene file: one message each; and what generators of jointed bodies make.
#include "joints/joint_types.hpp"
#include "scene/scene_text.hpp"
#include "world/shape_library.hpp"

namespace unibody::bad_joint_test {
namespace {

std::string with_joint(const std::string& joint) {
  return "bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1}\n"
         "  - {name: b, shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [1, 0, 0]}\n"
         "  - {name: c, shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - {name: pile, stack: {count: 3}, shape: {sphere: {radius: 0.1}}, mass: 1}\n"
         "joints:\n  - {" +
         joint + "}\n";
}
std::string with_chain(const std::string& chain) {
  return "bodies:\n  - shape: {sphere: {radius: 0.1}}\n    mass: 1\n    chain: {" + chain + "}\n";
}

std::string scene_number(double x) {
  std::ostringstream out;
  out << std::setprecision(17) << x;
  return out.str();
}

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class JointRefuses : public testing::TestWithParam<Fault> {};

TEST_P(JointRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::vector<Fault> faults{
    {"unknown_type", with_joint("type: glue, bodies: [a, b], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].type': found glue, expected ball, hinge, slider, fixed, universal, rope or spring"},
    {"unknown_body", with_joint("type: ball, bodies: [a, d], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies[1]': found d, a name that no entry of bodies has, expected the name of a body, as door or "
     "pile[3], its entry's place in the list, or world"},
    {"no_anchor", with_joint("type: ball, bodies: [a, b]"),
     "FILE:7: key 'joints[0].anchor': found nothing, expected a point (m, world axes), or anchors: a list of 2 points in the "
     "bodies' axes"},
    {"no_axis", with_joint("type: hinge, bodies: [a, b], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].axis': found nothing, expected a vector of length 1 (world axes), or axes: a list of 2 in the "
     "bodies' axes"},
    {"limits_of_a_ball", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], limits: [0, 1]"),
     "FILE:7: key 'joints[0].limits': found an unknown key, expected collide, compliance, damping, strength, swing_limit, "
     "twist_limits, "
     "name, type, bodies, anchors, anchor, axis or axes"},
    {"cone_without_axis", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], swing_limit: 30"),
     "FILE:7: key 'joints[0].axis': found nothing, expected a vector of length 1 (world axes), or axes: a list of 2 in the "
     "bodies' axes"},
    {"cone_beyond_all", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], swing_limit: 181"),
     "FILE:7: key 'joints[0].swing_limit': found 181, expected a number in (0, 180] (degrees)"},
    {"twist_upside_down", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], twist_limits: [9, 1]"),
     "FILE:7: key 'joints[0].twist_limits': found [9, 1], expected the lower limit before the upper (degrees)"},
    {"world_first", with_joint("type: ball, bodies: [world, a], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies[0]': found world, expected a body; the second may be world"},
    {"nothing_moves", with_joint("type: ball, bodies: [b, world], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies': found no body that moves freely, expected at least one dynamic body"},
    {"itself", with_joint("type: ball, bodies: [a, a], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies': found the same body twice, expected two bodies"},
    {"a_plane", with_joint("type: ball, bodies: [a, c], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies[1]': found c, a plane, expected a body that is no plane"},
    {"several", with_joint("type: ball, bodies: [a, pile], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies[1]': found pile, an entry of 3 bodies, expected one of them, as pile[0]"},
    {"beyond_the_last", with_joint("type: ball, bodies: [a, 'pile[3]'], anchor: [0, 0, 0]"),
     "FILE:7: key 'joints[0].bodies[1]': found 'pile[3]' of 3, expected a number below 3"},
    {"limits_upside_down", with_joint("type: hinge, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], limits: [10, -10]"),
     "FILE:7: key 'joints[0].limits': found [10, -10], expected the lower limit before the upper (degrees)"},
    {"motor_without_strength", with_joint("type: hinge, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], motor: {speed: 1}"),
     "FILE:7: key 'joints[0].motor.max_torque': found nothing, expected a number >= 0 (N m)"},
    {"motor_of_a_ball", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], motor: {speed: 1, max_torque: 1}"),
     "FILE:7: key 'joints[0].motor': found an unknown key, expected collide, compliance, damping, strength, swing_limit, "
     "twist_limits, "
     "name, type, bodies, anchors, anchor, axis or axes"},
    {"two_targets",
     with_joint("type: slider, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], motor: {speed: 1, offset: 2, max_force: 1}"),
     "FILE:7: key 'joints[0].motor.offset': found offset beside speed, expected only one of speed and offset"},
    {"negative_compliance", with_joint("type: ball, bodies: [a, b], anchor: [0, 0, 0], compliance: -1"),
     "FILE:7: key 'joints[0].compliance': found -1, expected a number >= 0 (m/N)"},
    {"axes_not_square",
     with_joint("type: universal, bodies: [a, b], anchor: [0, 0, 0], axis: [0, 0, 1], second_axis: [0, 0.6, 0.8]"),
     "FILE:7: key 'joints[0].second_axis': found [0, 0.6, 0.8], expected a vector of length 1, square to the axis"},
    {"rope_without_ends", with_joint("type: rope, bodies: [a, b]"),
     "FILE:7: key 'joints[0].points': found nothing, expected a list of 2 points (m), or anchors: of 2 points in the bodies' "
     "axes"},
    {"hinge_across_the_plane",
     "planar: true\nbodies:\n  - {name: a, shape: {disc: {radius: 0.1}}, mass: 1}\njoints:\n"
     "  - {type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n",
     "FILE:5: key 'joints[0].axis': found [0, 0, 1], expected an axis along y (planar scene)"},
    {"rope_out_of_the_plane",
     "planar: true\nbodies:\n  - {name: a, shape: {disc: {radius: 0.1}}, mass: 1}\njoints:\n"
     "  - {type: rope, bodies: [a, world], points: [[0, 0, 0], [0, 1, 1]]}\n",
     "FILE:5: key 'joints[0].points[1]': found [0, 1, 1], expected 0 as the second of three numbers (m; planar scene)"},
    {"anchors_out_of_the_plane",
     "planar: true\nbodies:\n  - {name: a, shape: {disc: {radius: 0.1}}, mass: 1}\njoints:\n"
     "  - {type: ball, bodies: [a, world], anchors: [[0, 0.1, 0], [0, 0, 0]]}\n",
     "FILE:5: key 'joints[0].anchors[0]': found [0, 0.1, 0], expected 0 as the second of three numbers (m; planar scene)"},
    {"slider_out_of_the_plane",
     "planar: true\nbodies:\n  - {name: a, shape: {disc: {radius: 0.1}}, mass: 1}\njoints:\n"
     "  - {type: slider, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 1, 0]}\n",
     "FILE:5: key 'joints[0].axis': found [0, 1, 0], expected an axis without y component (planar scene)"},
    {"hinge_at_a_particle",
     "bodies:\n  - {name: a, shape: {particle: {radius: 0.1}}, mass: 1}\njoints:\n"
     "  - {type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n",
     "FILE:4: key 'joints[0].bodies[0]': found hinge at a particle, which does not turn, expected a body that turns; ball, "
     "rope and spring also hold particles"},
    {"spring_without_ends", with_joint("type: spring, bodies: [a, b]"),
     "FILE:7: key 'joints[0].points': found nothing, expected a list of 2 points (m), or anchors: of 2 points in the bodies' "
     "axes"},
    {"spring_of_no_length", with_joint("type: spring, bodies: [a, b], points: [[0, 0, 0], [1, 0, 0]], length: 0"),
     "FILE:7: key 'joints[0].length': found 0, expected a number > 0 (m)"},
    {"chain_of_fixed_particles",
     "bodies:\n  - shape: {particle: {radius: 0.1}}\n    mass: 1\n    chain: {count: 2, from: [0, 0, 0], to: [1, 0, 0], joint: "
     "{type: fixed}}\n",
     "FILE:4: key 'bodies[0].chain.joint': found fixed at a particle, which does not turn, expected a body that turns; ball, "
     "rope and spring also hold particles"},
    {"chain_of_no_length", with_chain("count: 2, from: [0, 0, 0], to: [0, 0, 0], joint: {type: ball}"),
     "FILE:4: key 'bodies[0].chain.to': found [0, 0, 0], expected another point than from (m)"},
    {"chain_of_sliders", with_chain("count: 2, from: [0, 0, 0], to: [1, 0, 0], joint: {type: slider}"),
     "FILE:4: key 'bodies[0].chain.joint.type': found slider, expected ball, hinge, universal or fixed"},
    {"tree_without_density", "bodies:\n  - mass: 1\n    tree: {levels: 3, length: 1, joint: {type: ball}}\n",
     "FILE:3: key 'bodies[0].tree': found no density, expected density: a number > 0 (kg/m^3), since links differ in size"},
};

INSTANTIATE_TEST_SUITE_P(Faults, JointRefuses, testing::ValuesIn(faults),
                         [](const auto& fault) { return std::string(fault.param.name); });

Vec3 place_of(const Scene& scene, Id id, const Vec3& in_body) {
  const BodyState s = id < 0 ? BodyState{} : scene.body(id).state;
  return s.position + s.orientation * in_body;
}

// Of a scene as read, how far a joint is from closed.
double opening(const Scene& scene, const Joint& joint) {
  const auto end = [&](std::size_t e) {
    const BodyState s = joint.ids[e] < 0 ? BodyState{} : scene.body(joint.ids[e]).state;
    return JointEnd{s.position, (s.orientation * joint.frame[e]).toRotationMatrix(),
                    s.position + s.orientation * joint.anchor[e]};
  };
  double worst = 0;
  with_joint_type(static_cast<std::uint8_t>(joint.kind), [&]<class T>() {
    JointRows<T::rows> rows;
    T::evaluate(end(0), end(1), rows);
    for (const double value : rows.value) worst = std::max(worst, std::abs(value));
  });
  return worst;
}

TEST(Articulated, GeneratorsMakeClosedJointsWhereverTheyArePlaced) {
  const Scene scene = scene_from(R"(
bodies:
  - {name: first, shape: {sphere: {radius: 0.1}}, mass: 1}
  - shape: {box: {size: [0.3, 0.1, 0.1]}}
    mass: 1
    position: [1, 2, 3]
    orientation: {axis: [0.6, 0, 0.8], angle: 50}
    chain: {count: 5, from: [0, 1, 0], to: [-2, 0, 1], held: both, joint: {type: hinge, axis: [0, 1, 0]}}
  - tree: {levels: 4, branches: 3, length: 1, held: true, joint: {type: universal, axis: [0, 0, 1], second_axis: [1, 0, 0]}}
    density: 500
    position: [1, -2, 3]
    orientation: {axis: [0, 0.6, 0.8], angle: 20}
  - ragdolls: {count: 3, columns: [2, 1], spacing: [2, 2, 2]}
    density: 900
    position: [0, 9, 0]
)");
  EXPECT_EQ(scene.body_count(), 1 + 5 + 40 + 33);
  ASSERT_EQ(scene.joints.size(), 6u + 40 + 30);
  for (const Joint& joint : scene.joints) EXPECT_LT(opening(scene, joint), 1e-13);
  // The chain's ends are where the file puts them.
  const Quat turn(Eigen::AngleAxisd(50 * M_PI / 180, Vec3(0.6, 0, 0.8)));
  EXPECT_LT((scene.joints[0].anchor[1] - (Vec3(1, 2, 3) + turn * Vec3(0, 1, 0))).norm(), 1e-13);
  EXPECT_LT((scene.joints[5].anchor[1] - (Vec3(1, 2, 3) + turn * Vec3(-2, 0, 1))).norm(), 1e-13);
  // No two joints of a colour share a body; as few colours as the most joints at a body.
  for (const Joint& a : scene.joints)
    for (const Joint& b : scene.joints) {
      if (&a == &b || a.colour != b.colour) continue;
      for (const Id i : a.ids)
        for (const Id k : b.ids) EXPECT_TRUE(i < 0 || i != k);
    }
  EXPECT_LE(scene.joint_colours, 5);
}

// Principal axes turned far from those in which the shape is given: a point of the shape as the file has it, from the centre of
// mass, and a direction in its axes, are where position and orientation put them.
TEST(BodyPoints, AreInTheAxesInWhichTheShapeIsGiven) {
  const Vec3 position(0.3, -1, 2), corner(0.7, -0.2, 0.4), direction(0.6, 0, 0.8);
  const Quat turn(Eigen::AngleAxisd(M_PI / 3, Vec3(0, 0.6, 0.8)));
  const auto list = [](const Vec3& x) {
    return "[" + scene_number(x.x()) + ", " + scene_number(x.y()) + ", " + scene_number(x.z()) + "]";
  };
  for (const std::string shape :
       {"hull: {points: [[0, 0, 0], [1, 0, 0], [0, 0.6, 0], [0, 0, 0.3]]}",
        "compound: {parts: [{shape: {box: {size: [0.4, 0.1, 0.1]}}}, {shape: {capsule: {radius: 0.05, length: 0.3}}, position: "
        "[0.2, 0.1, 0.1], orientation: {axis: [0.6, 0.8, 0], angle: 40}}]}",
        "box: {size: [0.3, 0.2, 0.1]}"}) {
    const std::string bodies = "bodies:\n  - {name: a, shape: {box: {size: [1, 1, 1]}}, mass: 1}\n  - {name: b, shape: {" +
                               shape + "}, mass: 1, position: " + list(position) +
                               ", orientation: {axis: [0, 0.6, 0.8], angle: 60}}\njoints:\n";
    const Vec3 at = position + turn * corner, along = turn * direction;
    const Scene scene = scene_from(
        bodies + "  - {type: hinge, bodies: [b, world], anchors: [" + list(corner) + ", " + list(at) + "], axes: [" +
        list(direction) + ", " + list(along) + "]}\n" + "  - {type: hinge, bodies: [a, b], anchors: [" + list(at) + ", " +
        list(corner) + "], axes: [" + list(along) + ", " + list(direction) + "], motor: {angle: 0, max_torque: 1}}\n" +
        "  - {type: hinge, bodies: [b, world], anchor: " + list(at) + ", axis: " + list(along) + "}\n" +
        "  - {type: rope, bodies: [b, a], anchors: [" + list(corner) + ", [0, 0, 0]]}\n");
    const Quat frame = frame_of(scene.body(1).properties.shape);
    EXPECT_TRUE(shape[0] == 'b' || frame.angularDistance(Quat::Identity()) > 0.2) << shape;
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_LT(opening(scene, scene.joints[j]), 1e-14) << shape << ' ' << j;
      const std::size_t end = j == 1 ? 1 : 0;
      EXPECT_LT((place_of(scene, 1, scene.joints[j].anchor[end]) - at).norm(), 1e-14) << shape << ' ' << j;
    }
    EXPECT_NEAR(scene.joints[3].length, at.norm(), 1e-14) << shape;
  }
}

// A corner of a hull, as the file gives it, is a corner of the hull in contacts.
TEST(BodyPoints, OfAHullAreItsCorners) {
  const Scene scene = scene_from(
      "bodies:\n  - {name: b, shape: {hull: {points: [[0, 0, 0], [1, 0, 0], [0, 0.6, 0], [0, 0, 0.3]]}}, mass: 1, position: [3, "
      "2, "
      "1], orientation: {axis: [0, 1, 0], angle: 70}}\njoints:\n"
      "  - {type: ball, bodies: [b, world], anchors: [[0.75, -0.15, -0.075], [0, 0, 0]]}\n");  // the mean of the corners is its
                                                                                               // centre
  double nearest = HUGE_VAL;
  for (const Vec3& x : shape_library().hulls[scene.body(0).properties.shape.data].corners)
    nearest = std::min(nearest, (x - scene.joints[0].anchor[0]).norm());
  EXPECT_LT(nearest, 1e-14);
}

}  // namespace
}  // namespace unibody::bad_joint_test
