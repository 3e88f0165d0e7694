#include "world/properties.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace unibody::properties_test {
namespace {

BodyProperties of_mass(double mass) {
  BodyProperties p;
  p.mass = mass;
  return p;
}

TEST(PropertyTable, EachSlotHasItsOwn) {
  PropertyTable table;
  table.resize(100);
  for (std::size_t i = 0; i < 100; ++i) table.set(i, of_mass(static_cast<double>(i)));
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(table[i].mass, static_cast<double>(i));
}

TEST(PropertyTable, BodiesThatAreAlikeShareACopy) {
  PropertyTable table;
  table.resize(10000);
  for (std::size_t i = 0; i < 10000; ++i) table.set(i, of_mass(i % 2 == 0 ? 1.5 : 2.5));
  for (std::size_t i = 0; i < 10000; ++i) EXPECT_EQ(table[i].mass, i % 2 == 0 ? 1.5 : 2.5);
  EXPECT_LT(table.bytes(), 10000 * 5u);
}

TEST(PropertyTable, ASignOfZeroCounts) {
  PropertyTable table;
  table.resize(2);
  BodyProperties p;
  table.set(0, p);
  p.force.x() = -0.0;
  table.set(1, p);
  EXPECT_FALSE(std::signbit(table[0].force.x()));
  EXPECT_TRUE(std::signbit(table[1].force.x()));
}

TEST(PropertyTable, WhatNoBodyHasAnyMoreIsDropped) {
  PropertyTable table;
  table.resize(1000);
  for (int round = 0; round < 20; ++round)
    for (std::size_t i = 0; i < 1000; ++i) table.set(i, of_mass(1000 * round + static_cast<double>(i)));
  for (std::size_t i = 0; i < 1000; ++i) EXPECT_EQ(table[i].mass, 19000 + static_cast<double>(i));
  EXPECT_LT(table.bytes(), 1300 * (sizeof(BodyProperties) + 4));
}

}  // namespace
}  // namespace unibody::properties_test
