// Manifolds that are taken away take with them what belongs to their points, and nothing of the others'.
#include <gtest/gtest.h>

#include "collide/contacts.hpp"

namespace unibody::samples::leave_out_test {

namespace {

// Manifold m has m + 1 points; gap and bounce of each tell whose it is.
Contacts some_contacts(bool bouncing) {
  Contacts contacts;
  for (std::uint32_t m = 0; m < 4; ++m) {
    contacts.manifolds.push_back(
        {m, m + 1, Slot(m), Slot(m + 1), Vec3::UnitZ(), 0, static_cast<std::uint32_t>(contacts.points.size()), m + 1});
    for (std::uint32_t p = 0; p <= m; ++p) {
      contacts.points.push_back({Vec3::Zero(), 10.0 * m + p, p});
      if (bouncing) contacts.bounce.push_back(100 + 10.0 * m + p);
    }
  }
  return contacts;
}

TEST(LeaveOut, WhatIsSaidOfAPointStaysWithIt) {
  Contacts contacts = some_contacts(true);
  leave_out(contacts, [](const Manifold& m) { return m.id_a == 0 || m.id_a == 2; });
  ASSERT_EQ(contacts.manifolds.size(), 2u);
  ASSERT_EQ(contacts.points.size(), 6u);
  ASSERT_EQ(contacts.bounce.size(), 6u);
  for (const Manifold& m : contacts.manifolds)
    for (std::uint32_t p = 0; p < m.count; ++p) {
      EXPECT_EQ(contacts.points[m.first + p].gap, 10.0 * static_cast<double>(m.id_a) + p);
      EXPECT_EQ(contacts.bounce[m.first + p], 100 + contacts.points[m.first + p].gap);
    }
}

TEST(LeaveOut, WhereNothingBouncesNothingIsSaid) {
  Contacts contacts = some_contacts(false);
  leave_out(contacts, [](const Manifold& m) { return m.id_a == 1; });
  EXPECT_EQ(contacts.points.size(), 8u);
  EXPECT_TRUE(contacts.bounce.empty());
}

}  // namespace
}  // namespace unibody::samples::leave_out_test
