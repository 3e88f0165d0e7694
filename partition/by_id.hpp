// Order by body id: each rank gets a contiguous block of ids, so that files and checkpoints are written without any rank
// holding the whole scene. What is home anywhere travels; statics, replicated, are filled in by the owner of their block.
#pragma once

#include <mpi.h>

#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "core/checked.hpp"
#include "world/world.hpp"

namespace unibody {

// Ids [0, count) cut into one block a rank, as even as can be; blocks are empty when there are more ranks than bodies.
struct IdBlocks {
  Id count = 0;
  int ranks = 1;

  Id first(int rank) const { return count / ranks * rank + std::min<Id>(rank, count % ranks); }
  Id size(int rank) const { return first(rank + 1) - first(rank); }
  int owner(Id id) const {
    const Id big = count / ranks + 1, bigs = count % ranks;  // the first `bigs` blocks hold one more
    return static_cast<int>(id < big * bigs ? id / big : bigs + (id - big * bigs) / (big - 1));
  }
};
IdBlocks id_blocks(MPI_Comm comm, Id count);

// Sends record k, of `size` bytes, to rank target[k]; returns what arrived, in order of sender, then of place at the sender.
// Collective. The counts of a pair of ranks fit an int up to 2^31 records.
std::vector<std::byte> exchange_bytes(MPI_Comm comm, std::span<const int> target, const std::byte* records, std::size_t size);

template <class Record>
std::vector<Record> exchange(MPI_Comm comm, std::span<const int> target, std::span<const Record> records) {
  static_assert(std::is_trivially_copyable_v<Record>);
  const auto bytes = exchange_bytes(comm, target, reinterpret_cast<const std::byte*>(records.data()), sizeof(Record));
  std::vector<Record> received(bytes.size() / sizeof(Record));
  if (!bytes.empty()) std::memcpy(received.data(), bytes.data(), bytes.size());
  return received;
}

// Where this rank's rows stand in the table of all, and how many there are. Throws RunError on every rank when a body has two
// homes. Collective.
void place_rows(MPI_Comm comm, const IdBlocks& blocks, bool twice, Id rows_here, Id& first, Id& total);

// Throws RunError on every rank when rows_found differs from the block's size anywhere: a body is missing.
void check_block_complete(MPI_Comm comm, const IdBlocks& blocks, Id rows_found);

// Rows of bodies in ascending order of id: this rank's share of a table.
template <class Record>
struct RowsById {
  std::vector<Id> ids;
  std::vector<Record> rows;
  Id first = 0, total = 0;  // the place of the first row in the table; rows of the whole table
};

// record(slot) of every body of the world, in order of id; a rank has those of its block of `count` ids. Throws RunError on every
// rank where a body has two homes. Collective.
template <class RecordOf>
auto present_by_id(MPI_Comm comm, const World& world, Id count, RecordOf record) {
  using Record = decltype(record(std::size_t{}));
  struct Row {
    Id id;
    Record record;
  };
  const IdBlocks blocks = id_blocks(comm, count);
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::vector<int> target(world.homes);
  std::vector<Row> mine(world.homes);
  for (std::size_t slot = 0; slot < world.homes; ++slot) {
    target[slot] = blocks.owner(world.id[slot]);
    mine[slot] = {world.id[slot], record(slot)};
  }
  const auto received = exchange<Row>(comm, target, mine);
  const Id first = blocks.first(rank);
  std::vector<Record> rows(static_cast<std::size_t>(blocks.size(rank)));
  std::vector<bool> seen(rows.size());
  bool twice = false;
  const auto put = [&](Id id, const Record& value) {
    const auto row = static_cast<std::size_t>(id - first);
    twice = twice || seen[row];
    rows[row] = value, seen[row] = true;
  };
  for (const Row& row : received) put(row.id, row.record);
  for (std::size_t slot = world.first_static(); slot < world.size(); ++slot)
    if (blocks.owner(world.id[slot]) == rank) put(world.id[slot], record(slot));
  RowsById<Record> result;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!seen[k]) continue;
    result.ids.push_back(first + static_cast<Id>(k));
    result.rows.push_back(rows[k]);
  }
  place_rows(comm, blocks, twice, static_cast<Id>(result.rows.size()), result.first, result.total);
  return result;
}

// The same where all `count` bodies are there. Throws RunError on every rank where one is missing.
template <class RecordOf>
auto rows_by_id(MPI_Comm comm, const World& world, Id count, RecordOf record) {
  auto present = present_by_id(comm, world, count, record);
  check_block_complete(comm, id_blocks(comm, count), static_cast<Id>(present.rows.size()));
  return std::move(present.rows);
}

}  // namespace unibody
