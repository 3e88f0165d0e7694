// Recursive coordinate bisection: planes across the longest side of what is left cut weighted cells of space into parts. Always
// balanced to within a cell, whatever the weights; blind to what ties cells together.
//
// The cells may be spread over ranks, of which none ever holds them all: each cut is found by the weights of the stretches of an
// axis where it may lie, summed over the ranks. All cuts of a level are sought at once.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace unibody {

class Bisection {
 public:
  using Place = std::array<std::int32_t, 3>;  // of a cell

  // Collective. cells: this rank's; the same cell may be on several ranks. weights: >= 0, of each. shares: > 0, the same on every
  // rank; part p is to have shares[p] of their sum.
  Bisection(MPI_Comm comm, std::span<const Place> cells, std::span<const std::int64_t> weights, std::span<const int> shares);

  // The part where a cell lies, in [0, number of shares); of any place, also one without a cell.
  int part_of(const Place& cell) const;

 private:
  // Along an axis, then the two others: so that a cut divides the cells of one plane too.
  __extension__ using Key = unsigned __int128;
  struct Weighed {
    Key key;
    std::int64_t weight;
  };
  struct Node {
    int first_part, parts;
    std::vector<std::size_t> cells{};  // this rank's
    Place low{}, high{};
    int axis = 0, bits = 1;  // of a coordinate
    Key cut = 0;             // cells at or behind it are of the second child
    std::size_t children = 0;
    std::int64_t target = 0, before = 0, within = 0;  // weights: where to cut; before the stretch where the cut lies; within it
    std::vector<Weighed> order{};                     // of the cells, by key
    std::vector<std::int64_t> sum{};                  // of the weights before each
  };

  static Key key_of(const Node& node, const Place& cell);
  static std::int64_t weight_before(const Node& node, Key key);
  void find_sides(MPI_Comm comm, std::span<Node> level, std::span<const Place> cells);
  void find_cuts(MPI_Comm comm, std::span<Node> level, std::span<const Place> cells, std::span<const std::int64_t> weights,
                 std::span<const int> shares);
  void refine(MPI_Comm comm, std::span<Node> level, int bits, std::size_t stretches);

  std::vector<Node> nodes_;  // level by level
};

}  // namespace unibody
