// Known answers for the measure by which this and other programs are judged.
#include "errors.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "chain.hpp"

namespace {

using rivals::Bodies;
using rivals::Frame;
using rivals::Motion;
using rivals::Placed;
using rivals::Quat;
using rivals::Shape;
using rivals::Vec3;

Quat turned(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

Placed placed(Shape shape, const Vec3& size, const Vec3& position, const Quat& q = Quat::Identity()) {
  return {shape, size, position, q.toRotationMatrix()};
}

struct SceneOfBodies {
  Bodies bodies;
  Frame frame;

  void add(Shape shape, const Vec3& size, const Vec3& position, Motion motion = Motion::dynamic,
           const Quat& q = Quat::Identity()) {
    bodies.shape.push_back(shape), bodies.size.push_back(size), bodies.motion.push_back(motion);
    bodies.mass.push_back(2), bodies.inertia.push_back({1, 2, 3});
    frame.position.push_back(position), frame.orientation.push_back(q);
    frame.velocity.push_back(Vec3::Zero()), frame.angular_velocity.push_back(Vec3::Zero());
  }
};

TEST(RivalErrors, BoxesAlignedOverlapByTheSmallestAxis) {
  const auto a = placed(Shape::box, {1, 2, 3}, {0, 0, 0});
  EXPECT_NEAR(depth(a, placed(Shape::box, {1, 1, 1}, {1.9, 0.3, 0.2})), 0.1, 1e-14);
  EXPECT_NEAR(depth(a, placed(Shape::box, {1, 1, 1}, {0.5, 0.3, 3.8})), 0.2, 1e-14);
  EXPECT_EQ(depth(a, placed(Shape::box, {1, 1, 1}, {2.01, 0, 0})), 0);
}

TEST(RivalErrors, BoxOnItsEdgeAndOnItsCorner) {
  const auto floor = placed(Shape::box, {5, 5, 1}, {0, 0, -1});
  const auto edge = turned(std::numbers::pi / 4, Vec3::UnitY());
  EXPECT_NEAR(depth(floor, placed(Shape::box, Vec3::Constant(0.5), {0, 0, std::sqrt(0.5) - 0.02}, edge)), 0.02, 1e-14);
  const auto corner = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3::UnitZ());
  EXPECT_NEAR(depth(placed(Shape::box, Vec3::Constant(0.5), {0, 0, std::sqrt(0.75) - 0.03}, corner), floor), 0.03, 1e-14);
}

TEST(RivalErrors, CrossedEdgesOverlapAlongTheirCommonNormal) {
  // Two bars, turned a quarter about their own length, cross at right angles: the nearest features are edges.
  const double reach = std::sqrt(2.0) * 0.1;
  const auto a = placed(Shape::box, {2, 0.1, 0.1}, {0, 0, 0}, turned(std::numbers::pi / 4, Vec3::UnitX()));
  const auto q = turned(std::numbers::pi / 4, Vec3::UnitY());
  EXPECT_NEAR(depth(a, placed(Shape::box, {0.1, 2, 0.1}, {0.3, 0.4, 2 * reach - 0.01}, q)), 0.01, 1e-14);
  EXPECT_EQ(depth(a, placed(Shape::box, {0.1, 2, 0.1}, {0.3, 0.4, 2 * reach + 1e-9}, q)), 0);
}

TEST(RivalErrors, DepthDoesNotDependOnTheFrameOrOrder) {
  const auto a = placed(Shape::box, {1, 2, 3}, {0.1, 0.2, 0.3}, turned(0.3, {1, 2, 3}));
  const auto b = placed(Shape::box, {2, 1, 1}, {2.2, 0.9, 0.4}, turned(1.1, {-1, 2, 1}));
  const double d = depth(a, b);
  EXPECT_GT(d, 0);
  EXPECT_NEAR(depth(b, a), d, 1e-14);
  const Eigen::Matrix3d turn = turned(0.7, {3, 1, -2}).toRotationMatrix();
  const auto moved = [&](const Placed& p) { return Placed{p.shape, p.size, turn * p.position + Vec3(5, -3, 2), turn * p.axes}; };
  EXPECT_NEAR(depth(moved(a), moved(b)), d, 1e-13);
}

TEST(RivalErrors, SeparatedByTheDepthBoxesJustTouch) {
  // The depth is the length of the shortest way out: no shorter move along any of many directions separates the boxes.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 50; ++n) {
    const auto a = placed(Shape::box, {1, 1.5, 2}, {0, 0, 0}, turned(u(random), {u(random), u(random), 2}));
    auto b = placed(Shape::box, {1, 1, 1}, {u(random), 2 + u(random), u(random)}, turned(u(random), {1, u(random), u(random)}));
    const double d = depth(a, b);
    if (d == 0) continue;
    const Vec3 start = b.position;
    for (int k = 0; k < 20; ++k) {
      b.position = start + 0.999 * d * Vec3(u(random), u(random), u(random)).normalized();
      EXPECT_GT(depth(a, b), 0);
    }
  }
}

