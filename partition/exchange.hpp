// Exchange: the bodies that a step's constraints share between ranks, and the one message an iteration that keeps them equal.
//
// A constraint across a cut is known to and evaluated by all its ranks, so each knows without asking which bodies the other
// needs: the lists on the two sides are equal by construction. What travels is a body's velocity, from its home to its guests.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/solver_body.hpp"
#include "constraints/sweep.hpp"
#include "core/phases.hpp"
#include "partition/halo.hpp"
#include "partition/mailboxes.hpp"
#include "world/world.hpp"

namespace unibody {

class Exchange {
 public:
  // Collective. Ranks of one node tell each other by mailboxes what is not longer than a letter (bytes); 0: all by MPI's
  // messages. No result depends on it.
  Exchange(const Halo& halo, PhaseClock& clock, std::size_t longest_letter = usual_letter)
      : halo_(halo),
        clock_(clock),
        letters_(halo.comm(), longest_letter),
        sums_(halo.comm(), longest_letter > 0 ? sizeof(SweepSums) : 0),
        shares_memory_(longest_letter > 0) {}
  static constexpr std::size_t usual_letter = 256 << 10;  // what is longer takes its time either way

  // Calls a function with the colour (-1: none) and the bodies of each constraint of a batch.
  using Stencils = std::function<void(const std::function<void(std::int32_t, std::span<const Slot>)>&)>;

  // Finds the bodies shared by batches whose constraints last until slots move: first start_lasting(), then each batch by its
  // place in the list of batches. by_colour: Gauss-Seidel will refresh them colour by colour. Local.
  void start_lasting() { lasting_.clear(), by_colour_.clear(); }
  void share_lasting(const World& world, std::size_t batch, bool by_colour, const Stencils& stencils);

  // The same of this step's constraints: start_step(), each batch, finish_step(). The neighbours are those of the contacts.
  void start_step(const World& world, const Contacts& contacts);
  void share(const World& world, const Stencils& stencils);
  void finish_step();

  // Refreshes every shared guest from its home: one message to and from each neighbour.
  void refresh(std::span<SolverBody> bodies) const;
  void refresh(std::span<std::int32_t> values) const;
  void refresh(std::span<double> values) const;
  void refresh(std::span<Vec3> values) const;

  // The same for the bodies that one colour of a batch ties.
  void refresh(std::size_t batch, std::size_t colour, std::span<SolverBody> bodies) const;

  // Sets the colours of the contacts, which are the batch of that number: colour[m] is that of the step's manifold m.
  void set_colours(std::size_t batch, std::span<const std::int32_t> colour, std::size_t colours);

  // Manifolds across the cut, by neighbour; the lists of the two ranks correspond entry by entry.
  struct Neighbour {
    int rank;
    std::vector<std::uint32_t> manifolds;  // ascending
  };
  std::span<const Neighbour> neighbours() const { return neighbours_; }

  MPI_Comm comm() const { return halo_.comm(); }
  bool shares_memory() const { return shares_memory_; }  // ranks of one node use mailboxes
  Mailboxes& boxes_of_sums() const { return sums_; }     // for a SweepSums to each other rank, and no other messages
  PhaseClock& clock() const { return clock_; }

  // This rank's and the other rank's body of a manifold across the cut.
  struct Ends {
    Slot home, guest;
  };
  Ends ends(std::uint32_t manifold) const { return ends_.at(manifold); }

 private:
  struct Traffic {
    int rank;
    std::vector<Slot> send, receive;
  };
  using TrafficByRank = std::map<int, Traffic>;
  // Adds what the ranks of a constraint's bodies have to tell each other.
  void share(const World& world, std::span<const Slot> ends, TrafficByRank& traffic) const;
  static void add(const TrafficByRank& more, TrafficByRank& traffic);
  static std::vector<Traffic> sorted(TrafficByRank&& traffic);
  void run(std::span<const Traffic> traffic, std::span<SolverBody> bodies) const;
  template <typename T, typename Record>
  void run(std::span<const Traffic> traffic, std::span<T> values) const;

  const Halo& halo_;
  PhaseClock& clock_;
  mutable Mailboxes letters_, sums_;
  bool shares_memory_;
  std::vector<Neighbour> neighbours_;
  std::map<std::uint32_t, Ends> ends_;
  TrafficByRank lasting_, of_step_;  // what batches share until slots move; and what this step's do, those included
  std::vector<Traffic> all_;
  std::map<std::size_t, std::vector<std::vector<Traffic>>> by_colour_;  // by batch, then colour
  bool rotates_ = true;                                                 // else velocities are all that travels
  mutable std::vector<std::byte> buffer_;  // of one exchange: what comes, then what goes, of what no mailbox carries
  mutable std::vector<MPI_Request> requests_;
};

}  // namespace unibody
