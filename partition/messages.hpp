// Exchanges of lists whose lengths only the sender knows. Results come in order of rank, whatever the order of arrival.
#pragma once

#include <mpi.h>

#include <functional>
#include <map>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/checked.hpp"

namespace unibody {

// An MPI type of `size` bytes, so that counts stay counts of records (an int holds 2^31 records, not bytes).
class RecordType {
 public:
  explicit RecordType(std::size_t size) {
    check_mpi(MPI_Type_contiguous(mpi_count(size), MPI_BYTE, &type_));
    check_mpi(MPI_Type_commit(&type_));
  }
  ~RecordType() { check_mpi(MPI_Type_free(&type_)); }
  RecordType(const RecordType&) = delete;
  RecordType& operator=(const RecordType&) = delete;
  operator MPI_Datatype() const { return type_; }

 private:
  MPI_Datatype type_;
};

// Each neighbour sends to and receives from each other: to[i] goes to ranks[i], the result's i-th list came from it.
// Both sides must name each other.
template <typename T>
std::vector<std::vector<T>> exchange_with(MPI_Comm comm, std::span<const int> ranks, const std::vector<std::vector<T>>& to,
                                          int tag) {
  static_assert(std::is_trivially_destructible_v<T>);  // plain data; Eigen's fixed sizes are, though not by the letter
  const RecordType type(sizeof(T));
  std::vector<MPI_Request> sends(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i)
    check_mpi(MPI_Isend(to[i].data(), mpi_count(to[i].size()), type, ranks[i], tag, comm, &sends[i]));
  std::vector<std::vector<T>> from(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    MPI_Status status;
    check_mpi(MPI_Probe(ranks[i], tag, comm, &status));
    int count = 0;
    check_mpi(MPI_Get_count(&status, type, &count));
    from[i].resize(static_cast<std::size_t>(count));
    check_mpi(MPI_Recv(from[i].data(), count, type, ranks[i], tag, comm, MPI_STATUS_IGNORE));
  }
  check_mpi(MPI_Waitall(static_cast<int>(sends.size()), sends.data(), MPI_STATUSES_IGNORE));
  return from;
}

struct SentRecords {
  int rank;
  const void* first;
  std::size_t count;
};

// Collective. Sends records of `size` bytes to ranks that do not know of it: what a rank sends and receives grows with those it
// has to do with, not with all there are (the non-blocking consensus of T. Hoefler, C. Siebert and A. Lumsdaine, Scalable
// communication protocols for dynamic sparse data exchange, PPoPP 2010). room(rank, count) is called once for each rank that
// sends, in any order, and returns where its records go. tag: below 1000.
void exchange_records(MPI_Comm comm, std::span<const SentRecords> to, std::size_t size, int tag,
                      const std::function<void*(int rank, std::size_t count)>& room);

// Only ranks that there is something for, or from, are named.
template <typename T>
using ListsByRank = std::map<int, std::vector<T>>;

// Collective: to[r] goes to rank r; the result's list of r came from it. Empty lists are not sent.
template <typename T>
ListsByRank<T> exchange_lists(MPI_Comm comm, const ListsByRank<T>& to, int tag) {
  static_assert(std::is_trivially_destructible_v<T>);
  std::vector<SentRecords> records;
  for (const auto& [rank, list] : to)
    if (!list.empty()) records.push_back({rank, list.data(), list.size()});
  ListsByRank<T> from;
  exchange_records(comm, records, sizeof(T), tag, [&](int rank, std::size_t count) -> void* {
    auto& list = from[rank];
    list.resize(count);
    return list.data();
  });
  return from;
}

// The same of lists that nobody needs afterwards: what stays on this rank is not copied.
template <typename T>
ListsByRank<T> exchange_lists(MPI_Comm comm, ListsByRank<T>&& to, int tag) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  auto own = to.extract(rank);
  ListsByRank<T> from = exchange_lists(comm, std::as_const(to), tag);
  to.clear();
  if (own && !own.mapped().empty()) from.insert(std::move(own));
  return from;
}

// The lists one after the other, in order of rank.
template <typename T>
std::vector<T> joined(ListsByRank<T> lists) {
  if (lists.empty()) return {};
  std::vector<T> all = std::move(lists.begin()->second);
  std::size_t count = 0;
  for (const auto& [rank, list] : lists) count += list.size();
  all.reserve(all.size() + count);
  for (auto& [rank, list] : lists) {
    all.insert(all.end(), list.begin(), list.end());
    list = {};
  }
  return all;
}

// Collective: the records of every rank, on every rank, in order of rank. For what is rare: where there are any, each rank hears
// how many each has.
template <typename T>
std::vector<T> all_of_ranks(MPI_Comm comm, std::span<const T> here) {
  static_assert(std::is_trivially_destructible_v<T>);
  const int count = mpi_count(here.size());
  std::int64_t total = count;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, comm));
  std::vector<T> all(static_cast<std::size_t>(total));
  if (all.empty()) return all;
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  std::vector<int> counts(static_cast<std::size_t>(ranks)), first(counts);
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  static_cast<void>(mpi_count(all.size()));  // so that the places fit an int
  for (std::size_t r = 1; r < counts.size(); ++r) first[r] = first[r - 1] + counts[r - 1];
  const RecordType type(sizeof(T));
  check_mpi(MPI_Allgatherv(here.data(), count, type, all.data(), counts.data(), first.data(), type, comm));
  return all;
}

}  // namespace unibody
