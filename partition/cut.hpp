// Cut: the bodies that a step's constraints share between ranks, and the one message an iteration that keeps them equal.
//
// A constraint across a cut is known to and evaluated by all its ranks, so each knows without asking which bodies the other
// needs: the lists on the two sides are equal by construction. What travels is a body's velocity, from its home to its guests.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/attachment_batch.hpp"
#include "constraints/system.hpp"
#include "core/phases.hpp"
#include "joints/joint_batch.hpp"
#include "partition/halo.hpp"
#include "partition/mailboxes.hpp"
#include "world/world.hpp"

namespace unibody {

class ConstraintBatches;

class Cut {
 public:
  // Collective. Ranks of one node tell each other by mailboxes what is not longer than a letter (bytes); 0: all by MPI's
  // messages. No result depends on it.
  Cut(const Halo& halo, PhaseClock& clock, std::size_t longest_letter = usual_letter)
      : halo_(halo),
        clock_(clock),
        letters_(halo.comm(), longest_letter),
        sums_(halo.comm(), longest_letter > 0 ? sizeof(SweepSums) : 0) {}
  static constexpr std::size_t usual_letter = 256 << 10;  // what is longer takes its time either way

  // Finds the bodies shared by the constraints other than contacts, and by each of their groups: once, until slots move. Local.
  void set_constraints(const World& world, const ConstraintBatches& constraints);

  // The same of joints, and of their trees, of which each rank has all bodies; by_colour: the number of colours that Gauss-Seidel
  // takes them by, or 0. After set_constraints.
  void set_joints(const World& world, std::span<const Joint> joints, const JointList& list, std::span<const JointSlots> slots,
                  std::int32_t by_colour);

  // Finds the shared bodies of this step's contacts and attachments, and adds those of the other constraints. Local.
  void build(const World& world, const Contacts& contacts, std::span<const AttachedNode> attached = {});

  // Refreshes every shared guest from its home: one message to and from each neighbour.
  void exchange(std::span<SolverBody> bodies) const;
  void exchange(std::span<std::int32_t> values) const;
  void exchange(std::span<double> values) const;

  // The same for the bodies that one group of the other constraints ties.
  void exchange_group(std::size_t group, std::span<SolverBody> bodies) const;

  // The same for the bodies that the joints of one colour tie.
  void exchange_joints(std::size_t colour, std::span<SolverBody> bodies) const;

  // The same for the bodies that the manifolds of one colour touch; colour[m] of every manifold, set before by set_colours.
  void set_colours(std::span<const std::int32_t> colour, std::size_t colours);
  void exchange_colour(std::size_t colour, std::span<SolverBody> bodies) const;

  // Manifolds across the cut, by neighbour; the lists of the two ranks correspond entry by entry.
  struct Neighbour {
    int rank;
    std::vector<std::uint32_t> manifolds;  // ascending
  };
  std::span<const Neighbour> neighbours() const { return neighbours_; }
  bool empty() const { return neighbours_.empty(); }

  MPI_Comm comm() const { return halo_.comm(); }
  Mailboxes& boxes_of_sums() const { return sums_; }  // for a SweepSums to each other rank, and no other messages
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
  // Adds what the ranks of a constraint's bodies have to tell each other.
  void share(const World& world, std::span<const Slot> ends, std::map<int, Traffic>& traffic) const;
  void add_constrained(const std::map<int, Traffic>& more);
  static std::vector<Traffic> sorted(std::map<int, Traffic> traffic);
  void run(std::span<const Traffic> traffic, std::span<SolverBody> bodies) const;
  template <typename T, typename Record>
  void run(std::span<const Traffic> traffic, std::span<T> values) const;

  const Halo& halo_;
  PhaseClock& clock_;
  mutable Mailboxes letters_, sums_;
  std::vector<Neighbour> neighbours_;
  std::map<std::uint32_t, Ends> ends_;
  std::map<int, Traffic> constrained_;  // by rank: what constraints other than contacts share
  std::vector<Traffic> all_;
  std::vector<std::vector<Traffic>> by_colour_, by_group_, by_joint_colour_;
  bool rotates_ = true;                    // else velocities are all that travels
  mutable std::vector<std::byte> buffer_;  // of one exchange: what comes, then what goes, of what no mailbox carries
  mutable std::vector<MPI_Request> requests_;
};

}  // namespace unibody
