// Bodies that come in and go out: how many, of which sizes, where, and what is reported of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "changes/changing.hpp"
#include "core/errors.hpp"
#include "scene/scene_text.hpp"

namespace unibody::small_worlds::inlets_test {

namespace {

std::string inlet(const std::string& keys, const std::string& more = "") {
  return "time: {frame: 0.01, frames: 100}\nbodies:\n  - name: grains\n    density: 1000\n    inlet: {" + keys + "}\n" + more;
}
const std::string balls = "mix: [{shape: {sphere: {radius: 0.01}}}]";
const std::string room = "box: {low: [-1, -1, 0], high: [1, 1, 1]}";
constexpr double ball_mass = 1000 * 4.0 / 3 * M_PI * 1e-6;

TEST(Inlets, AsManyAsAreDueComeIn) {
  Changing run(inlet("count: 1000, rate: 250, from: 0.1, until: 0.5, " + room + ", " + balls));
  for (int frame = 1; frame <= 80; ++frame) {
    run.frames(1);
    const double start = 0.01 * (frame - 1), due = 250 * (std::min(start, 0.5) - 0.1);
    EXPECT_EQ(run.past().inlets[0].placed, std::max<Id>(0, static_cast<Id>(std::floor(due + 1e-6)))) << frame;
    EXPECT_EQ(static_cast<Id>(run.world().homes), run.past().inlets[0].placed);
  }
  EXPECT_TRUE(run.past().inlets[0].waiting.empty());
}

TEST(Inlets, TheRateMayChange) {
  Changing run(inlet("count: 1000, rate: [[0, 0], [0.5, 400]], " + room + ", " + balls));
  run.frames(51);  // the integral of 800 t to 0.5
  EXPECT_EQ(run.past().inlets[0].placed, 100);
}

TEST(Inlets, TheMassIsThatOfTheRate) {
  Changing run(
      inlet("count: 10000, mass_rate: 2, " + room + ", mix: [{shape: {sphere: {radius: 0.01}}, scale: {uniform: [0.5, 2]}}]"));
  const double largest = 8 * ball_mass;
  for (int frame = 1; frame <= 50; ++frame) {
    run.frames(1);
    EXPECT_NEAR(run.past().inlets[0].placed_mass, 2 * 0.01 * (frame - 1), largest / 2 + 1e-9);
  }
  double mass = 0;
  for (std::size_t i = 0; i < run.world().homes; ++i) mass += run.world().properties[i].mass;
  EXPECT_NEAR(mass, run.past().inlets[0].placed_mass, 1e-9);
}

TEST(Inlets, NoneComeInBeyondTheCount) {
  Changing run(inlet("count: 7, rate: 1000, " + room + ", " + balls));
  run.frames(40);
  EXPECT_EQ(run.past().inlets[0].placed, 7);
  EXPECT_TRUE(run.past().inlets[0].waiting.empty());
}

// In frame 2 half the volume of the box is due: no two overlap, nor is one in the wall, and the rest waits.
TEST(Inlets, NothingOverlaps) {
  Changing run(R"(
time: {frame: 0.01, frames: 100}
gravity: [0, 0, 0]
bodies:
  - {shape: {box: {size: [0.2, 0.02, 0.2]}}, motion: fixed, position: [0, 0, 0.1]}
  - {shape: {sphere: {radius: 0.03}}, mass: 1, position: [0.05, 0.05, 0.05]}
  - name: grains
    density: 1000
    inlet:
      count: 5000
      rate: 100000
      box: {low: [-0.1, -0.1, 0], high: [0.1, 0.1, 0.2]}
      mix: [{shape: {sphere: {radius: 0.01}}, scale: {uniform: [0.5, 1.5]}}]
)");
  run.frames(1);
  run.change();
  const World& world = run.world();
  const auto placed = run.past().inlets[0].placed;
  EXPECT_GT(placed, 300);
  EXPECT_EQ(placed + std::ssize(run.past().inlets[0].waiting), 1000);
  for (std::size_t i = 0; i < world.homes; ++i) {
    const double radius = world.properties[i].shape.size.x();
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_GE((world.position[i] - world.position[j]).norm(), radius + world.properties[j].shape.size.x());
    if (i > 0) {
      EXPECT_GE(std::abs(world.position[i].y()), 0.01 + radius);
    }
  }
}

// Each that waits comes in when there is room, with the size that it had when it became due.
TEST(Inlets, WhatFoundNoRoomComesInLater) {
  Changing run(
      inlet("count: 40, rate: 4000, seed: 3, box: {low: [-0.01, -0.01, 0], high: [0.01, 0.01, 0.02]}, "
            "mix: [{shape: {sphere: {radius: 0.01}}, scale: {uniform: [0.5, 1.5]}}]"));
  run.frames(3);
  EXPECT_GT(run.past().inlets[0].waiting.size(), 30U);
  run.frames(300);
  EXPECT_EQ(run.past().inlets[0].placed, 40);
  EXPECT_TRUE(run.past().inlets[0].waiting.empty());
  ASSERT_EQ(run.world().homes, 40U);
  for (Id k = 0; k < 40; ++k) EXPECT_EQ(run.world().properties[run.slot(k)].shape.size, run.scene->body(k).properties.shape.size);
}

TEST(Inlets, ADiscIsTurnedWithItsEntry) {
  Changing run(R"(
time: {frame: 0.01, frames: 100}
gravity: [0, 0, 0]
bodies:
  - name: grains
    density: 1000
    position: [1, 2, 3]
    orientation: {axis: [0, 1, 0], angle: 90}
    inlet: {count: 200, rate: 20000, disc: {radius: 1}, mix: [{shape: {sphere: {radius: 0.001}}}]}
)");
  run.frames(2);
  ASSERT_EQ(run.world().homes, 200U);
  double inner = 0;
  for (const Vec3& at : run.world().position) {
    const Vec3 from = at - Vec3(1, 2, 3);
    EXPECT_NEAR(from.x(), 0, 1e-12);
    EXPECT_LE(from.norm(), 1);
    inner += from.norm() < std::sqrt(0.5);
  }
  EXPECT_NEAR(inner, 100, 4 * std::sqrt(50.0)) << "half of the disc's area is within this radius";
}

// The surface has two rectangles at right angles to each other, of two triangles each: a level one of 2 m x 1 m at z = 1, and an
// upright one of 1 m x 1 m at x = 0.
class InletsOnASurface : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(file_) << "v 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\nv 0 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\nf 1 4 6\nf 1 6 5\n";
  }
  void TearDown() override { std::filesystem::remove(file_); }

