// Mailboxes: short messages between the ranks of one node, through memory that they share. A solver's iteration waits for one
// from each neighbour, and MPI's own way to the next core takes as long as the links of hundreds of nodes.
//
// Two ranks write to each other in turns: each sends one message and receives one, by this way or by MPI's, before it sends the
// next. A box of two messages is then never full: who sends the second after a message has heard from the other since, and so
// that one has read it.
#pragma once

#include <mpi.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace unibody {

class Mailboxes {
 public:
  // Collective. For messages of up to `most` bytes, less where the node has so many ranks that their boxes would be more than
  // most_memory. There are none for one rank, where `most` is 0, or where the node has no memory to share. `node`: the ranks of
  // `comm` to share memory with; null: those that can.
  Mailboxes(MPI_Comm comm, std::size_t most, MPI_Comm node = MPI_COMM_NULL);
  ~Mailboxes();  // collective
  Mailboxes(const Mailboxes&) = delete;
  Mailboxes& operator=(const Mailboxes&) = delete;

  // Whether messages of so many bytes between that rank and this one go through a box; both find the same.
  bool carry(int rank, std::size_t bytes) const { return bytes <= most_ && box_of_[static_cast<std::size_t>(rank)] >= 0; }
  bool reach_all() const { return reaches_all_; }  // the other ranks of `comm`

  std::byte* letter(int rank);         // where the next message to that rank is to be written: 64-byte aligned
  void send(int rank);                 // what stands there
  const std::byte* receive(int rank);  // waits for the next message from that rank; it stays until the one after it is received

 private:
  static constexpr std::size_t most_memory = 8 << 20;  // bytes a node; pages that no message has touched cost nothing
  struct alignas(64) Box {
    std::atomic<std::uint64_t> sent;
    std::byte* letter(std::uint64_t number, std::size_t most) {
      return reinterpret_cast<std::byte*>(this + 1) + (number % 2) * most;
    }
  };
  struct Pair {
    Box *to = nullptr, *from = nullptr;
    std::uint64_t sent = 0, received = 0;
  };
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);  // else it would not work between processes

  void share(MPI_Comm node, std::size_t most);

  MPI_Comm comm_;
  MPI_Win window_ = MPI_WIN_NULL;
  std::size_t most_ = 0;
  bool reaches_all_ = false;
  std::vector<int> box_of_;  // of each rank of comm_ its place in pairs_; -1: no box
  std::vector<Pair> pairs_;
};

}  // namespace unibody
