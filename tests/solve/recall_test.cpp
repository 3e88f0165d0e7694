// Warm start: which old multipliers a contact point begins with.
#include "constraints/recall.hpp"

#include <gtest/gtest.h>

#include "collide/bodies.hpp"
#include "collide/cores.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::recall_test {

namespace {

constexpr double h = 0.016;

std::vector<ContactBatch::Impulse> recalled(const Multipliers& multipliers, const World& world, const Contacts& contacts,
                                            double step) {
  std::vector<ContactBatch::Impulse> impulses(contacts.points.size());
  recall(multipliers, world, contacts, step, impulses);
  return impulses;
}

// Two boxes face to face with points where they are asked for.
struct Faces {
  World world;
  Contacts contacts;
  Multipliers multipliers;

  explicit Faces(const std::vector<Vec3>& points, const Vec3& normal = -Vec3::UnitZ()) {
    Body a = block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5)), b = block(1, Vec3(1, 1, 1), Vec3(0, 0, 1.5));
    a.id = 4, b.id = 9;
    world = unibody::samples::world_of({a, b});
    set(points, normal);
  }
  void set(const std::vector<Vec3>& points, const Vec3& normal = -Vec3::UnitZ()) {
    contacts.clear();
    contacts.manifolds.push_back({4, 9, 0, 1, normal, 0.5, 0, static_cast<std::uint32_t>(points.size())});
    for (std::uint32_t k = 0; k < points.size(); ++k) contacts.points.push_back({points[k], 0, k});
  }
  void keep(const std::vector<ContactBatch::Impulse>& impulses) { remember(multipliers, world, contacts, impulses, h); }
  std::vector<ContactBatch::Impulse> found() const { return recalled(multipliers, world, contacts, h); }
};

const std::vector<Vec3> corners{{-.5, -.5, 1}, {.5, -.5, 1}, {-.5, .5, 1}, {.5, .5, 1}};
const std::vector<ContactBatch::Impulse> four{{1, .1, .2}, {2, .3, .4}, {3, .5, .6}, {4, .7, .8}};

}  // namespace

TEST(Recall, GivesBackWhatWasKept) {
  Faces f(corners);
  f.keep(four);
  const auto found = f.found();
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found[k].n, four[k].n, 1e-15);
    EXPECT_NEAR(found[k].s, four[k].s, 1e-15);
    EXPECT_NEAR(found[k].t, four[k].t, 1e-15);
  }
}

TEST(Recall, MatchesByPlaceNotByOrder) {
  Faces f(corners);
  f.keep(four);
  const std::size_t order[4] = {2, 0, 3, 1};
  f.set({corners[2] + Vec3(.01, 0, 0), corners[0] + Vec3(0, .02, 0), corners[3], corners[1] - Vec3(.01, .01, 0)});
  const auto found = f.found();
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k].n, four[order[k]].n, 1e-15);
}

TEST(Recall, PointsTravelWithTheBody) {
  Faces f(corners);
  f.keep(four);
  const Quat turn(Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()));
  const Vec3 shift(7, -3, 2);
  f.world.position[0] = turn * f.world.position[0] + shift, f.world.orientation[0] = turn;
  std::vector<Vec3> moved;
  for (const Vec3& p : corners) moved.push_back(turn * p + shift);
  f.set(moved, -(turn * Vec3::UnitZ()));
  const auto found = f.found();
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k].n, four[k].n, 1e-14);
}

// The tangential part is a vector of the world: in other tangents it has other components and the same direction.
TEST(Recall, TangentsAreKeptAsAVector) {
  Faces f({corners[0]});
  f.keep({{1, .3, .4}});
  const Vec3 n0 = -Vec3::UnitZ(), n1 = Vec3(0.1, 0.05, -1).normalized();
  f.set({corners[0]}, n1);
  const auto world = [](const Vec3& n, const ContactBatch::Impulse& i) {
    const Vec3 s = first_tangent_of(n);
    return Vec3(s * i.s + n.cross(s) * i.t);
  };
  const Vec3 before = world(n0, {1, .3, .4}), after = world(n1, f.found()[0]);
  EXPECT_LT((after - (before - n1 * n1.dot(before))).norm(), 1e-15);
}

