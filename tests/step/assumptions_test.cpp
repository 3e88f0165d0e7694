// What debug builds assume: each fault of a world or of its contacts is found, and a sound scene has none.
#include <gtest/gtest.h>

#include <limits>

#include "collide/contact_faults.hpp"
#include "core/assume.hpp"
#include "small_worlds.hpp"
#include "world/world_faults.hpp"

namespace unibody::small_worlds::assumptions_test {
namespace {

// Two balls that lie on the ground and on each other.
Experiment two_balls() {
  Scene scene = scene_with(0.5);
  add(scene, ball(1, 0.5, {0, 0, 0.5}));
  add(scene, ball(1, 0.5, {0, 0, 1.5}));
  add(scene, ground());
  Experiment e(std::move(scene));
  e.simulation->detect();
  return e;
}

TEST(Assumptions, HoldOfAScene) {
  Experiment e = two_balls();
  EXPECT_EQ(fault_of(e.world()), "");
  EXPECT_EQ(fault_of(e.simulation->contacts, e.world()), "");
  EXPECT_EQ(e.simulation->contacts.manifolds.size(), 2u);
}

TEST(Assumptions, FaultsOfAWorldAreNamed) {
  const auto fault_after = [](auto&& damage) {
    Experiment e = two_balls();
    damage(e.world());
    return fault_of(e.world());
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fault_after([](World& w) { w.position.pop_back(); }), "positions or velocities are not as many as bodies");
  EXPECT_EQ(fault_after([](World& w) { w.orientation.pop_back(); }), "rotations are not as many as bodies");
  EXPECT_EQ(fault_after([](World& w) { w.guests = 5; }), "more homes and guests than bodies");
  EXPECT_EQ(fault_after([](World& w) { std::swap(w.id[0], w.id[1]); }), "body 0 stands behind body 1");
  EXPECT_EQ(fault_after([](World& w) { w.id[1] = 0; }), "body 0 stands behind body 0");
  EXPECT_EQ(fault_after([](World& w) { w.position[1].y() = nan; }), "the state of body 1 is not finite");
  EXPECT_EQ(fault_after([](World& w) { w.angular_velocity[0].x() = 1 / 0.0; }), "the state of body 0 is not finite");
  EXPECT_EQ(fault_after([](World& w) { w.orientation[1].w() = 1.001; }), "the orientation of body 1 is not of length 1");
}

TEST(Assumptions, FaultsOfContactsAreNamed) {
  const auto fault_after = [](auto&& damage) {
    Experiment e = two_balls();
    Contacts contacts = e.simulation->contacts;
    damage(contacts);
    return fault_of(contacts, e.world());
  };
  const std::string first = "the contact of bodies 0 and 1: ";
  EXPECT_EQ(fault_after([](Contacts& c) { std::swap(c.manifolds[0], c.manifolds[1]); }), first + "it is not in order");
  EXPECT_EQ(fault_after([](Contacts& c) { c.manifolds[0].slot_a = 1; }), first + "a slot holds another body");
  EXPECT_EQ(fault_after([](Contacts& c) { c.manifolds[0].slot_b = 1000; }), first + "a slot holds another body");
  EXPECT_EQ(fault_after([](Contacts& c) { c.manifolds[0].slot_b = -1; }), first + "a slot holds another body");
  EXPECT_EQ(fault_after([](Contacts& c) { c.manifolds[0].first = 100; }), first + "its points are not in the list");
  EXPECT_EQ(fault_after([](Contacts& c) { c.manifolds[0].normal *= 1.1; }), first + "its normal is not of length 1");
  EXPECT_EQ(fault_after([](Contacts& c) { c.points[0].gap = 1 / 0.0; }), first + "a point is not finite");
  EXPECT_EQ(fault_after([](Contacts& c) { std::swap(c.manifolds[0].id_a, c.manifolds[0].id_b); }),
            "the contact of bodies 1 and 0: its bodies are not in order");
}

TEST(Assumptions, AreCheckedInDebugBuildsAlone) {
  int asked = 0;
  const auto fault = [&] { return ++asked, std::string("a fault"); };
  if (checks_assumptions)
    EXPECT_THROW(assume(fault), std::logic_error);
  else
    assume(fault);
  EXPECT_EQ(asked, checks_assumptions ? 1 : 0);
  assume([] { return std::string(); });
}

}  // namespace
}  // namespace unibody::small_worlds::assumptions_test
