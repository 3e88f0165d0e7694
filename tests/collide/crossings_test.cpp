// Crossings against every edge with every face, and against counts known by hand.
#include "collide/crossings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <ostream>

#include "collide/bodies.hpp"
#include "collide/triangle_crossing.hpp"

namespace unibody::crossings_test {

void PrintTo(const Crossing& c, std::ostream* out) { *out << c.edge << " through " << c.face; }

namespace {

using samples::Random;

struct Soup {
  std::vector<Vec3> positions;
  std::vector<Face> faces;
  std::vector<Edge> edges;

  std::vector<Crossing> crossings(const std::vector<std::uint8_t>& counted = {}) const {
    return find_crossings(positions, faces, edges, counted);
  }
};

bool touch(const Soup& s, std::size_t e, std::size_t f) {
  const auto& x = s.positions;
  const auto [p, q] = s.edges[e];
  const auto [a, b, c] = s.faces[f];
  return edge_crosses_face(x[p], x[q], x[a], x[b], x[c]);
}

bool adjacent(const Soup& s, std::size_t e, std::size_t f) {
  for (const Slot end : s.edges[e])
    if (std::count(s.faces[f].begin(), s.faces[f].end(), end) > 0) return true;
  return false;
}

std::vector<Crossing> brute_force(const Soup& s, const std::vector<std::uint8_t>& counted = {}) {
  std::vector<Crossing> all;
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t f = 0; f < s.faces.size(); ++f)
      if ((counted.empty() || counted[e] != 0) && !adjacent(s, e, f) && touch(s, e, f))
        all.push_back({static_cast<std::int32_t>(e), static_cast<std::int32_t>(f)});
  return all;
}

// Faces and edges between random nodes. `whole`: places are whole numbers, so that much touches, lies in one plane or coincides.
Soup random_soup(std::uint64_t seed, int nodes, int faces, int edges, double side, bool whole) {
  Random random(seed);
  Soup s;
  for (int k = 0; k < nodes; ++k) {
    const Vec3 x = random.vector(-side, side);
    s.positions.push_back(whole ? Vec3(x.array().round()) : x);
  }
  const auto node = [&] { return static_cast<Slot>(random.engine() % static_cast<std::uint64_t>(nodes)); };
  for (int k = 0; k < faces; ++k) s.faces.push_back({node(), node(), node()});
  for (int k = 0; k < edges; ++k) s.edges.push_back({node(), node()});
  return s;
}

// nx x ny nodes at origin + i u + j v, each cell cut from (i, j) to (i + 1, j + 1), and the edges of its faces.
void add_sheet(Soup& s, int nx, int ny, const Vec3& origin, const Vec3& u, const Vec3& v) {
  const auto first = static_cast<Slot>(s.positions.size());
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) s.positions.push_back(origin + i * u + j * v);
  std::vector<Face> faces;
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i) {
      const Slot a = first + i + nx * j, b = a + 1, c = a + nx, d = c + 1;
      faces.push_back({a, b, d}), faces.push_back({a, d, c});
    }
  const auto edges = unique_edges(faces);
  s.faces.insert(s.faces.end(), faces.begin(), faces.end());
  s.edges.insert(s.edges.end(), edges.begin(), edges.end());
}

TEST(Crossings, AreThoseOfBruteForceInRandomSoups) {
  std::uint64_t seed = 1;
  std::size_t found = 0;
  for (const double side : {1.0, 30.0})
    for (const int nodes : {3, 12, 300}) {
      const Soup s = random_soup(seed++, nodes, 150, 200, side, false);
      const auto expected = brute_force(s);
      EXPECT_EQ(s.crossings(), expected) << "side " << side << ", nodes " << nodes;
      found += expected.size();
    }
  EXPECT_GT(found, 1000u);
}

TEST(Crossings, AreThoseOfBruteForceWhereNodesCoincideAndFacesTouchOrLieInOnePlane) {
  std::size_t found = 0, flat = 0, coincident = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Soup s = random_soup(seed, 60, 150, 150, seed % 2 ? 1.4 : 4, true);
    if (seed % 3 == 0)
      for (Vec3& x : s.positions) x.z() = 0;
    const auto expected = brute_force(s);
    EXPECT_EQ(s.crossings(), expected) << "seed " << seed;
    found += expected.size();
    for (const Crossing& c : expected) {
      const auto& x = s.positions;
      const auto [a, b, d] = s.faces[c.face];
      const auto [p, q] = s.edges[c.edge];
      flat += orient3d(x[a], x[b], x[d], x[p]) == 0 && orient3d(x[a], x[b], x[d], x[q]) == 0;
      coincident += x[p] == x[q];
    }
  }
  EXPECT_GT(found, 5000u);
  EXPECT_GT(flat, 500u);
  EXPECT_GT(coincident, 50u);
}

TEST(Crossings, AllNodesAtOnePointCrossAll) {
  for (const double at : {0.0, 1.0, -1e9, 1e-30}) {
    const Soup s{std::vector<Vec3>(5, Vec3::Constant(at)), {{0, 1, 2}}, {{3, 4}, {2, 3}}};
    EXPECT_EQ(s.crossings(), (std::vector<Crossing>{{0, 0}})) << at;
  }
}

