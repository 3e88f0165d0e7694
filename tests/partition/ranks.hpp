// This rank and the number of ranks of the test program, and what one of them tells the others.
#pragma once

#include <mpi.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace unibody {

inline int rank_here() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

inline int rank_count() {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

// Waits until all ranks have come here, and sleeps meanwhile. There may be fewer cores than ranks, and a rank that waits in MPI
// keeps a core busy, which the rank that it waits for could use.
inline void sleep_until_all_are_here() {
  MPI_Request all = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &all);
  for (int here = 0; MPI_Test(&all, &here, MPI_STATUS_IGNORE) == MPI_SUCCESS && here == 0;)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

// Calls f on the first rank alone, and returns on all ranks what it gave there.
inline std::vector<std::uint64_t> of_first_rank(const std::function<std::vector<std::uint64_t>()>& f) {
  std::vector<std::uint64_t> values;
  if (rank_here() == 0) values = f();
  sleep_until_all_are_here();
  auto count = static_cast<int>(values.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, MPI_COMM_WORLD);
  values.resize(static_cast<std::size_t>(count));
  MPI_Bcast(values.data(), count, MPI_UINT64_T, 0, MPI_COMM_WORLD);
  return values;
}

}  // namespace unibody