  // Places in the file's own frame, of bodies whose entry is turned and moved.
  std::vector<Vec3> places(const std::string& keys) {
    Changing run("gravity: [0, 0, 0]\n" + inlet("count: 6000, rate: 600000, mesh: {file: " + file_ + keys +
                                                    "}, mix: [{shape: {sphere: {radius: 1.0e-5}}}]",
                                                "    position: [10, 0, 0]\n    orientation: {axis: [1, 0, 0], angle: 90}\n"));
    run.frames(2);
    std::vector<Vec3> places;
    for (const Vec3& at : run.world().position) places.emplace_back(at.x() - 10, at.z(), -at.y());
    return places;
  }

  const std::string file_ = (std::filesystem::temp_directory_path() / ("surface" + std::to_string(::getpid()) + ".obj")).string();
};

// The surface is divided into 36 cells of equal area. Where bodies come in evenly, chi-squared of the numbers in these cells is
// above 68 in one of 1000 samples.
TEST_F(InletsOnASurface, EvenlyByItsArea) {
  const std::vector<Vec3> all = places("");
  ASSERT_GT(all.size(), 5900U);
  std::array<int, 36> cells{};  // 24 on top and 12 at the side
  for (const Vec3& at : all) {
    const auto cell = [](double x, int n) { return std::clamp(static_cast<int>(x * n), 0, n - 1); };
    const bool on_top = std::abs(at.z() - 1) < 1e-9;
    ASSERT_TRUE(on_top || std::abs(at.x()) < 1e-9);
    ++cells[static_cast<std::size_t>(on_top ? 4 * cell(at.x() / 2, 6) + cell(at.y(), 4)
                                            : 24 + 4 * cell(at.z(), 3) + cell(at.y(), 4))];
  }
  double sum = 0;
  const double mean = static_cast<double>(all.size()) / 36;
  for (const int count : cells) sum += (count - mean) * (count - mean) / mean;
  EXPECT_LT(sum, 68);
}

TEST_F(InletsOnASurface, OnWhatFacesOneWay) {
  for (const Vec3& at : places(", facing: [0, 0, 1], offset: 0.1")) EXPECT_NEAR(at.z(), 1.1, 1e-9);
  for (const Vec3& at : places(", facing: [-0.8, 0, 0.6], within: 40, offset: -0.1")) EXPECT_NEAR(at.x(), 0.1, 1e-9);
}

TEST_F(InletsOnASurface, NothingFacesThatWay) {
  try {
    places(", facing: [0, 1, 0]");
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(
        std::string(error.what()).find("inlet.mesh.facing': found [0, 1, 0], expected the direction of a triangle's normal"),
        std::string::npos)
        << error.what();
  }
}

struct Law {
  const char* name;
  std::string scale;
  std::function<double(double)> below;  // the share of bodies below a factor
};
void PrintTo(const Law& law, std::ostream* out) { *out << law.name; }

std::string name_of_law(const testing::TestParamInfo<Law>& law) { return law.param.name; }

double normal_below(double x, double mean, double deviation, double low, double high) {
  const auto phi = [&](double f) { return 0.5 * std::erfc((mean - f) / (deviation * std::sqrt(2.0))); };
  return (phi(x) - phi(low)) / (phi(high) - phi(low));
}