TEST(RivalErrors, SpheresBoxesAndPlanes) {
  const auto ball = placed(Shape::sphere, {0.5, 0, 0}, {0, 0, 0});
  EXPECT_NEAR(depth(ball, placed(Shape::sphere, {0.25, 0, 0}, {0, 0.6, 0.3})), 0.75 - std::sqrt(0.45), 1e-14);
  EXPECT_NEAR(depth(ball, placed(Shape::box, {1, 1, 1}, {0, 1.4, 0})), 0.1, 1e-14);
  EXPECT_NEAR(depth(ball, placed(Shape::box, {1, 1, 1}, {1.3, 1.3, 0})), 0.5 - std::sqrt(0.18), 1e-14);
  EXPECT_NEAR(depth(ball, placed(Shape::box, {1, 1, 1}, {0, 0.8, 0})), 0.7, 1e-14);  // centre inside
  const auto plane = placed(Shape::plane, Vec3::Zero(), {7, 7, -0.4});
  EXPECT_NEAR(depth(plane, ball), 0.1, 1e-14);
  const auto wall = placed(Shape::plane, Vec3::Zero(), {-0.3, 7, 7}, turned(std::numbers::pi / 2, Vec3::UnitY()));  // normal +x
  EXPECT_NEAR(depth(ball, wall), 0.2, 1e-14);
  EXPECT_NEAR(depth(wall, placed(Shape::box, {1, 1, 1}, {1, 0, 0}, turned(std::numbers::pi / 4, Vec3::UnitZ()))),
              std::sqrt(2.0) - 1.3, 1e-14);
}

