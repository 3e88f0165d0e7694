// Meshes of tetrahedra: boundary against brute force, orientation, parts, and the message of every fault.
#include "meshes/tet_topology.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "scene/scene_text.hpp"

namespace unibody::tet_topology_test {
namespace {

using Tet = std::array<std::int32_t, 4>;
using Face = std::array<std::int32_t, 3>;

const TetMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
const TetMesh pair{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}}};

// A random part of a grid of cubes, six tets around a diagonal each, with nodes moved, renumbered, and in any order in a tet.
TetMesh random_mesh(std::mt19937& random, bool whole = false) {
  constexpr std::int32_t n = 4;
  TetMesh mesh;
  std::uniform_real_distribution<double> shift(-0.1, 0.1);
  for (std::int32_t i = 0; i < n * n * n; ++i)
    mesh.nodes.emplace_back(i % n + shift(random), i / n % n + shift(random), i / n / n + shift(random));
  for (std::int32_t i = 0; i < n * n * n; ++i) {
    if (i % n == n - 1 || i / n % n == n - 1 || i / n / n == n - 1) continue;
    Face steps{1, n, n * n};
    do {
      if (!whole && random() % 3 == 0) continue;
      mesh.tets.push_back({i, i + steps[0], i + steps[0] + steps[1], i + 1 + n + n * n});
    } while (std::next_permutation(steps.begin(), steps.end()));
  }
  std::vector<std::int32_t> number(mesh.nodes.size());
  for (std::size_t i = 0; i < number.size(); ++i) number[i] = static_cast<std::int32_t>(i);
  std::shuffle(number.begin(), number.end(), random);
  std::vector<Vec3> nodes(mesh.nodes.size());
  for (std::size_t i = 0; i < number.size(); ++i) nodes[static_cast<std::size_t>(number[i])] = mesh.nodes[i];
  mesh.nodes = nodes;
  for (Tet& tet : mesh.tets) {
    for (std::int32_t& node : tet) node = number[static_cast<std::size_t>(node)];
    std::shuffle(tet.begin(), tet.end(), random);
  }
  std::shuffle(mesh.tets.begin(), mesh.tets.end(), random);
  return mesh;
}

const Vec3& node(const TetMesh& mesh, std::int32_t n) { return mesh.nodes[static_cast<std::size_t>(n)]; }

double determinant(const TetMesh& mesh, const Tet& tet) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = node(mesh, tet[static_cast<std::size_t>(k + 1)]) - node(mesh, tet[0]);
  return edges.determinant();
}

// Of every tet in turn, the faces whose three nodes no other tet has, turned so that the fourth node lies behind them.
std::vector<std::set<std::int32_t>> brute_boundary(const TetMesh& mesh) {
  std::vector<std::set<std::int32_t>> faces;
  for (const Tet& tet : mesh.tets)
    for (std::size_t k = 0; k < 4; ++k) {
      std::set<std::int32_t> face(tet.begin(), tet.end());
      face.erase(tet[k]);
      int tets = 0;
      for (const Tet& other : mesh.tets)
        tets += std::all_of(face.begin(), face.end(),
                            [&](std::int32_t n) { return std::find(other.begin(), other.end(), n) != other.end(); });
      if (tets == 1) faces.push_back(face);
    }
  return faces;
}

TEST(TetTopology, FacesOfOneTetSeenFromTheOutside) {
  EXPECT_EQ(boundary_of(corner), (std::vector<Face>{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}));
  EXPECT_EQ(boundary_of(pair), (std::vector<Face>{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {2, 1, 4}, {0, 4, 1}, {0, 2, 4}}));
  EXPECT_DOUBLE_EQ(tet_volume(corner, 0), 1.0 / 6);
}

