#include "partition/messages.hpp"

#include <cstring>

namespace unibody {

namespace {

constexpr int odd_tags = 1000;  // beyond those of even exchanges

// Whether this is an odd exchange of the communicator. A rank that has finished an exchange may send for the next one while
// another still receives for this one, but it cannot be two exchanges ahead: they are told apart by being odd or even.
bool is_odd_exchange(MPI_Comm comm) {
  static const int key = [] {
    int made = MPI_KEYVAL_INVALID;
    check_mpi(MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, MPI_COMM_NULL_DELETE_FN, &made, nullptr));
    return made;
  }();
  static char odd;  // the attribute is its address after an odd exchange
  void* last = nullptr;
  int found = 0;
  check_mpi(MPI_Comm_get_attr(comm, key, static_cast<void*>(&last), &found));
  const bool is_odd = found == 0 || last != &odd;
  check_mpi(MPI_Comm_set_attr(comm, key, is_odd ? &odd : nullptr));
  return is_odd;
}

class Arrivals {
 public:
  Arrivals(MPI_Comm comm, int tag, MPI_Datatype type, const std::function<void*(int, std::size_t)>& room)
      : comm_(comm), tag_(tag), type_(type), room_(room) {}

  // Receives what has come, if anything has.
  void look() const {
    int has_come = 0, count = 0;
    MPI_Status status;
    check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, tag_, comm_, &has_come, &status));
    if (has_come == 0) return;
    check_mpi(MPI_Get_count(&status, type_, &count));
    void* const place = room_(status.MPI_SOURCE, static_cast<std::size_t>(count));
    check_mpi(MPI_Recv(place, count, type_, status.MPI_SOURCE, tag_, comm_, MPI_STATUS_IGNORE));
  }

 private:
  MPI_Comm comm_;
  int tag_;
  MPI_Datatype type_;
  const std::function<void*(int, std::size_t)>& room_;
};

}  // namespace

void exchange_records(MPI_Comm comm, std::span<const SentRecords> to, std::size_t size, int tag,
                      const std::function<void*(int rank, std::size_t count)>& room) {
  int rank = 0, ranks = 1;
  check_mpi(MPI_Comm_rank(comm, &rank));
  check_mpi(MPI_Comm_size(comm, &ranks));
  for (const SentRecords& own : to)
    if (own.rank == rank && own.count > 0) std::memcpy(room(rank, own.count), own.first, own.count * size);
  if (ranks == 1) return;
  const int tag_now = tag + (is_odd_exchange(comm) ? odd_tags : 0);
  const RecordType type(size);
  std::vector<MPI_Request> sends;
  for (const SentRecords& sent : to)
    if (sent.rank != rank)  // synchronous: complete when it is being received
      check_mpi(MPI_Issend(sent.first, mpi_count(sent.count), type, sent.rank, tag_now, comm, &sends.emplace_back()));
  const Arrivals arrivals(comm, tag_now, type, room);
  for (int all_sent = 0; all_sent == 0;) {
    arrivals.look();
    check_mpi(MPI_Testall(static_cast<int>(sends.size()), sends.data(), &all_sent, MPI_STATUSES_IGNORE));
  }
  MPI_Request everyone;  // has sent what it had to
  check_mpi(MPI_Ibarrier(comm, &everyone));
  for (int all_done = 0; all_done == 0;) {
    arrivals.look();
    check_mpi(MPI_Test(&everyone, &all_done, MPI_STATUS_IGNORE));
  }
}

}  // namespace unibody