TEST(RivalErrors, FrameSumsOneDepthPerPair) {
  SceneOfBodies s;
  s.add(Shape::plane, Vec3::Zero(), Vec3::Zero(), Motion::fixed);
  s.add(Shape::box, {1, 1, 1}, {0, 0, 0.97});                 // 3 cm in the ground
  s.add(Shape::box, {1, 1, 1}, {0.2, 0, 2.93});               // 4 cm in the box below
  s.add(Shape::sphere, {0.5, 0, 0}, {5, 0, 1});               // free
  s.add(Shape::box, {20, 20, 1}, {0, 0, -1}, Motion::fixed);  // a fixed floor at the same height: the same 3 cm again
  s.frame.velocity[3] = {3, 0, 4};
  s.frame.angular_velocity[3] = {0, 0, 2};
  const auto e = rivals::measure(s.bodies, s.frame);
  EXPECT_EQ(e.count, 3);
  EXPECT_NEAR(e.l2, std::sqrt(0.0009 + 0.0016 + 0.0009), 1e-12);
  EXPECT_NEAR(e.rms, e.l2 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(e.max, 0.04, 1e-12);
  EXPECT_NEAR(e.kinetic, (0.5 * 2 * 25 + 0.5 * 3 * 4) / 3, 1e-12);
  EXPECT_NEAR(e.height, (0.97 + 2.93 + 1) / 3, 1e-12);
  EXPECT_EQ(e.lost, 0);
}

TEST(RivalErrors, OneBodyMovedChangesTheErrorByItsDepth) {
  SceneOfBodies s;
  for (int i = 0; i < 1000; ++i) s.add(Shape::box, Vec3::Constant(0.5), Vec3(i % 10, i / 10 % 10, i / 100));  // just touching
  EXPECT_LT(rivals::measure(s.bodies, s.frame).l2, 1e-12);
  s.frame.position[555].x() += 0.01;
  const auto e = rivals::measure(s.bodies, s.frame);
  EXPECT_NEAR(e.l2, 0.01, 1e-12);
  EXPECT_NEAR(e.max, 0.01, 1e-12);
  s.frame.position[555] = {0, 0, std::nan("")};
  EXPECT_EQ(rivals::measure(s.bodies, s.frame).lost, 1);
}

// The same of a file, by another hand than the writer's and the reader's: of 103 frames the settled ones are the last 100.
TEST(RivalErrors, OneBodyMovedInAFileChangesTheErrorByItsDepth) {
  SceneOfBodies s;
  for (int i = 0; i < 125; ++i) s.add(Shape::box, Vec3::Constant(0.5), Vec3(i % 5, i / 5 % 5, i / 25));  // just touching
  const std::string path = testing::TempDir() + "one_body_moved_" + std::to_string(getpid()) + ".h5";
  const auto errors_of_file = [&] {
    const rivals::FrameReader reader(path);
    std::vector<rivals::FrameErrors> frames;
    rivals::Frame frame;
    for (const long number : reader.frames()) reader.read(number, frame), frames.push_back(measure(reader.bodies(), frame));
    return rivals::summarise(frames);
  };
  const auto move = [&](int frame, double by) {
    char name[40];
    std::snprintf(name, sizeof name, "/frames/%06d/position", frame);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), data = H5Dopen2(file, name, H5P_DEFAULT);
    std::vector<double> all(3 * 125);
    EXPECT_GE(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
    all[3 * 62] += by;  // the body in the middle
    EXPECT_GE(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
    H5Dclose(data), H5Fclose(file);
  };
  {
    rivals::FrameWriter writer(path, s.bodies, false);
    for (long k = 0; k < 103; ++k) writer.write(k, s.frame);
  }
  EXPECT_LT(errors_of_file().settled.l2 + errors_of_file().peak_l2, 1e-12);
  move(1, 0.03);
  EXPECT_LT(errors_of_file().settled.l2, 1e-12);
  EXPECT_NEAR(errors_of_file().peak_l2, 0.03, 1e-12);
  for (int k = 3; k < 103; ++k) move(k, 0.01);
  const rivals::RunErrors e = errors_of_file();
  EXPECT_EQ(e.frames, 103);
  EXPECT_NEAR(e.settled.l2, 0.01, 1e-12);
  EXPECT_NEAR(e.settled.max, 0.01, 1e-12);
  EXPECT_NEAR(e.peak_max, 0.03, 1e-12);
  std::filesystem::remove(path);
}

TEST(RivalErrors, GridFindsWhatAllPairsFind) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1, 1);
  SceneOfBodies s;
  for (int i = 0; i < 400; ++i) {
    const Vec3 position(u(random), u(random), u(random));
    const auto q = turned(u(random), {u(random), 1, u(random)});
    const double size = i % 97 == 0 ? 0.8 : 0.08 + 0.05 * u(random);  // a few much larger ones
    if (i % 3 == 0)
      s.add(Shape::sphere, {size, 0, 0}, position, Motion::dynamic, q);
    else
      s.add(Shape::box, {size, 0.1, 0.05}, position, i % 5 == 0 ? Motion::fixed : Motion::dynamic, q);
  }
  s.frame.position[7] = {1e9, 0, 0};  // flew away
  double squares = 0;
  long count = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!s.bodies.is_dynamic(i) && !s.bodies.is_dynamic(j)) continue;
      const double d = depth(place(s.bodies, s.frame, i), place(s.bodies, s.frame, j));
      squares += d * d;
      if (d > 0) ++count;
    }
  }
  const auto e = rivals::measure(s.bodies, s.frame);
  EXPECT_GT(count, 300);
  EXPECT_EQ(e.count, count);
  EXPECT_NEAR(e.l2, std::sqrt(squares), 1e-12);
}

