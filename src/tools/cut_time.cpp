// How long one rank takes to cut a group of cells into parts:
//   cut_time CELLS_A_SIDE PARTS
// prints the seconds for a cube of cells whose weights differ by a tenth.
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "partition/cell_graph.hpp"

int main(int argc, char** argv) {
  const int side = argc > 2 ? std::atoi(argv[1]) : 0, parts = argc > 2 ? std::atoi(argv[2]) : 0;
  if (side < 1 || side > 1000 || parts < 1) {
    std::fprintf(stderr, "usage: cut_time CELLS_A_SIDE PARTS\n");
    return 2;
  }
  if (MPI_Init(&argc, &argv) != MPI_SUCCESS) return 3;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> weight(950, 1050);
  std::vector<unibody::Cell> cells;
  for (int i = 0; i < side * side * side; ++i) cells.push_back({i % side, i / side % side, i / side / side, weight(random), 0});
  cells = unibody::merge(std::move(cells));
  const double start = MPI_Wtime();
  unibody::cut_cells(cells, {}, parts, 0);
  std::printf("%.3f\n", MPI_Wtime() - start);
  return MPI_Finalize() == MPI_SUCCESS ? 0 : 3;
}
