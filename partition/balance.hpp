// Balance: decides when bodies change their home, by what the ranks had to do.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

class Balance {
 public:
  // seed: homes by a hash of the id instead of METIS. rebalance: whether homes ever change after the start.
  Balance(MPI_Comm comm, std::optional<std::uint64_t> seed, bool rebalance) : comm_(comm), seed_(seed), rebalance_(rebalance) {}

  // Collective. New homes of this rank's home bodies; before the first step contacts are empty and all bodies cost the same.
  std::vector<int> homes(const World& world, const Contacts& contacts) const;

  // Collective. Largest work of a rank over the mean, 1 when even; work is counted (points evaluated, bodies moved), not timed,
  // so that the report is the same on each run.
  double imbalance(const World& world, const Contacts& contacts);

  // Whether homes() is worth its price now: imbalance or the number of guests has passed its bound since the last change.
  // Call after imbalance().
  bool due() const;
  void changed() { fresh_ = true; }

 private:
  MPI_Comm comm_;
  std::optional<std::uint64_t> seed_;
  bool rebalance_;
  bool fresh_ = true;  // homes have changed since the last look
  double imbalance_ = 1, guest_share_ = 0, imbalance_then_ = 1, guest_share_then_ = 0;
};

}  // namespace unibody