TEST(TetTopology, BoundaryIsThatOfBruteForceClosedAndEnclosesTheTets) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    TetMesh mesh = random_mesh(random, trial == 0);
    orient_tets(mesh, "mesh");
    check_tets(mesh, "mesh");
    double volume = 0, enclosed = 0;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      EXPECT_GT(determinant(mesh, mesh.tets[t]), 0);
      EXPECT_NEAR(tet_volume(mesh, t), determinant(mesh, mesh.tets[t]) / 6, 1e-15);
      volume += tet_volume(mesh, t);
    }
    const std::vector<Face> boundary = boundary_of(mesh);
    std::vector<std::set<std::int32_t>> faces;
    std::map<std::pair<std::int32_t, std::int32_t>, int> balance;
    for (const Face& face : boundary) {
      faces.emplace_back(face.begin(), face.end());
      enclosed += node(mesh, face[0]).dot(node(mesh, face[1]).cross(node(mesh, face[2]))) / 6;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(face[k], face[(k + 1) % 3]);
        balance[{low, high}] += face[k] == low ? 1 : -1;
      }
    }
    EXPECT_EQ(faces, brute_boundary(mesh));
    EXPECT_NEAR(enclosed, volume, 1e-12);
    for (const auto& [edge, sum] : balance) EXPECT_EQ(sum, 0);
  }
}

// Of a whole grid every edge of the boundary is once there in each direction; a random part may touch itself at an edge.
TEST(TetTopology, EachEdgeOfASolidsBoundaryStandsTwiceInOppositeDirections) {
  std::mt19937 random(2);
  TetMesh mesh = random_mesh(random, true);
  orient_tets(mesh, "mesh");
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed;
  for (const Face& face : boundary_of(mesh))
    for (std::size_t k = 0; k < 3; ++k) ++directed[{face[k], face[(k + 1) % 3]}];
  EXPECT_EQ(directed.size(), 6u * 9 * 2 * 3);
  for (const auto& [edge, times] : directed) {
    EXPECT_EQ(times, 1);
    EXPECT_EQ(directed.count({edge.second, edge.first}), 1u);
  }
}

TEST(TetTopology, InvertedTetsAreTurnedAndCounted) {
  std::mt19937 random(3);
  TetMesh mesh = random_mesh(random);
  std::int64_t inverted = 0;
  for (const Tet& tet : mesh.tets) inverted += determinant(mesh, tet) < 0;
  const TetMesh before = mesh;
  EXPECT_GT(inverted, 0);
  EXPECT_EQ(orient_tets(mesh, "mesh"), inverted);
  EXPECT_EQ(orient_tets(mesh, "mesh"), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    EXPECT_GT(determinant(mesh, mesh.tets[t]), 0);
    EXPECT_TRUE(std::is_permutation(mesh.tets[t].begin(), mesh.tets[t].end(), before.tets[t].begin()));
  }
}