TEST(Crossings, NeighboursNeverCount) {
  // All edges of a sheet folded flat onto itself touch faces: those of the same node are left out, the others are not.
  Soup s;
  add_sheet(s, 3, 2, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
  for (const Crossing& c : s.crossings()) ADD_FAILURE() << c.edge << " through " << c.face << " of a flat sheet";
  for (const Slot node : {2, 5}) s.positions[node].x() = 0.25;
  const auto crossings = s.crossings();
  EXPECT_EQ(crossings, brute_force(s));
  EXPECT_FALSE(crossings.empty());
  std::size_t touching = 0;
  for (std::size_t e = 0; e < s.edges.size(); ++e)
    for (std::size_t f = 0; f < s.faces.size(); ++f) touching += touch(s, e, f);
  EXPECT_GT(touching, crossings.size());
  for (const Crossing& c : crossings)
    EXPECT_FALSE(adjacent(s, static_cast<std::size_t>(c.edge), static_cast<std::size_t>(c.face)));
}

TEST(Crossings, OfTwoSheetsThatStandInEachOther) {
  // A flat sheet, and an upright one in the plane x = 3.3 that reaches from y = 1.05 to 4.05 through it. Of the upright one's
  // edges its 7 columns and its 6 diagonals pass the plane of the flat one. Of the flat one's, between the same two columns of
  // nodes, the 3 along x at y = 2, 3, 4 and the 3 diagonals that pass x = 3.3 at y = 1.3, 2.3, 3.3.
  Soup s;
  add_sheet(s, 8, 7, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
  const std::size_t faces = s.faces.size(), edges = s.edges.size();
  add_sheet(s, 7, 4, {3.3, 1.05, -0.77}, {0, 0.5, 0}, {0, 0, 0.6});
  const auto crossings = s.crossings();
  EXPECT_EQ(crossings, brute_force(s));
  std::size_t upright = 0, flat = 0;
  for (const Crossing& c : crossings) {
    const bool of_flat = static_cast<std::size_t>(c.edge) < edges;
    EXPECT_NE(of_flat, static_cast<std::size_t>(c.face) < faces) << "a flat sheet crosses itself";
    ++(of_flat ? flat : upright);
  }
  EXPECT_EQ(upright, 13u);
  EXPECT_EQ(flat, 6u);

  for (std::size_t k = 8 * 7; k < s.positions.size(); ++k) s.positions[k].z() += 0.78;  // just above
  EXPECT_TRUE(s.crossings().empty());
}

TEST(Crossings, OfAThreadThroughASheet) {
  Soup s;
  add_sheet(s, 9, 9, {-1, -1, 0}, {0.25, 0, 0}, {0, 0.25, 0});
  const auto first = static_cast<Slot>(s.positions.size());
  const auto start = static_cast<std::int32_t>(s.edges.size());
  for (int k = 0; k < 6; ++k) {  // in stitches: up, down, up, down, and beside the sheet's end
    s.positions.push_back({-0.9 + 0.41 * k, 0.03, k % 2 ? 0.1 : -0.1});
    if (k > 0) s.edges.push_back({first + k - 1, first + k});
  }
  auto crossings = s.crossings();
  EXPECT_EQ(crossings, brute_force(s));
  ASSERT_EQ(crossings.size(), 5u);
  for (std::int32_t k = 0; k < 5; ++k) EXPECT_EQ(crossings[k].edge, start + k);

  s.positions[first + 5].x() = 1.6;  // the last stitch passes z = 0 at x = 1.17
  EXPECT_EQ(s.crossings().size(), 4u);
}

TEST(Crossings, OnlyCountedEdgesCount) {
  const Soup s = random_soup(7, 200, 150, 200, 1, false);
  const auto all = s.crossings();
  EXPECT_GT(all.size(), 100u);
  std::vector<Crossing> together;
  for (std::size_t rank = 0; rank < 3; ++rank) {  // each edge on one rank
    std::vector<std::uint8_t> counted(s.edges.size());
    for (std::size_t e = 0; e < counted.size(); ++e) counted[e] = e % 3 == rank;
    const auto own = s.crossings(counted);
    EXPECT_EQ(own, brute_force(s, counted));
    together.insert(together.end(), own.begin(), own.end());
  }
  EXPECT_EQ(together.size(), all.size());
  EXPECT_TRUE(s.crossings(std::vector<std::uint8_t>(s.edges.size(), 0)).empty());
}

TEST(Crossings, OfNothingAndOfNodesThatAreNotFinite) {
  EXPECT_TRUE(find_crossings({}, {}, {}).empty());
  Soup s{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.3, -1}, {0.3, 0.3, 1}},
         {{0, 1, 2}},
         {{3, 4}, {5, 6}}};
  EXPECT_EQ(s.crossings(), (std::vector<Crossing>{{0, 0}, {1, 0}}));
  const Soup good = s;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (std::size_t node = 0; node < 5; ++node)
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        s = good, s.positions[node][axis] = bad;
        const auto expected = node < 3 ? std::vector<Crossing>{} : std::vector<Crossing>{{1, 0}};
        EXPECT_EQ(s.crossings(), expected) << bad << " at node " << node << ", axis " << axis;
      }
}

TEST(Crossings, UniqueEdgesOfFaces) {
  EXPECT_TRUE(unique_edges({}).empty());
  const std::vector<Face> faces{{4, 7, 2}, {7, 4, 9}, {5, 5, 1}};  // two that share an edge, and one without area
  EXPECT_EQ(unique_edges(faces), (std::vector<Edge>{{1, 5}, {2, 4}, {2, 7}, {4, 7}, {4, 9}, {7, 9}}));
}

}  // namespace
}  // namespace unibody::crossings_test
