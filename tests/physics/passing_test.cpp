// What moves past a solid without touching it goes on as it did: on a straight line, or in free fall.
#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "collide/convex_distance.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::passing_test {

namespace {

const char* const shapes[] = {
    "sphere: {radius: 0.05}",
    "box: {size: [0.1, 0.08, 0.13]}",
    "capsule: {radius: 0.03, length: 0.1}",
    "cylinder: {radius: 0.05, length: 0.1}",
    "hull: {points: [[0.05, 0.05, 0.05], [0.05, -0.05, -0.05], [-0.05, 0.05, -0.05], [-0.05, -0.05, 0.05]]}",
};
constexpr double size = 0.05, clearance = 0.01 * size, frame = 0.004;  // m, m, s
constexpr int frames = 30, times = 6;

class Pairs {
 public:
  explicit Pairs(unsigned seed) : random_(seed) {
    std::string text = "bodies:\n";
    for (const char* shape : shapes) text += "  - {shape: {" + std::string(shape) + "}, mass: 1}\n";
    Experiment of_each(scene_from_text(text));
    for (std::size_t i = 0; i < std::size(shapes); ++i) shapes_.push_back(of_each.world().properties[of_each.slot(Id(i))].shape);
  }

  // Each mover passes its obstacle on a line across a direction along which the two are `clearance` apart.
  std::string scene(bool fixed, int substeps, double restitution, const std::string& solver) {
    std::ostringstream text;
    text.precision(17);
    text << "time: {frame: " << frame << ", substeps: " << substeps << "}\ngravity: [0, 0, 0]\nsolver: {name: " << solver
         << "}\nmaterials: {default: {friction: 0.5, restitution: " << restitution << "}}\nbodies:\n";
    int cell = 0;
    for (std::size_t mover = 0; mover < shapes_.size(); ++mover)
      for (std::size_t obstacle = 0; obstacle < shapes_.size(); ++obstacle)
        for (int k = 0; k < times; ++k, ++cell) {
          const Vec3 centre(20. * (cell % 20), 20. * (cell / 20), 0);
          const Quat q = any_turn(), r = any_turn();
          const Vec3 along = any_direction(), across = along.cross(any_direction()).normalized();
          const double reach = reach_of(mover, q, -across) + reach_of(obstacle, r, across) + clearance;
          const double speed = uniform(0.1, 1.5) * size / frame;
          const Vec3 place =
              centre + reach * across + uniform(-0.5, 0.5) * size * along.cross(across) - uniform(8, 12) * frame * speed * along;
          add(text, mover, "mass: 1", place, q, speed * along);
          add(text, obstacle, fixed ? "motion: fixed" : "mass: 2", centre, r, Vec3::Zero());
        }
    return text.str();
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 any_direction() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  Quat any_turn() {
    std::normal_distribution<double> normal;
    return Quat(normal(random_), normal(random_), normal(random_), normal(random_)).normalized();
  }
  double reach_of(std::size_t shape, const Quat& turn, const Vec3& direction) const {
    if (is_round(shapes_[shape])) return shapes_[shape].size.x();
    const ConvexBody body = convex_body(shapes_[shape], turn.toRotationMatrix(), Vec3::Zero());
    return direction.dot(body.support(direction)) + body.rounding;
  }
  static void add(std::ostringstream& text, std::size_t shape, const char* motion, const Vec3& place, const Quat& q,
                  const Vec3& velocity) {
    text << "  - {shape: {" << shapes[shape] << "}, " << motion << ", position: [" << place.x() << ", " << place.y() << ", "
         << place.z() << "], orientation: [" << q.w() << ", " << q.x() << ", " << q.y() << ", " << q.z() << "]";
    if (velocity.norm() > 0) text << ", velocity: [" << velocity.x() << ", " << velocity.y() << ", " << velocity.z() << "]";
    text << "}\n";
  }

  std::mt19937 random_;
  std::vector<Shape> shapes_;
};

class Passing : public testing::TestWithParam<const char*> {};

void expect_all_go_on(Experiment& run, const std::string& what) {
  std::vector<Vec3> before(run.world().homes);
  for (std::size_t i = 0; i < before.size(); ++i) before[i] = run.world().velocity[i];
  std::vector<Id> ids(run.world().id.begin(), run.world().id.begin() + static_cast<std::ptrdiff_t>(before.size()));
  run.steps(frames * run.scene->time.substeps);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::size_t pair = static_cast<std::size_t>(ids[i]) / 2 / times;
    EXPECT_NEAR((run.velocity(ids[i]) - before[i]).norm(), 0, 1e-9)
        << what << ": " << shapes[pair / std::size(shapes)] << " past " << shapes[pair % std::size(shapes)];
    EXPECT_NEAR(run.world().angular_velocity_of(run.slot(ids[i])).norm(), 0, 1e-9) << what;
  }
}

TEST_P(Passing, SolidsThatDoNotTouchGoOn) {
  unsigned seed = 1;
  for (const bool fixed : {true, false})
    for (const int substeps : {1, 4})
      for (const double restitution : {0.0, 0.5}) {
        Experiment run(scene_from_text(Pairs(seed++).scene(fixed, substeps, restitution, GetParam())));
        expect_all_go_on(run, std::to_string(substeps) + " substeps");
      }
}

TEST(RanksPassing, SolidsThatDoNotTouchGoOn) {
  Experiment run(scene_from_text(Pairs(9).scene(false, 1, 0.5, "accelerated_jacobi")), MPI_COMM_WORLD);
  expect_all_go_on(run, "all ranks");
}

// A grain that falls through the opening of a silo, a tenth of a millimetre beside its rim.
TEST_P(Passing, AGrainFallsThroughAnOpening) {
  for (const int substeps : {1, 4})
    for (const double beside : {1e-4, 2e-5}) {
      std::ostringstream text;
      text << "time: {frame: 0.0025, substeps: " << substeps << "}\nsolver: {name: " << GetParam() << "}\nbodies:\n"
           << "  - {shape: {mesh: {revolve: {profile: [[0.01, 0], [0.022, 0], [0.022, 0.12]], sides: 48}}}}\n"
           << "  - {shape: {sphere: {radius: 0.002}}, mass: 1.0e-4, position: [" << 0.008 - beside << ", 0, 0.01]}\n";
      Experiment run(scene_from_text(text.str()));
      run.seconds(0.1);
      const double g = 9.81, t = 0.1, h = run.h();
      EXPECT_EQ(run.velocity(1).x(), 0) << substeps << " substeps, " << beside << " m beside the rim";
      EXPECT_EQ(run.world().angular_velocity_of(run.slot(1)), Vec3::Zero());
      EXPECT_NEAR(run.position(1).z(), 0.01 - 0.5 * g * t * (t + h), 1e-12);
    }
}

// A ball beside the border of a cloth, and one beside a thread, that are held.
TEST_P(Passing, ABallPassesAClothAndAThread) {
  for (const int substeps : {1, 4})
    for (const double speed : {1.0, 4.0, 9.0})  // up to 0.72 of its radius in a step
      for (const char* held :
           {"cloths:\n  - {grid: {size: [1, 1], nodes: [11, 11]}, mass_per_area: 0.2, thickness: 0.01, ",
            "threads:\n  - {points: [[0.5, -0.5, 0], [0.5, 0.5, 0]], segments: 10, mass: 0.1, radius: 0.005, "}) {
        std::ostringstream text;
        text << "time: {frame: 0.004, substeps: " << substeps << "}\ngravity: [0, 0, 0]\nsolver: {name: " << GetParam()
             << "}\nbodies:\n  - {shape: {sphere: {radius: 0.05}}, mass: 1, position: [0.556, 0.03, 0.313], velocity: [0, 0, "
             << -speed << "]}\n"
             << held << "pins: [{within: {min: [-9, -9, -9], max: [9, 9, 9]}}]}\n";
        Experiment run(scene_from_text(text.str()));
        run.seconds(0.6 / speed);
        EXPECT_NEAR((run.velocity(0) - Vec3(0, 0, -speed)).norm(), 0, 1e-12) << speed << " m/s, " << substeps << " substeps";
      }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Passing, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace

}  // namespace unibody::small_worlds::passing_test
