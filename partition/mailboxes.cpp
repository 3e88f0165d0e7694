#include "partition/mailboxes.hpp"

#include <sched.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <numeric>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr int spins_before_yielding = 200;  // some microseconds: what two ranks of equal work wait for each other

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

// Where there are more ranks than cores who waits must make room for whom it waits for; and MPI, whose messages to other nodes
// may need this rank to go on, gets its turn.
void wait_until(const std::atomic<std::uint64_t>& counter, std::uint64_t wanted, MPI_Comm comm) {
  for (int spins = 0; counter.load(std::memory_order_acquire) < wanted; ++spins) {
    if (spins < spins_before_yielding) {
      pause();
      continue;
    }
    int found = 0;
    check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm, &found, MPI_STATUS_IGNORE));
    sched_yield();
  }
}

bool all_of(MPI_Comm comm, bool here) {
  int all = here;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_LAND, comm));
  return all != 0;
}

}  // namespace

Mailboxes::Mailboxes(MPI_Comm comm, std::size_t most, MPI_Comm node) : comm_(comm) {
  int size = 1;
  check_mpi(MPI_Comm_size(comm, &size));
  box_of_.assign(static_cast<std::size_t>(size), -1);
  if (size == 1 || most == 0) return;
  MPI_Comm sharing = MPI_COMM_NULL;
  if (node == MPI_COMM_NULL)
    check_mpi(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &sharing));
  else
    check_mpi(MPI_Comm_dup(node, &sharing));
  check_mpi(MPI_Comm_set_errhandler(sharing, MPI_ERRORS_RETURN));
  share(sharing, most);
  check_mpi(MPI_Comm_free(&sharing));
  reaches_all_ = all_of(comm, pairs_.size() == static_cast<std::size_t>(size));
}

// Where an error ends this rank the others may never come here.
Mailboxes::~Mailboxes() {
  if (window_ == MPI_WIN_NULL || std::uncaught_exceptions() > 0) return;
  check_mpi(MPI_Win_unlock_all(window_));
  check_mpi(MPI_Win_free(&window_));
}

// Each rank of the node owns the boxes of what is sent to it, one for each of them, and finds those of the others.
void Mailboxes::share(MPI_Comm node, std::size_t most) {
  int ranks = 1, here = 0;
  check_mpi(MPI_Comm_size(node, &ranks)), check_mpi(MPI_Comm_rank(node, &here));
  const auto n = static_cast<std::size_t>(ranks);
  const std::size_t room = most_memory / (n * n), letters = room > sizeof(Box) ? (room - sizeof(Box)) / 2 : 0;
  most = std::min((most + 63) / 64, letters / 64) * 64;
  if (n == 1 || most == 0) return;
  const std::size_t box = sizeof(Box) + 2 * most;
  std::byte* own = nullptr;
  const bool allocated = MPI_Win_allocate_shared(static_cast<MPI_Aint>(n * box + alignof(Box)), 1, MPI_INFO_NULL, node, &own,
                                                 &window_) == MPI_SUCCESS;
  if (!all_of(node, allocated)) {
    window_ = MPI_WIN_NULL;  // to free it would need the ranks that have none
    return;
  }
  check_mpi(MPI_Win_lock_all(MPI_MODE_NOCHECK, window_));
  const auto boxes_of = [&](int rank) {
    MPI_Aint size = 0;
    int unit = 0;
    void* begin = nullptr;
    check_mpi(MPI_Win_shared_query(window_, rank, &size, &unit, &begin));
    auto room_left = static_cast<std::size_t>(size);
    return static_cast<std::byte*>(std::align(alignof(Box), n * box, begin, room_left));
  };
  std::byte* const incoming = boxes_of(here);
  for (std::size_t i = 0; i < n; ++i) new (incoming + i * box) Box{};
  check_mpi(MPI_Barrier(node));
  for (int rank = 0; rank < ranks; ++rank) {
    const auto at = [&](std::byte* boxes, int from) {
      return reinterpret_cast<Box*>(boxes + static_cast<std::size_t>(from) * box);
    };
    pairs_.push_back({at(boxes_of(rank), here), at(incoming, rank), 0, 0});
  }
  most_ = most;

  MPI_Group all = MPI_GROUP_NULL, those = MPI_GROUP_NULL;
  check_mpi(MPI_Comm_group(comm_, &all)), check_mpi(MPI_Comm_group(node, &those));
  std::vector<int> of_node(n), of_comm(n);
  std::iota(of_node.begin(), of_node.end(), 0);
  check_mpi(MPI_Group_translate_ranks(those, ranks, of_node.data(), all, of_comm.data()));
  check_mpi(MPI_Group_free(&all)), check_mpi(MPI_Group_free(&those));
  for (std::size_t i = 0; i < n; ++i) box_of_[static_cast<std::size_t>(of_comm[i])] = static_cast<int>(i);
}

std::byte* Mailboxes::letter(int rank) {
  const Pair& pair = pairs_[static_cast<std::size_t>(box_of_[static_cast<std::size_t>(rank)])];
  return pair.to->letter(pair.sent, most_);
}

void Mailboxes::send(int rank) {
  Pair& pair = pairs_[static_cast<std::size_t>(box_of_[static_cast<std::size_t>(rank)])];
  pair.to->sent.store(++pair.sent, std::memory_order_release);
}

const std::byte* Mailboxes::receive(int rank) {
  Pair& pair = pairs_[static_cast<std::size_t>(box_of_[static_cast<std::size_t>(rank)])];
  wait_until(pair.from->sent, pair.received + 1, comm_);
  return pair.from->letter(pair.received++, most_);
}

}  // namespace unibody
