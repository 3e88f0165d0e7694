// Partition: which rank is home to which body.
//
// METIS cuts a small graph whose nodes are cells of space for loose bodies and patches of nodes for cloths, threads and solids
// (cell_graph.hpp), weighted by the counted work of the bodies in them; a body's home is then its cell's part. METIS works on one
// rank and takes seconds for hundreds of thousands of cells or thousands of parts. So where there are more of them, planes first
// cut space into groups of cells (bisection.hpp), each for some neighbouring ranks, and METIS cuts each group on the first of its
// ranks: no rank holds more than the cells of its own bodies and of one group. What ties cells of two groups together is not
// seen.
//
// No result depends on the partition, so it may be as approximate as it likes; the price of cells is a cut one cell rough. Parts
// may be empty: fewer cells than ranks, or no bodies at all, are legal.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "world/world.hpp"

namespace unibody {

// The patch of a flexible body that a node belongs to; group -1: a loose body, which goes with its cell of space.
struct Patch {
  std::int32_t group = -1, number = 0;
  auto operator<=>(const Patch&) const = default;
};

// Constraints between two patches.
struct PatchLink {
  Patch a, b;
  float weight = 0;  // cost of its constraints
};

// Joints between two loose bodies, which may be far apart.
struct PlaceLink {
  Vec3 a, b;         // m
  float weight = 0;  // cost
};

// What METIS is given at once.
struct GroupLimits {
  int parts = 64;
  std::int64_t cells = 1 << 15;
};

// Collective. The home rank of each of this rank's bodies. cost: work a body causes in a step, in any unit.
// cell: m, edge of a cell. patches: of each body; empty: all are loose. Ranks keep as much of what they have as the new parts
// allow.
std::vector<int> partition_bodies(MPI_Comm comm, std::span<const Vec3> positions, std::span<const float> cost, double cell,
                                  std::span<const Patch> patches = {}, std::span<const PatchLink> links = {},
                                  std::span<const PlaceLink> joints = {}, const GroupLimits& limits = {});

// A body's home by a hash of its id: the worst partition there is, for tests.
int random_home(Id id, std::uint64_t seed, int ranks);

}  // namespace unibody
