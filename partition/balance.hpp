// Balance: decides when bodies change their home, by what the ranks had to do.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "partition/partition.hpp"
#include "partition/work.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

class Balance {
 public:
  // seed: homes by a hash of the id instead of METIS. rebalance: whether homes ever change after the start.
  // groups: the flexible bodies of the scene, whose nodes go by patches.
  Balance(MPI_Comm comm, std::optional<std::uint64_t> seed, bool rebalance, std::span<const ConstraintGroup> groups = {})
      : comm_(comm), seed_(seed), rebalance_(rebalance), groups_(groups) {}

  // Collective. New homes of this rank's home bodies, by the work of each (work.hpp); before the first step contacts are empty.
  std::vector<int> homes(const StepParts& parts) const;

  // Collective. Largest work of a rank over the mean, 1 when even; work is counted, not timed, so that the report is the same on
  // each run.
  double imbalance(const StepParts& parts);

  // Whether homes() is worth its price now: imbalance or the number of guests has passed its bound since the last change.
  // Call after imbalance().
  bool due() const;
  void changed() { fresh_ = true; }

 private:
  Patch patch_of(Id id) const;
  std::vector<PatchLink> links(const ConstraintSet& constraints) const;
  static std::vector<PlaceLink> ties(const StepParts& parts);

  MPI_Comm comm_;
  std::optional<std::uint64_t> seed_;
  bool rebalance_;
  std::span<const ConstraintGroup> groups_;
  bool fresh_ = true;  // homes have changed since the last look
  double imbalance_ = 1, guest_share_ = 0, imbalance_then_ = 1, guest_share_then_ = 0;
};

}  // namespace unibody
