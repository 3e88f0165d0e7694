// Typed point-to-point exchanges of lists whose lengths only the sender knows. Results come back in order of rank, whatever the
// order of arrival.
#pragma once

#include <mpi.h>

#include <span>
#include <type_traits>
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

// Collective: to[r] goes to rank r; the result's r-th list came from it. Only non-empty lists are sent.
template <typename T>
std::vector<std::vector<T>> exchange_all(MPI_Comm comm, const std::vector<std::vector<T>>& to, int tag) {
  static_assert(std::is_trivially_destructible_v<T>);  // plain data; Eigen's fixed sizes are, though not by the letter
  const RecordType type(sizeof(T));
  const std::size_t size = to.size();
  std::vector<int> out(size), in(size);
  for (std::size_t r = 0; r < size; ++r) out[r] = mpi_count(to[r].size());
  check_mpi(MPI_Alltoall(out.data(), 1, MPI_INT, in.data(), 1, MPI_INT, comm));
  std::vector<std::vector<T>> from(size);
  std::vector<MPI_Request> requests;
  for (std::size_t r = 0; r < size; ++r) {
    if (in[r] == 0) continue;
    from[r].resize(static_cast<std::size_t>(in[r]));
    check_mpi(MPI_Irecv(from[r].data(), in[r], type, static_cast<int>(r), tag, comm, &requests.emplace_back()));
  }
  for (std::size_t r = 0; r < size; ++r)
    if (out[r] > 0) check_mpi(MPI_Isend(to[r].data(), out[r], type, static_cast<int>(r), tag, comm, &requests.emplace_back()));
  check_mpi(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  return from;
}

}  // namespace unibody