TEST(Recall, EachOldPointServesOnce) {
  Faces f({corners[0]});
  f.keep({{5, 0, 0}});
  f.set({corners[0], corners[0] + Vec3(.01, 0, 0)});
  const auto found = f.found();
  EXPECT_NEAR(found[0].n + found[1].n, 5, 1e-15);
  EXPECT_EQ(found[0].n * found[1].n, 0);
}

TEST(Recall, FarPointsAndOtherPairsStartCold) {
  Faces f({corners[0]});
  f.keep({{5, 0, 0}});
  f.set({corners[3]});
  EXPECT_EQ(f.found()[0].n, 0);
  f.set({corners[0]});
  f.contacts.manifolds[0].id_b = 10;
  EXPECT_EQ(f.found()[0].n, 0);
}

// A ball rolls: its one contact point is the same contact wherever it is on the ball.
TEST(Recall, ARollingBallKeepsItsContact) {
  Body b = ball(1, 0.5, Vec3(0, 0, 0.5)), floor = ground();
  b.id = 0, floor.id = 1;
  Contacts contacts;
  contacts.manifolds.push_back({0, 1, 0, 1, Vec3::UnitZ(), 0.5, 0, 1});
  contacts.points.push_back({Vec3::Zero(), 0, 0});
  World world = unibody::samples::world_of({b, floor});
  Multipliers multipliers;
  const std::vector<ContactBatch::Impulse> one{{5, 0, 0}};
  remember(multipliers, world, contacts, one, h);
  world.orientation[0] = Quat(Eigen::AngleAxisd(2, Vec3::UnitY()));
  EXPECT_NEAR(recalled(multipliers, world, contacts, h)[0].n, 5, 1e-14);
  EXPECT_NEAR(recalled(multipliers, world, contacts, h / 2)[0].n, 2.5, 1e-14);  // forces are kept, impulses go with the step
}

// The core of a fast body makes a manifold of its own. It gives the ball's one point nothing and takes nothing from it, and the
// pair is remembered with one point, which is what a checkpoint holds of a pair without places.
TEST(Recall, ACoreBesideTheOnePointIsNotRemembered) {
  Body b = ball(1, 0.5, Vec3(0, 0, 0.5)), slab = block(1, Vec3(1, 1, 0.1), Vec3(0, 0, -0.05));
  b.id = 0, slab.id = 1;
  const World world = unibody::samples::world_of({b, slab});
  Contacts contacts;
  contacts.manifolds.push_back({0, 1, 0, 1, Vec3::UnitZ(), 0.5, 0, 1});
  contacts.manifolds.push_back({0, 1, 0, 1, Vec3::UnitZ(), 0.5, 1, 1});
  contacts.points.push_back({Vec3::Zero(), 0, 0});
  contacts.points.push_back({Vec3::Zero(), 0, core_feature});
  Multipliers multipliers;
  remember(multipliers, world, contacts, std::vector<ContactBatch::Impulse>{{5, 0, 0}, {7, 0, 0}}, h);
  ASSERT_EQ(multipliers.manifolds.size(), 1U);
  EXPECT_EQ(multipliers.points.size(), 1U);
  EXPECT_TRUE(multipliers.places.empty());
  const auto both = recalled(multipliers, world, contacts, h);
  EXPECT_NEAR(both[0].n, 5, 1e-14);
  EXPECT_EQ(both[1].n, 0);
  contacts.manifolds.erase(contacts.manifolds.begin());
  EXPECT_EQ(recalled(multipliers, world, contacts, h)[1].n, 0) << "the core alone";
}

}  // namespace unibody::small_worlds::recall_test
