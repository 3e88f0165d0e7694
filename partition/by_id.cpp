#include "partition/by_id.hpp"

#include <numeric>

#include "core/checked.hpp"
#include "core/errors.hpp"

namespace unibody {

namespace {

int rank_in(MPI_Comm comm) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  return rank;
}

}  // namespace

IdBlocks id_blocks(MPI_Comm comm, Id count) {
  IdBlocks blocks{count, 1};
  check_mpi(MPI_Comm_size(comm, &blocks.ranks));
  return blocks;
}

std::vector<std::byte> exchange_bytes(MPI_Comm comm, std::span<const int> target, const std::byte* records, std::size_t size) {
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  const auto n = static_cast<std::size_t>(ranks);
  std::vector<int> send(n), receive(n), send_at(n + 1), receive_at(n + 1);
  for (int t : target) ++send[static_cast<std::size_t>(t)];
  check_mpi(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm));
  const auto all_of = [](const std::vector<int>& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::size_t{0},
                           [](std::size_t sum, int count) { return sum + static_cast<std::size_t>(count); });
  };
  for (const auto* counts : {&send, &receive}) static_cast<void>(mpi_count(all_of(*counts)));  // so that the places fit an int
  std::partial_sum(send.begin(), send.end(), send_at.begin() + 1);
  std::partial_sum(receive.begin(), receive.end(), receive_at.begin() + 1);

  std::vector<std::byte> sorted(target.size() * size), received(static_cast<std::size_t>(receive_at[n]) * size);
  auto place = send_at;
  for (std::size_t k = 0; k < target.size(); ++k) {
    const auto at = static_cast<std::size_t>(place[static_cast<std::size_t>(target[k])]++);
    std::memcpy(sorted.data() + at * size, records + k * size, size);
  }
  MPI_Datatype type;  // counts and places are in records, not bytes, so that they fit an int
  check_mpi(MPI_Type_contiguous(mpi_count(size), MPI_BYTE, &type));
  check_mpi(MPI_Type_commit(&type));
  check_mpi(MPI_Alltoallv(sorted.data(), send.data(), send_at.data(), type, received.data(), receive.data(), receive_at.data(),
                          type, comm));
  check_mpi(MPI_Type_free(&type));
  return received;
}

void place_rows(MPI_Comm comm, const IdBlocks& blocks, bool twice, Id rows_here, Id& first, Id& total) {
  check_block_complete(comm, blocks, blocks.size(rank_in(comm)) + (twice ? 1 : 0));
  Id last = 0;
  check_mpi(MPI_Scan(&rows_here, &last, 1, MPI_INT64_T, MPI_SUM, comm));
  check_mpi(MPI_Allreduce(&rows_here, &total, 1, MPI_INT64_T, MPI_SUM, comm));
  first = last - rows_here;
}

void check_block_complete(MPI_Comm comm, const IdBlocks& blocks, Id rows_found) {
  const int rank = rank_in(comm);
  int bad = rows_found == blocks.size(rank) ? blocks.ranks : rank;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_INT, MPI_MIN, comm));
  if (bad == blocks.ranks) return;
  throw RunError("bodies " + std::to_string(blocks.first(bad)) + " to " + std::to_string(blocks.first(bad + 1) - 1) +
                 ": one is home on no rank or on two");
}

}  // namespace unibody