TEST(RivalErrors, SettledIsTheMedianOfTheLastHundredFrames) {
  std::vector<rivals::FrameErrors> frames(250);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].rms = frames[i].l2 = frames[i].max = static_cast<double>(i);
  frames[3].l2 = frames[3].max = 1000;
  const auto e = rivals::summarise(frames);
  EXPECT_DOUBLE_EQ(e.settled.rms, 199.5);
  EXPECT_DOUBLE_EQ(e.peak_l2, 1000);
  EXPECT_DOUBLE_EQ(e.peak_max, 1000);
  EXPECT_EQ(e.frames, 250);
}

TEST(RivalErrors, FilesReadBackAsWritten) {
  SceneOfBodies s;
  s.add(Shape::plane, Vec3::Zero(), {0, 0, 0.25}, Motion::fixed);
  s.add(Shape::box, {1, 2, 3}, {0.1, 0.2, 0.3}, Motion::dynamic, turned(0.4, {1, 2, 3}));
  s.frame.velocity[1] = {1, 2, 3};
  const auto path = (std::filesystem::temp_directory_path() / "unibody_rivals_test.h5").string();
  {
    rivals::FrameWriter writer(path, s.bodies, false);
    for (const long n : {0L, 5L, 1000000L}) writer.write(n, s.frame);
  }
  const rivals::FrameReader reader(path);
  EXPECT_EQ(reader.frames(), (std::vector<long>{0, 5, 1000000}));
  const auto bodies = reader.bodies();
  EXPECT_EQ(bodies.shape, s.bodies.shape);
  EXPECT_EQ(bodies.motion, s.bodies.motion);
  EXPECT_EQ(bodies.size, s.bodies.size);
  Frame frame;
  reader.read(1000000, frame);
  EXPECT_EQ(frame.position, s.frame.position);
  EXPECT_EQ(frame.velocity, s.frame.velocity);
  EXPECT_LT(frame.orientation[1].angularDistance(s.frame.orientation[1]), 1e-14);
  std::filesystem::remove(path);
  EXPECT_THROW(rivals::FrameReader("/nonexistent.h5"), std::runtime_error);
}

TEST(RivalErrors, ChainIsOpenWhereABodyWasMoved) {
  // Three links of 0.2 m along a line that is turned, a ball of 0.5 m radius behind them, and a floor that is no part of it.
  SceneOfBodies scene;
  const Quat q = turned(0.7, {1, 2, 3});
  const Vec3 along = q * Vec3::UnitX();
  scene.add(Shape::plane, {0, 0, 0}, {0, 0, -9}, Motion::fixed);
  for (const double x : {0.1, 0.3, 0.5}) scene.add(Shape::box, {0.09, 0.01, 0.01}, x * along, Motion::dynamic, q);
  scene.add(Shape::sphere, {0.5, 0.5, 0.5}, 1.1 * along);
  const auto anchors = rivals::chain_anchors(scene.bodies, scene.frame);
  ASSERT_EQ(anchors.size(), 4U);
  EXPECT_EQ(anchors[0].a, -1);
  EXPECT_EQ(anchors[3].b, 4);
  EXPECT_LT((anchors[3].in_b + 0.5 * along).norm(), 1e-15);  // where the last link ends
  EXPECT_LT(chain_drift(anchors, scene.frame).max, 1e-15);
  scene.frame.position[4] += Vec3(0, 0, 0.03);
  EXPECT_NEAR(chain_drift(anchors, scene.frame).max, 0.03, 1e-15);
  EXPECT_NEAR(chain_drift(anchors, scene.frame).rms, 0.015, 1e-15);
  scene.frame.position[2] += Vec3(0.04, 0, 0);  // opens the joints at both of its ends
  EXPECT_NEAR(chain_drift(anchors, scene.frame).rms, std::sqrt((2 * 0.0016 + 0.0009) / 4), 1e-15);
}

}  // namespace