TEST(TetTopology, UnusedNodesAreDroppedInOrder) {
  TetMesh mesh{{{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {8, 8, 8}, {0, 1, 0}, {0, 0, 1}, {7, 7, 7}}, {{1, 2, 4, 5}}};
  EXPECT_EQ(drop_unused_nodes(mesh), 3);
  EXPECT_EQ(mesh.nodes, corner.nodes);
  EXPECT_EQ(mesh.tets, corner.tets);
  EXPECT_EQ(drop_unused_nodes(mesh), 0);
}

std::string tet_fault(TetMesh mesh, bool oriented = true) {
  try {
    if (!oriented) orient_tets(mesh, "mesh");
    check_tets(mesh, "mesh");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TetMesh with_tets(const std::vector<Tet>& tets) { return {pair.nodes, tets}; }

TEST(CheckTets, EachFaultHasItsMessage) {
  EXPECT_EQ(tet_fault(corner), "");
  EXPECT_EQ(tet_fault(pair), "");
  for (const bool oriented : {true, false}) {
    EXPECT_EQ(tet_fault(with_tets({{0, 1, 2, 3}, {0, 1, 2, 5}}), oriented),
              "mesh: found tet 1 with node 5, expected nodes in [0, 5)");
    EXPECT_EQ(tet_fault(with_tets({{0, 1, 2, -1}}), oriented), "mesh: found tet 0 with node -1, expected nodes in [0, 5)");
  }
  EXPECT_EQ(tet_fault(with_tets({{3, 1, 2, 3}})), "mesh: found tet 0 with node 3 twice, expected four different nodes");
  EXPECT_EQ(tet_fault(with_tets({{0, 1, 2, 3}, {0, 2, 1, 4}, {1, 2, 0, 3}})),
            "mesh: found tets 0 and 2 with the same nodes, expected each tet once");
  EXPECT_EQ(tet_fault(with_tets({{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 2, 1, 3}})),
            "mesh: found tets 0 and 2 with the same nodes, expected each tet once");
  EXPECT_EQ(tet_fault(with_tets({{0, 2, 1, 3}})),
            "mesh: found tet 0 turned inside out, expected a volume of 1e-12 of its longest edge cubed");
}

TEST(CheckTets, FacesOfThreeTetsAndNeighboursOnOneSide) {
  TetMesh mesh = pair;
  mesh.nodes.push_back({0.2, 0.2, 2});
  mesh.tets.push_back({0, 1, 2, 5});
  EXPECT_EQ(tet_fault(mesh), "mesh: found tets 0, 1 and 2 at the face of nodes 0, 1 and 2, expected at most two tets at a face");
  mesh.tets.erase(mesh.tets.begin() + 1);
  EXPECT_EQ(tet_fault(mesh),
            "mesh: found tets 0 and 1 on the same side of the face of nodes 0, 1 and 2, expected neighbours on opposite sides");
}

TEST(CheckTets, VolumesCountByTheLongestEdge) {
  const std::string message = "mesh: found tet 0 without volume, expected a volume of 1e-12 of its longest edge cubed";
  for (const double size : {1e-9, 1.0, 1e9}) {
    TetMesh mesh = corner;
    for (Vec3& x : mesh.nodes) x *= size;
    const double longest = std::sqrt(2.0) * size, least = 6 * 1e-12 * longest * longest * longest / (size * size);
    mesh.nodes[3].z() = 1.01 * least;
    EXPECT_EQ(tet_fault(mesh), "");
    for (const double height : {0.99 * least, 0.0, -0.99 * least}) {
      mesh.nodes[3].z() = height;
      EXPECT_EQ(tet_fault(mesh), message);
    }
    mesh.nodes[3].z() = -1.01 * least;
    EXPECT_EQ(tet_fault(mesh), "mesh: found tet 0 turned inside out, expected a volume of 1e-12 of its longest edge cubed");
  }
  TetMesh point = corner;
  for (Vec3& x : point.nodes) x.setOnes();
  EXPECT_EQ(tet_fault(point), message);
}

TEST(CheckTets, PlacesThatAreNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    TetMesh mesh = corner;
    mesh.nodes[2].y() = bad;
    EXPECT_EQ(tet_fault(mesh), "mesh: found node 2 at a place that isn't finite, expected finite coordinates");
  }
}

TEST(ReadTetMesh, PicksTheFormatByTheNamesEnd) {
  const TetMesh mesh = read_tet_mesh(std::string(UNIBODY_SOURCE_DIR) + "/tests/data/gmsh_41.msh", 0).mesh;
  EXPECT_EQ(mesh.nodes.size(), 13u);
  EXPECT_EQ(mesh.tets.size(), 16u);
  double volume = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) volume += tet_volume(mesh, t);
  EXPECT_NEAR(volume, 1.0 / 6, 1e-15);
  try {
    read_tet_mesh("mesh.stl", 0);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "mesh.stl: found a mesh of tetrahedra of unknown format, expected a file .msh (Gmsh) or .vtu (VTK)");
  }
}

}  // namespace
}  // namespace unibody::tet_topology_test
