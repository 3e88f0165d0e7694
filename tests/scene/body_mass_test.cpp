// How mass lies in bodies: densities of parts, parts that overlap, and a centre of mass and inertia as given; by closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/compound_mass.hpp"
#include "world/shape_library.hpp"

namespace unibody::body_mass_test {

namespace {

Body body_of(const std::string& entry) { return small_worlds::scene_from_text("bodies:\n  - {" + entry + "}\n").body(0); }

// Moments about the centre of mass in the axes in which the shape is given (kg m^2).
Mat3 inertia_of(const Body& body) {
  const Mat3 axes = frame_of(body.properties.shape).toRotationMatrix();
  return axes * body.properties.inertia.asDiagonal() * axes.transpose();
}

Vec3 centre_of(const Body& body) { return shape_library().compounds[body.properties.shape.data].centre; }

Mat3 box_inertia(double mass, const Vec3& size, const Vec3& from_centre) {
  const Vec3 s = size.cwiseAbs2();
  const Mat3 own = mass / 12 * Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()).asDiagonal();
  return own + mass * (from_centre.squaredNorm() * Mat3::Identity() - from_centre * from_centre.transpose());
}

}  // namespace

// The body is a hammer: its handle is of wood and lies along z, and its head is of steel and lies across the handle's end.
TEST(BodyMass, PartsHaveTheirDensities) {
  const std::string parts =
      "shape: {compound: {parts: [{shape: {box: {size: [0.04, 0.02, 0.3]}}, density: 700}, "
      "{shape: {box: {size: [0.12, 0.04, 0.04]}}, position: [0.01, 0, 0.17], density: 7800}]}}";
  const double wood = 700 * 0.04 * 0.02 * 0.3, steel = 7800 * 0.12 * 0.04 * 0.04;
  const Vec3 head(0.01, 0, 0.17), centre = steel / (wood + steel) * head;
  const Mat3 expected = box_inertia(wood, {0.04, 0.02, 0.3}, -centre) + box_inertia(steel, {0.12, 0.04, 0.04}, head - centre);
  const Body hammer = body_of(parts);
  EXPECT_NEAR(hammer.properties.mass, wood + steel, 1e-12);
  EXPECT_LT((centre_of(hammer) - centre).norm(), 1e-14);
  EXPECT_LT((inertia_of(hammer) - expected).norm(), 1e-14);
  const Body heavy = body_of(parts + ", mass: 5");  // the densities then say in which proportion
  EXPECT_EQ(heavy.properties.mass, 5);
  EXPECT_LT((inertia_of(heavy) - 5 / (wood + steel) * expected).norm(), 1e-13);
}

// Two boxes that overlap by a half, and are one box together, whichever way they are turned.
TEST(BodyMass, OverlapCountsOnce) {
  const std::string parts =
      "{shape: {box: {size: [0.2, 0.1, 0.1]}}, position: [-0.05, 0, 0]}, {shape: {box: {size: [0.1, 0.2, 0.1]}}, position: "
      "[0.05, "
      "0, 0], orientation: {axis: [0, 0, 1], angle: 90}}";
  const Body once = body_of("density: 1000, shape: {compound: {overlap: once, parts: [" + parts + "]}}");
  EXPECT_NEAR(once.properties.mass, 1000 * 0.3 * 0.1 * 0.1, 1e-9);
  EXPECT_LT(centre_of(once).norm(), 1e-9);
  EXPECT_LT((inertia_of(once) - box_inertia(3, {0.3, 0.1, 0.1}, Vec3::Zero())).norm(), 1e-6);
  const Body twice = body_of("density: 1000, shape: {compound: {parts: [" + parts + "]}}");
  EXPECT_NEAR(twice.properties.mass, 4, 1e-9);
}

// Two balls of radius r whose centres are d apart overlap in a lens of volume pi (4 r + d) (2 r - d)^2 / 12; the first one's
// density counts there.
TEST(BodyMass, TheFirstPartHasTheLens) {
  const double r = 0.1, d = 0.12, lens = M_PI * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12, ball = 4 * M_PI / 3 * r * r * r;
  const Body pair = body_of(
      "shape: {compound: {overlap: once, parts: [{shape: {sphere: {radius: 0.1}}, density: 1000}, "
      "{shape: {sphere: {radius: 0.1}}, position: [0.12, 0, 0], density: 3000}]}}");
  EXPECT_NEAR(pair.properties.mass, 1000 * ball + 3000 * (ball - lens), 2e-3 * 3000 * lens);
  EXPECT_NEAR(volume(pair.properties.shape), 2 * ball - lens, 2e-3 * lens);
}

