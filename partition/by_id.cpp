#include "partition/by_id.hpp"

#include <map>

#include "core/checked.hpp"
#include "core/errors.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_rows = 161;

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
  std::map<int, std::size_t> count;
  for (const int rank : target) ++count[rank];
  std::vector<std::byte> sorted(target.size() * size), received;
  std::vector<SentRecords> to;
  std::map<int, std::byte*> next;
  for (std::byte* first = sorted.data(); const auto& [rank, n] : count) {
    to.push_back({rank, first, n});
    next[rank] = first;
    first += n * size;
  }
  for (std::size_t k = 0; k < target.size(); ++k) {
    std::byte*& place = next[target[k]];
    std::memcpy(place, records + k * size, size);
    place += size;
  }
  ListsByRank<std::byte> from;
  exchange_records(comm, to, size, tag_rows, [&](int rank, std::size_t n) -> void* {
    from[rank].resize(n * size);
    return from[rank].data();
  });
  for (auto& [rank, bytes] : from) {
    received.insert(received.end(), bytes.begin(), bytes.end());
    bytes = {};
  }
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
