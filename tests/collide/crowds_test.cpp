// Crowds: so many contacts as bodies, which of them by the ids alone; and nothing else where there is none.
#include "collide/crowds.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "collide/bodies.hpp"
#include "collide/collide.hpp"
#include "small_worlds.hpp"

namespace unibody::crowds_test {
namespace {

using small_worlds::Experiment;

std::string balls(int count, const std::string& more = "") {
  return "gravity: [0, 0, 0]\nbodies:\n  - shape: {sphere: {radius: 0.05}}\n    mass: 1\n    lattice: {count: " +
         std::to_string(count) + ", columns: [1, 1], spacing: [1, 1, 1.0e-12]" + more + "}\n";
}

std::set<std::pair<Id, Id>> pairs_of(const Contacts& contacts) {
  std::set<std::pair<Id, Id>> pairs;
  for (const Manifold& m : contacts.manifolds) EXPECT_TRUE(pairs.emplace(m.id_a, m.id_b).second);
  return pairs;
}

TEST(Crowds, OfBodiesAtOnePlaceEachMeetsTheNextTwo) {
  Experiment run(small_worlds::scene_from_text(balls(100)));
  run.simulation->detect();
  EXPECT_TRUE(run.simulation->is_crowded());
  EXPECT_EQ(count_crowds(*run.simulation).bodies, 100);
  EXPECT_EQ(count_crowds(*run.simulation).most, 100);
  std::set<std::pair<Id, Id>> expected;
  for (Id a = 0; a < 100; ++a)
    for (Id b = a + 1; b < std::min<Id>(100, a + 3); ++b) expected.emplace(a, b);
  EXPECT_EQ(pairs_of(run.simulation->contacts), expected);
}

TEST(Crowds, FourAtOnePlaceAreNone) {
  Experiment run(small_worlds::scene_from_text(balls(4)));
  run.simulation->detect();
  EXPECT_FALSE(run.simulation->is_crowded());
  EXPECT_EQ(run.simulation->contacts.manifolds.size(), 6u);
}

// Bodies of three sizes thrown into the room of a few, by brute force: which of all pairs that would be found meet.
TEST(Crowds, TheRuleIsThatOfAllPairs) {
  Experiment run(small_worlds::scene_from_text(
      "gravity: [0, 0, 0]\nbodies:\n  - {shape: {box: {size: [3, 3, 0.1]}}, mass: 5, position: [0, 0, -0.1]}\n"
      "  - {shape: {sphere: {radius: 0.05}}, mass: 1, lattice: {count: 200, columns: [1, 1], spacing: [1, 1, 1.0e-5], jitter: "
      "0.01}}\n"
      "  - {shape: {box: {size: [0.1, 0.2, 0.1]}}, mass: 1, lattice: {count: 60, columns: [1, 1], spacing: [1, 1, 1.0e-5], "
      "jitter: 0.01}}\n"));
  const World& world = run.world();
  CollideSettings settings;
  const std::vector<double> friction{0.5};
  settings.friction = friction, settings.material_count = 1;
  Contacts all, thinned;
  Collider().collide(world, settings, all);
  const auto ranks = crowd_ranks(world);
  ASSERT_EQ(ranks.size(), world.size());
  Collider().collide(world, settings, thinned, nullptr, ranks);
  std::set<std::pair<Id, Id>> expected;
  for (const auto& [a, b] : pairs_of(all)) {
    const std::size_t i = run.slot(a), j = run.slot(b);
    const bool both = ranks[i] >= 0 && ranks[j] >= 0;
    const bool same =
        both && crowd_cell(world.properties[i], world.position[i]) == crowd_cell(world.properties[j], world.position[j]);
    const auto apart = std::abs(ranks[i] - ranks[j]);
    if (!both || (same ? apart <= reach_in_crowd : apart == 0)) expected.emplace(a, b);
  }
  EXPECT_EQ(pairs_of(thinned), expected);
  EXPECT_LT(expected.size(), all.manifolds.size() / 4);
}

// Nothing at rest or in use is a crowd: bodies that touch, on all sides and deeply, have one centre in a cell.
TEST(Crowds, BodiesThatTouchAreNone) {
  for (const char* shape : {"sphere: {radius: 0.05}", "box: {size: [0.1, 0.1, 0.1]}", "box: {size: [0.1, 1, 1]}"}) {
    Experiment run(
        small_worlds::scene_from_text("bodies:\n  - {shape: {" + std::string(shape) +
                                      "}, mass: 1, lattice: {count: 512, columns: [8, 8], spacing: [0.06, 0.06, 0.06]}}\n"));
    EXPECT_TRUE(crowd_ranks(run.world()).empty()) << shape;
  }
}

TEST(Crowds, PairsGrowWithTheBodies) {
  for (const int count : {1000, 10'000, 100'000}) {
    Experiment run(small_worlds::scene_from_text(balls(count, ", jitter: 0.05")));
    run.simulation->detect();
    EXPECT_LT(run.simulation->contacts.manifolds.size(), 60u * static_cast<std::size_t>(count)) << count;
  }
}

TEST(Crowds, GetApart) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Scene scene = small_worlds::scene_from_text(balls(30));
    scene.solver.name = solver;
    Experiment run(std::move(scene));
    run.seconds(8);
    run.simulation->detect();
    EXPECT_FALSE(run.simulation->is_crowded()) << solver;
    EXPECT_LT(run.penetration(), 0.01) << solver;
    EXPECT_LT(run.momentum().norm(), 1e-9) << solver;
  }
}

}  // namespace
}  // namespace unibody::crowds_test
