// The sums of a sweep over all ranks: started after the sweep, awaited when the next one needs them.
//
// A few ranks tell each other theirs, through mailboxes where all of them are on one node: that takes one message's time where
// MPI's own reductions take several. Whatever the order, the sums are the same.
#pragma once

#include <mpi.h>

#include <array>

#include "constraints/sweep.hpp"
#include "partition/exchange.hpp"

namespace unibody {

class SumReduction {
 public:
  explicit SumReduction(const Exchange& exchange);
  ~SumReduction();
  SumReduction(const SumReduction&) = delete;
  SumReduction& operator=(const SumReduction&) = delete;

  // start() and wait() are collective: all ranks call them in the same order. SweepSums::unit must be the same on all ranks.
  void start(const SweepSums& sums);
  const SweepSums& wait();

 private:
  enum class Way { mail, messages, reduction };
  static constexpr int most_by_mail = 16, most_by_messages = 4, tag_sums = 191;

  template <typename F>
  void for_each_other(F&& f) {
    for (int other = 0; other < ranks_; ++other)
      if (other != rank_) f(other, told_[static_cast<std::size_t>(other)]);
  }

  MPI_Comm comm_;
  Mailboxes& boxes_;
  Way way_ = Way::messages;
  int ranks_ = 1, rank_ = 0;
  bool under_way_ = false;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
  std::array<MPI_Request, 2 * (most_by_messages - 1)> requests_;
  std::array<SweepSums, most_by_mail> told_;  // of each other rank
  SweepSums own_, sums_;
};

// J, the unit of the sums after a first sweep: 2^-30 of its largest term. Later terms are smaller as a rule; larger ones are
// clamped.
double unit_for(double largest);

}  // namespace unibody
