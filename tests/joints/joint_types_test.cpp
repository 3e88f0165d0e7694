// Gradients of all types of joints' rows, by differences of their values.
#include "joints/joint_types.hpp"

#include <gtest/gtest.h>

#include <random>

namespace unibody::joint_types_test {
namespace {

struct Pose {
  Vec3 place;
  Quat attitude;
};
struct Pair {
  Pose body[2];
  Vec3 anchor[2];
  Quat frame[2];
  JointEnd end(int e) const {
    const Pose& p = body[e];
    return {p.place, (p.attitude * frame[e]).toRotationMatrix(), p.place + p.attitude * anchor[e]};
  }
};

Vec3 random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> draw(-size, size);
  return {draw(random), draw(random), draw(random)};
}
Quat random_turn(std::mt19937& random, double size) {
  const Vec3 v = random_vector(random, size);
  return Quat(Eigen::AngleAxisd(v.norm(), v.normalized()));
}

// Apart and turned against each other by some tenths, as no joint in use is.
Pair random_pair(std::mt19937& random) {
  Pair pair;
  for (int e = 0; e < 2; ++e) {
    pair.body[e] = {random_vector(random, 1), random_turn(random, 3)};
    pair.anchor[e] = random_vector(random, 1), pair.frame[e] = random_turn(random, 3);
  }
  const Quat axes = pair.body[0].attitude * pair.frame[0] * random_turn(random, 0.4);
  pair.frame[1] = pair.body[1].attitude.conjugate() * axes;
  return pair;
}

void turn(Pose& pose, const Vec3& by) { pose.attitude = Quat(Eigen::AngleAxisd(by.norm(), by.normalized())) * pose.attitude; }

template <class T>
std::array<double, T::rows> values(const Pair& pair) {
  JointRows<T::rows> rows;
  T::evaluate(pair.end(0), pair.end(1), rows);
  return rows.value;
}

// The largest difference between the gradients and central differences of the values.
template <class T>
double gradient_error(const Pair& pair) {
  constexpr double d = 1e-6;
  JointRows<T::rows> rows;
  const JointEnd a = pair.end(0), b = pair.end(1);
  T::evaluate(a, b, rows);
  double worst = 0;
  for (int e = 0; e < 2; ++e)
    for (int axis = 0; axis < 6; ++axis) {
      Pair plus = pair, minus = pair;
      const Vec3 by = d * Vec3::Unit(axis % 3);
      if (axis < 3)
        plus.body[e].place += by, minus.body[e].place -= by;
      else
        turn(plus.body[e], by), turn(minus.body[e], -by);
      const auto up = values<T>(plus), down = values<T>(minus);
      for (std::size_t k = 0; k < T::rows; ++k) {
        const Vec3 linear = e == 0 ? rows.linear[k] : Vec3(-rows.linear[k]);
        const Vec3 angular = e == 0 ? rows.angular[k] : other_angular(rows.linear[k], rows.angular[k], a, b);
        worst = std::max(worst, std::abs((up[k] - down[k]) / (2 * d) - (axis < 3 ? linear : angular)[axis % 3]));
      }
    }
  return worst;
}

TEST(JointTypes, GradientsAreThoseOfTheValues) {
  std::mt19937 random(7);
  for (int i = 0; i < 50; ++i) {
    const Pair pair = random_pair(random);
    for (std::uint8_t type = 0; type < std::tuple_size_v<JointTypes>; ++type)
      with_joint_type(type, [&]<class T>() { EXPECT_LT(gradient_error<T>(pair), 2e-9) << T::name; });
  }
}

// Of what must move freely, no row sees anything: of each type as many directions are left as its name says.
TEST(JointTypes, AClosedJointHasIndependentRows) {
  std::mt19937 random(11);
  Pair pair = random_pair(random);
  const Quat axes = pair.body[0].attitude * pair.frame[0];
  pair.frame[1] = pair.body[1].attitude.conjugate() * axes;
  pair.anchor[1] = pair.body[1].attitude.conjugate() * (pair.end(0).point - pair.body[1].place);
  for (const std::uint8_t type : {0, 1, 2, 3, 4})
    with_joint_type(type, [&]<class T>() {
      JointRows<T::rows> rows;
      T::evaluate(pair.end(0), pair.end(1), rows);
      Eigen::Matrix<double, Eigen::Dynamic, 6> D(T::rows, 6);
      for (std::size_t k = 0; k < T::rows; ++k) {
        EXPECT_NEAR(rows.value[k], 0, 1e-14) << T::name;
        D.row(static_cast<Eigen::Index>(k)) << rows.linear[k].transpose(), rows.angular[k].transpose();
      }
      EXPECT_EQ(Eigen::FullPivLU<Eigen::MatrixXd>(D).rank(), static_cast<Eigen::Index>(T::rows)) << T::name;
    });
}

TEST(JointTypes, AHingesAngleIsThatOfTheFirstBodyAboutTheAxis) {
  std::mt19937 random(13);
  Pair pair = random_pair(random);
  const Quat axes = pair.body[1].attitude * pair.frame[1];
  for (const double angle : {-3.0, -1.0, 0.0, 0.5, 3.0}) {
    const Quat turned = axes * Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    pair.frame[0] = pair.body[0].attitude.conjugate() * turned;
    EXPECT_NEAR(values<Angle>(pair)[0], angle, 1e-13);
    EXPECT_NEAR(values<Hinge>(pair)[3], 0, 1e-14);
  }
}

}  // namespace
}  // namespace unibody::joint_types_test