// Each shape knows its inside: its volume is that of the points that it contains.
TEST(BodyMass, WhatOverlapsWhollyCountsOnce) {
  for (const std::string shape :
       {"sphere: {radius: 0.1}", "box: {size: [0.2, 0.1, 0.3]}", "capsule: {radius: 0.1, length: 0.2}",
        "cylinder: {radius: 0.1, length: 0.2}", "hull: {points: [[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.4]]}"}) {
    const std::string part = "{shape: {" + shape + "}, orientation: {axis: [0.6, 0, 0.8], angle: 40}}";
    const auto mass = [&](const std::string& parts) {
      return body_of("density: 1000, shape: {compound: {overlap: once, parts: [" + parts + "]}}").properties.mass;
    };
    EXPECT_NEAR(mass(part + ", " + part) / mass(part), 1, 2e-3) << shape;
  }
}

TEST(BodyMass, CentreAndInertiaAsGiven) {
  const Body body = body_of(
      "shape: {box: {size: [0.2, 0.2, 0.4]}}, mass: 2, position: [1, 2, 3], centre_of_mass: [0.01, 0.02, -0.1], inertia: [0.03, "
      "0.04, 0.02, 0.004, -0.003, 0.002]");
  Mat3 expected;
  expected << 0.03, 0.004, -0.003, 0.004, 0.04, 0.002, -0.003, 0.002, 0.02;
  EXPECT_LT((inertia_of(body) - expected).norm(), 1e-15);
  EXPECT_EQ(body.state.position, Vec3(1, 2, 3));
  const Compound& compound = shape_library().compounds[body.properties.shape.data];
  const Vec3 middle = body.state.orientation * compound.parts[0].place;  // of the box, from the centre of mass
  EXPECT_LT((middle - Vec3(-0.01, -0.02, 0.1)).norm(), 1e-15);
}

// Of a hull or compound the axes are those in which its points or parts are given, and without centre_of_mass its own centre
// stays.
TEST(BodyMass, InertiaOfAHullIsAboutItsOwnCentre) {
  const std::string hull = "shape: {hull: {points: [[1, 0, 0], [1.3, 0, 0], [1, 0.2, 0], [1, 0, 0.4]]}}, mass: 2";
  const Body body = body_of(hull + ", inertia: [0.03, 0.04, 0.02, 0, 0, 0]");
  EXPECT_LT((centre_of(body) - Vec3(1.075, 0.05, 0.1)).norm(), 1e-12);
  EXPECT_LT((inertia_of(body) - Mat3(Vec3(0.03, 0.04, 0.02).asDiagonal())).norm(), 1e-15);
  const Body moved = body_of(
      "shape: {compound: {parts: [{shape: {sphere: {radius: 0.1}}, position: [1, 0, 0]}, {shape: {sphere: "
      "{radius: 0.1}}, position: [2, 0, 0]}]}}, mass: 2, centre_of_mass: [1.9, 0, 0], inertia: [1, 2, 2]");
  EXPECT_LT((centre_of(moved) - Vec3(1.9, 0, 0)).norm(), 1e-12);
}

// A cube on a slope of 40 degrees tips over its lower edge where its centre of mass is more than 0.1 m / tan 40 above its base.
TEST(BodyMass, ALowCentreKeepsACubeFromTipping) {
  const double slope = 40 * M_PI / 180, threshold = 0.1 / std::tan(slope);
  for (const double above : {threshold - 0.01, threshold + 0.01}) {
    const double at = above - 0.1;  // from the middle
    small_worlds::Experiment run(small_worlds::scene_from_text(
        "materials: {rubber: {friction: 2}}\ngravity: [" + std::to_string(9.81 * std::sin(slope)) + ", 0, " +
        std::to_string(-9.81 * std::cos(slope)) + "]\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n" +
        "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, " + std::to_string(above) +
        "], centre_of_mass: [0, 0, " + std::to_string(at) + "], inertia: [0.01, 0.01, 0.01]}\ntime: {substeps: 4}\n"));
    const Quat start = run.state(1).orientation;
    run.seconds(2);
    const double turned = run.state(1).orientation.angularDistance(start);
    if (above < threshold) {
      EXPECT_LT(turned, 0.01);
    } else {
      EXPECT_GT(turned, 0.5);
    }
  }
}

}  // namespace unibody::body_mass_test