class Sizes : public testing::TestWithParam<Law> {};
INSTANTIATE_TEST_SUITE_P(
    Laws, Sizes,
    testing::Values(Law{"logarithmic", "[0.5, 2]", [](double f) { return std::log(f / 0.5) / std::log(4.0); }},
                    Law{"uniform", "{uniform: [0.5, 2]}", [](double f) { return (f - 0.5) / 1.5; }},
                    // Equal masses in equal ranges: the number's density falls with the cube of the size.
                    Law{"by_mass", "{uniform: [0.5, 2], by: mass}",
                        [](double f) { return (1 / 0.25 - 1 / (f * f)) / (1 / 0.25 - 1 / 4.0); }},
                    Law{"normal", "{normal: {mean: 1, deviation: 0.2, smallest: 0.7, largest: 1.5}}",
                        [](double f) { return normal_below(f, 1, 0.2, 0.7, 1.5); }},
                    Law{"log_normal", "{log_normal: {median: 1, deviation: 0.3, smallest: 0.5, largest: 2}}",
                        [](double f) { return normal_below(std::log(f), 0, 0.3, std::log(0.5), std::log(2.0)); }},
                    Law{"table", "{table: [[0.5, 1], [1, 2], [2, 1]]}",
                        [](double f) { return f <= 0.5 ? 0
                                              : f <= 1 ? 0.25
                                              : f <= 2 ? 0.75
                                                       : 1; }},
                    // By mass a body of half the size stands for an eighth.
                    Law{"table_by_mass", "{table: [[0.5, 1], [1, 1]], by: mass}",
                        [](double f) { return f <= 0.5 ? 0
                                              : f <= 1 ? 8.0 / 9
                                                       : 1; }}),
    name_of_law);

// Kolmogorov: the largest distance of the two distributions is below 1.95 / sqrt(n) in 999 of 1000 samples.
TEST_P(Sizes, AreSpreadAsTheLawSays) {
  const Scene scene = scene_from(
      inlet("count: 4000, rate: 1, " + room + ", mix: [{shape: {sphere: {radius: 0.01}}, scale: " + GetParam().scale + "}]"));
  std::vector<double> factors;
  for (Id k = 0; k < 4000; ++k) factors.push_back(scene.body(k).properties.shape.size.x() / 0.01);
  std::ranges::sort(factors);
  double farthest = 0;
  for (const double f : {0.45, 0.55, 0.6, 0.7, 0.8, 0.9, 0.99, 1.01, 1.1, 1.2, 1.4, 1.6, 1.8, 1.99, 2.1}) {
    const auto below = static_cast<double>(std::ranges::lower_bound(factors, f) - factors.begin()) / 4000;
    farthest = std::max(farthest, std::abs(below - std::clamp(GetParam().below(f), 0.0, 1.0)));
  }
  EXPECT_LT(farthest, 1.95 / std::sqrt(4000.0));
}

TEST(Outlets, TakeOutWhatIsInThem) {
  Changing run(R"(
time: {frame: 0.01, frames: 100}
materials: {a: {friction: 0.5}, b: {friction: 0.5}}
gravity: [0, 0, 0]
bodies:
  - {name: fast, points: [[0, 0, 0], [0, 1, 0]], shape: {sphere: {radius: 0.1}}, mass: 2, velocity: [1, 0, 0], material: a}
  - {name: slow, points: [[0, 2, 0], [0, 3, 0]], shape: {sphere: {radius: 0.1}}, mass: 3, velocity: [0.5, 0, 0], material: b}
  - {name: jointed, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.6, 5, 0], material: a}
joints: [{type: ball, bodies: [jointed, world], anchor: [0.6, 5, 0]}]
outlets:
  - {name: left, of: fast, box: {low: [0.5, -9, -9], high: [9, 9, 9]}}
  - {name: both, box: {low: [0.4, 2.5, -9], high: [9, 9, 9]}}
  - {name: none, material: a, box: {low: [-9, -9, -9], high: [-5, 9, 9]}}
)");
  run.frames(50);
  for (Id id = 0; id < 5; ++id) EXPECT_TRUE(run.is_there(id)) << id;
  run.frames(2);  // x = 0.5 after 50 frames, for what rounding makes of it
  EXPECT_FALSE(run.is_there(0));
  EXPECT_FALSE(run.is_there(1));
  EXPECT_EQ(run.past().outlets[0].removed, 2);
  EXPECT_EQ(run.past().outlets[0].removed_mass, 4);
  run.frames(30);
  EXPECT_TRUE(run.is_there(2));
  EXPECT_FALSE(run.is_there(3));
  EXPECT_TRUE(run.is_there(4)) << "bodies with joints stay";
  EXPECT_EQ(run.past().outlets[1].removed_mass, 3);
  EXPECT_EQ(run.past().outlets[2].removed, 0);
}

}  // namespace

}  // namespace unibody::small_worlds::inlets_test
