// Where manifolds get an inner ring, and what it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collide/narrowphase.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::face_patch_test {

namespace {

// The manifolds of a body of this shape that lies on a plane and turns about the vertical axis.
Contacts contacts_of(const std::string& shape, double height, double spin, const std::string& more = "") {
  const Scene scene = scene_from_text("bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: " + shape +
                                      ", density: 1000, position: [0, 0, " + std::to_string(height) +
                                      "], angular_velocity: [0, 0, " + std::to_string(spin) + "]" + more + "}\n");
  Experiment run(scene);
  CollideSettings settings;
  settings.step = 0.016, settings.margin = 0.001, settings.gravity = Vec3(0, 0, -9.81);
  settings.friction = {0.5}, settings.material_count = 1;
  Contacts contacts;
  collide(run.world(), settings, contacts);
  return contacts;
}

double distance(const Contacts& c, std::size_t point) { return c.points[point].position.head<2>().norm(); }

}  // namespace

// The points of a disc have a mean distance of 2/3 R from its middle, those of a square (sqrt 2 + asinh 1) / 6 of its side.
TEST(FacePatch, TheRingIsAtTheMeanDistanceOfTheArea) {
  const struct {
    std::string shape;
    double height, corner, ring;
  } cases[] = {{"{cylinder: {radius: 0.1, length: 0.2}}", 0.1, 0.1, 0.2 / 3},
               {"{box: {size: [0.2, 0.2, 0.2]}}", 0.1, std::sqrt(0.02), 0.2 * (std::sqrt(2) + std::asinh(1)) / 6}};
  for (const auto& [shape, height, corner, ring] : cases) {
    const Contacts c = contacts_of(shape, height, 3);
    ASSERT_EQ(c.manifolds.size(), 2u) << shape;
    EXPECT_FALSE(c.manifolds[0].is_inner_ring);
    ASSERT_TRUE(c.manifolds[1].is_inner_ring);
    ASSERT_EQ(c.manifolds[1].count, c.manifolds[0].count);
    for (std::uint32_t k = 0; k < c.manifolds[0].count; ++k) {
      EXPECT_NEAR(distance(c, c.manifolds[0].first + k), corner, 1e-9);
      EXPECT_NEAR(distance(c, c.manifolds[1].first + k), ring, 1e-5);
      EXPECT_NEAR(c.points[c.manifolds[1].first + k].gap, 0, 1e-9);
    }
  }
}

TEST(FacePatch, WhatHardlyTurnsHasNone) {
  const std::string disc = "{cylinder: {radius: 0.1, length: 0.2}}";
  // Friction stops a rim of g h / 10 within a tenth of the step: 0.157 rad/s here.
  EXPECT_EQ(contacts_of(disc, 0.1, 0.15).manifolds.size(), 1u);
  EXPECT_EQ(contacts_of(disc, 0.1, -0.17).manifolds.size(), 2u);
}

TEST(FacePatch, EdgesAndRoundBodiesHaveNone) {
  EXPECT_EQ(contacts_of("{sphere: {radius: 0.1}}", 0.1, 5).manifolds.size(), 1u);
  EXPECT_EQ(contacts_of("{box: {size: [0.2, 0.2, 0.2]}}", 0.1 * std::sqrt(2), 0.5, ", orientation: {axis: [1, 0, 0], angle: 45}")
                .manifolds.size(),
            1u);
}

// A body that touches others as well has none, nor two that both move.
TEST(FacePatch, InPilesThereAreNone) {
  const auto rings = [](const std::string& more) {
    const Scene scene = scene_from_text(
        "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {cylinder: {radius: 0.1, length: 0.2}}, density: 1000, "
        "position: [0, 0, 0.1], angular_velocity: [0, 0, 9]}\n" +
        more);
    Experiment run(scene);
    CollideSettings settings;
    settings.step = 0.016, settings.margin = 0.001, settings.gravity = Vec3(0, 0, -9.81);
    settings.friction = {0.5}, settings.material_count = 1;
    Contacts contacts;
    collide(run.world(), settings, contacts);
    return std::ranges::count_if(contacts.manifolds, [](const Manifold& m) { return m.is_inner_ring; });
  };
  EXPECT_EQ(rings(""), 1);
  EXPECT_EQ(rings("  - {shape: {sphere: {radius: 0.1}}, density: 1000, position: [5, 0, 0.1]}\n"), 1) << "it is far away";
  EXPECT_EQ(rings("  - {shape: {sphere: {radius: 0.1}}, density: 1000, position: [0, 0.2, 0.1]}\n"), 0) << "it is beside";
  EXPECT_EQ(rings("  - {shape: {cylinder: {radius: 0.1, length: 0.2}}, density: 1000, position: [0, 0, 0.3]}\n"), 0) << "on top";
}

// A thin plate has the corners of its far side in the manifold too, as it may turn over within the step.
TEST(FacePatch, TheFarSideOfAThinPlateIsNotOfTheFace) {
  const Contacts c = contacts_of("{box: {size: [0.2, 0.2, 0.01]}}", 0.005, 20);
  ASSERT_GE(c.manifolds.size(), 2u);  // and that of its core
  EXPECT_EQ(c.manifolds[0].count, 8u);
  ASSERT_TRUE(c.manifolds[1].is_inner_ring);
  EXPECT_EQ(c.manifolds[1].count, 4u);
}

}  // namespace unibody::small_worlds::face_patch_test
