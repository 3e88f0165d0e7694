// Generators: numbering and numbers of the reference scenes, places in closed form, no overlap where none is promised.
#include "scene/generators.hpp"

#include <chrono>
#include <cmath>
#include <set>

#include "scene/random.hpp"
#include "scene/scene_text.hpp"

namespace unibody::generators_test {
namespace {

TEST(Lcg, FirstNumbersAndTheTwelveThousandth) {
  Lcg random;
  EXPECT_EQ(random.next(), -0.15358165825457348);
  EXPECT_EQ(random.next(), 0.01881488576744128);
  EXPECT_EQ(random.state, 9396908728118811419u);
  Lcg far;
  far.jump(12000);
  EXPECT_EQ(far.state, 1099964272815243745u);
}

TEST(Lcg, JumpIsThatManySteps) {
  Lcg sequential;
  for (std::uint64_t n = 0; n < 3000; ++n) {
    Lcg jumped;
    jumped.jump(n);
    ASSERT_EQ(jumped.state, sequential.state) << n;
    sequential.next();
  }
}

// The reference scenes' own loop, y up, turned into ours: (x, y, z) -> (x, -z, y).
TEST(Lattice, IsTheReferenceSceneToTheBit) {
  const Scene scene = read_scene(UNIBODY_SOURCE_DIR "/scenes/boxes_2000.yaml");
  ASSERT_EQ(scene.body_count(), 2001);
  std::uint64_t s = 1;
  const auto draw = [&s] {
    s = s * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(s >> 11) * std::pow(2.0, -53) * 2 - 1;
  };
  for (int i = 0; i < 2000; ++i) {
    double u[6];
    for (double& x : u) x = draw();
    const int ix = i % 10, iz = i / 10 % 10, iy = i / 100;
    const double x = (ix - 4.5) * 0.16 + 0.010 * u[0], y = 0.2 + iy * 0.19 + 0.010 * u[1], z = (iz - 4.5) * 0.16 + 0.010 * u[2];
    const Vec3 rotation = 0.05 * Vec3(u[3], -u[5], u[4]);
    const Body body = scene.body(1 + i);
    ASSERT_EQ(body.state.position, Vec3(x, -z, y)) << i;
    const Quat expected(Eigen::AngleAxisd(rotation.norm(), rotation.normalized()));
    ASSERT_LT((body.state.orientation.coeffs() - expected.coeffs()).norm(), 1e-15) << i;
    ASSERT_EQ(body.id, 1 + i);
    ASSERT_EQ(body.properties.mass, 1);
    ASSERT_EQ(body.properties.shape.size, Vec3(0.06, 0.06, 0.075));
  }
}

TEST(Lattice, WithoutJitterIsClosedForm) {
  const Scene scene = scene_from(
      "bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, velocity: [0, 0, -2], position: [10, 20, 30],\n"
      "     lattice: {count: 12, columns: [2, 3], spacing: [1, 2, 3], height: 0.5}}\n");
  EXPECT_EQ(scene.body(0).state.position, Vec3(9.5, 22, 30.5));
  EXPECT_EQ(scene.body(1).state.position, Vec3(10.5, 22, 30.5));
  EXPECT_EQ(scene.body(2).state.position, Vec3(9.5, 20, 30.5));
  EXPECT_EQ(scene.body(11).state.position, Vec3(10.5, 18, 33.5));
  EXPECT_EQ(scene.body(5).state.velocity, Vec3(0, 0, -2));
  EXPECT_EQ(scene.body(5).state.orientation.coeffs(), Quat::Identity().coeffs());
}

TEST(Lattice, OrientationTurnsTheWholeLattice) {
  const Scene scene = scene_from(
      "bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [1, 0, 0], orientation: {axis: [0, 0, 1], angle: 90},\n"
      "     lattice: {count: 2, columns: [2, 1], spacing: [4, 1, 1]}}\n");
  EXPECT_NEAR((scene.body(0).state.position - Vec3(1, -2, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((scene.body(1).state.position - Vec3(1, 2, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((scene.body(1).state.orientation * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-15);
}

TEST(Lattice, StaysInThePlaneOfAPlanarScene) {
  const Scene scene = scene_from(
      "planar: true\nbodies:\n  - {shape: {disc: {radius: 0.1}}, mass: 1,\n"
      "     lattice: {count: 20, columns: [4, 1], spacing: [1, 1, 1], jitter: 0.2, rotation_jitter: 1}}\n");
  for (Id k = 0; k < 20; ++k) {
    const BodyState state = scene.body(k).state;
    EXPECT_EQ(state.position.y(), 0);
    EXPECT_EQ(state.orientation.x(), 0);
    EXPECT_EQ(state.orientation.z(), 0);
    EXPECT_NE(state.orientation.y(), 0);
  }
}

TEST(Lattice, IsNotExpandedAtReading) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = scene_from(
      "bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1,\n"
      "     lattice: {count: 10000000, columns: [1000, 1000], spacing: [1, 1, 1], jitter: 0.1}}\n");
  const Body last = scene.body(scene.body_count() - 1);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 1.0);
  EXPECT_EQ(last.id, 9999999);
  EXPECT_NEAR(last.state.position.z(), 9, 0.1);
}

const std::string pile_text =
    "bodies:\n  - name: rubble\n    density: 1000\n    position: [0, 0, 2]\n    pile:\n      count: 400\n      columns: [5, 4]\n"
    "      gap: 0.01\n      mix:\n        - {shape: {sphere: {radius: 0.1}}, scale: [0.1, 2], share: 3}\n"
    "        - {shape: {box: {size: [0.1, 0.2, 0.3]}}}\n";

TEST(Pile, BoundingSpheresKeepTheGap) {
  const Scene scene = scene_from(pile_text);
  std::vector<Body> bodies;
  for (Id id = 0; id < 400; ++id) bodies.push_back(scene.body(id));
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    const double r = bounding_radius(bodies[a].properties.shape);
    EXPECT_GE(bodies[a].state.position.z() - r, 2 + 0.005 - 1e-12);
    for (std::size_t b = 0; b < a; ++b) {
      const double distance = (bodies[a].state.position - bodies[b].state.position).norm();
      ASSERT_GE(distance - r - bounding_radius(bodies[b].properties.shape), 0.01 - 1e-12) << a << " " << b;
    }
  }
}

TEST(Pile, MixesInTheGivenShares) {
  const Scene scene = scene_from(pile_text);
  int spheres = 0;
  double smallest = 1, largest = 0;
  for (Id id = 0; id < 400; ++id) {
    const Body body = scene.body(id);
    EXPECT_NEAR(body.properties.mass, 1000 * volume(body.properties.shape), 1e-12);
    EXPECT_NEAR(body.state.orientation.norm(), 1, 1e-15);
    if (body.properties.shape.kind != ShapeKind::sphere) {
      EXPECT_EQ(body.properties.shape.size, Vec3(0.05, 0.1, 0.15));
      continue;
    }
    ++spheres;
    smallest = std::min(smallest, body.properties.shape.size.x());
    largest = std::max(largest, body.properties.shape.size.x());
  }
  EXPECT_NEAR(spheres, 300, 45);  // 5 standard deviations
  EXPECT_GE(smallest, 0.01 - 1e-15);
  EXPECT_LT(smallest, 0.015);
  EXPECT_LE(largest, 0.2 + 1e-15);
  EXPECT_GT(largest, 0.17);
}

TEST(Pile, IsAFunctionOfTheNumberAndTheSeed) {
  const Scene scene = scene_from(pile_text), again = scene_from(pile_text),
              other = scene_from(pile_text, {{"bodies[0].pile.seed", "2"}});
  const Body last = scene.body(399), first = scene.body(0);
  EXPECT_EQ(again.body(0).state.position, first.state.position);
  EXPECT_EQ(again.body(399).state.orientation.coeffs(), last.state.orientation.coeffs());
  EXPECT_NE(other.body(0).state.orientation.coeffs(), first.state.orientation.coeffs());
}

TEST(Wall, CoursesAreFullAndJointsAreOffset) {
  const Scene scene = scene_from(
      "bodies:\n  - {shape: {box: {size: [0.4, 0.2, 0.1]}}, mass: 8, wall: {bricks: 3, courses: 3, gap: 0.02, course_gap: "
      "0.001}}\n");
  ASSERT_EQ(scene.body_count(), 3 + 4 + 3);
  const double length = 3 * 0.4 + 2 * 0.02;
  for (const auto& [first, count, course] : {std::tuple<Id, Id, int>{0, 3, 0}, {3, 4, 1}, {7, 3, 2}}) {
    double at = -length / 2;
    for (Id id = first; id < first + count; ++id) {
      const Body brick = scene.body(id);
      EXPECT_NEAR(brick.state.position.x() - brick.properties.shape.size.x(), at, 1e-14) << id;
      EXPECT_NEAR(brick.state.position.z(), 0.05 + course * 0.101, 1e-15);
      EXPECT_EQ(brick.state.position.y(), 0);
      EXPECT_NEAR(brick.properties.mass, 8 * 2 * brick.properties.shape.size.x() / 0.4, 1e-14);
      at = brick.state.position.x() + brick.properties.shape.size.x() + 0.02;
    }
    EXPECT_NEAR(at - 0.02, length / 2, 1e-14);
  }
  EXPECT_NEAR(scene.body(3).properties.shape.size.x(), 0.095, 1e-15);
  EXPECT_EQ(scene.body(4).properties.shape.size.x(), 0.2);
}

TEST(Stack, StandsOnItsPositionWithTheGap) {
  const Scene scene = scene_from(
      "bodies:\n  - {shape: {box: {size: [1, 1, 0.5]}}, mass: 1, position: [0, 0, 3], stack: {count: 3, gap: 0.25, offsets: [0, "
      "0.1, -0.3]}}\n"
      "  - {shape: {sphere: {radius: 0.5}}, mass: 1, stack: {count: 2}}\n");
  EXPECT_EQ(scene.body(0).state.position, Vec3(0, 0, 3.25));
  EXPECT_EQ(scene.body(1).state.position, Vec3(0.1, 0, 4));
  EXPECT_EQ(scene.body(2).state.position, Vec3(-0.3, 0, 4.75));
  EXPECT_EQ(scene.body(4).state.position, Vec3(0, 0, 1.5));
}

TEST(Points, AreTakenAsTheyStand) {
  const Scene scene =
      scene_from("bodies:\n  - {shape: {sphere: {radius: 1}}, mass: 1, position: [0, 0, 1], points: [[1, 2, 3], [4, 5, 6]]}\n");
  ASSERT_EQ(scene.body_count(), 2);
  EXPECT_EQ(scene.body(0).state.position, Vec3(1, 2, 4));
  EXPECT_EQ(scene.body(1).state.position, Vec3(4, 5, 7));
}

// Height of a point above the plane.
double height_above(const Body& plane, const Vec3& point) {
  return (plane.state.orientation.conjugate() * (point - plane.state.position)).z();
}

TEST(Container, WallsLookInwards) {
  const Scene scene = scene_from(
      "bodies:\n  - {container: {size: [2, 4]}, position: [10, 0, 5]}\n  - {container: {size: [2, 4], floor: false}}\n");
  ASSERT_EQ(scene.body_count(), 5 + 4);
  EXPECT_TRUE(scene.groups[0].is_static);
  const Vec3 point(10.25, 0.5, 5.125);
  const double heights[5] = {0.125, 1.25, 0.75, 2.5, 1.5};
  for (Id id = 0; id < 5; ++id) EXPECT_NEAR(height_above(scene.body(id), point), heights[id], 1e-15) << id;
  for (Id id = 5; id < 9; ++id) EXPECT_GT(height_above(scene.body(id), Vec3(0.9, 1.9, -100)), 0);
}

TEST(Container, OfAPlanarSceneHasTwoWalls) {
  const Scene scene = scene_from("planar: true\nbodies: [{container: {size: [2]}}]\n");
  ASSERT_EQ(scene.body_count(), 3);
  for (Id id = 0; id < 3; ++id)
    EXPECT_NEAR(height_above(scene.body(id), {0.5, 0, 0.25}), (std::array{0.25, 1.5, 0.5})[static_cast<std::size_t>(id)], 1e-15);
}

bool inside(const Body& box, const Vec3& point) {
  const Vec3 local = box.state.orientation.conjugate() * (point - box.state.position);
  return (local.cwiseAbs() - box.properties.shape.size).maxCoeff() < 0;
}

int boards_around(const Scene& scene, const Vec3& point) {
  int count = 0;
  for (Id id = 0; id < scene.body_count(); ++id) count += inside(scene.body(id), point) ? 1 : 0;
  return count;
}

TEST(Hopper, IsOpenInsideAndClosedAroundIt) {
  const Scene scene = scene_from("bodies: [{hopper: {opening: [0.4, 0.2], rim: [2, 1], height: 0.8, thickness: 0.1}}]\n");
  ASSERT_EQ(scene.body_count(), 4);
  for (double t = 0.02; t < 1; t += 0.07) {  // from the opening to the rim
    const double x = 0.2 + 0.8 * t, y = 0.1 + 0.4 * t, z = 0.8 * t;
    for (double f = -1; f <= 1; f += 0.125) {
      for (const double side : {-1.0, 1.0}) {
        EXPECT_EQ(boards_around(scene, {side * (x - 1e-6), f * (y - 1e-6), z}), 0);
        EXPECT_EQ(boards_around(scene, {f * (x - 1e-6), side * (y - 1e-6), z}), 0);
        EXPECT_GE(boards_around(scene, {side * (x + 0.02), f * (y + 0.02), z}), 1) << t << " " << f;
        EXPECT_GE(boards_around(scene, {f * (x + 0.02), side * (y + 0.02), z}), 1) << t << " " << f;
      }
    }
  }
  for (double z = -0.5; z <= 0; z += 0.01)  // nothing stands in the way below the opening
    for (const double side : {-1.0, 1.0}) EXPECT_EQ(boards_around(scene, {side * 0.199, side * 0.099, z}), 0);
}

TEST(Hopper, OfAPlanarSceneIsTurnedAboutYAlone) {
  const Scene scene = scene_from("planar: true\nbodies: [{hopper: {opening: [0.4], rim: [2], height: 0.8, thickness: 0.1}}]\n");
  ASSERT_EQ(scene.body_count(), 2);
  for (Id id = 0; id < 2; ++id) {
    EXPECT_NEAR(scene.body(id).state.orientation.x(), 0, 1e-16);
    EXPECT_NEAR(scene.body(id).state.orientation.z(), 0, 1e-16);
    EXPECT_EQ(scene.body(id).state.position.y(), 0);
  }
  EXPECT_EQ(boards_around(scene, {0.19, 0, 0}), 0);
  EXPECT_EQ(boards_around(scene, {0.62, 0, 0.4}), 1);
}

}  // namespace
}  // namespace unibody::generators_test
