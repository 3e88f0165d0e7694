// All that the next step depends on beside the bodies' states: one value, which is copied to take a step again, written to the
// checkpoint and sent along when bodies move to another rank.
#pragma once

#include <vector>

#include "core/types.hpp"
#include "solve/batches.hpp"

namespace unibody {

// The multipliers of the last step, of each batch; of the contacts those from which the next velocity stage starts.
struct History : BatchHistories {
  const Multipliers& contacts() const { return of<ContactBatch>(); }
  Multipliers& contacts() { return of<ContactBatch>(); }
  const std::vector<JointImpulses>& joints() const { return of<JointBatch>(); }
  std::vector<JointImpulses>& joints() { return of<JointBatch>(); }
};

// What a step starts from, for it to be taken again in another way.
struct StepOrigin {
  History history;
  std::vector<Vec3> velocity;  // m/s, of each slot
};

}  // namespace unibody
