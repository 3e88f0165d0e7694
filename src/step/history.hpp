// All that the next step depends on beside the bodies' states: one value, which is copied to take a step again, written to the
// checkpoint and sent along when bodies move to another rank.
#pragma once

#include <cstdint>
#include <vector>

#include "core/types.hpp"
#include "joints/strength.hpp"
#include "solve/batches.hpp"

namespace unibody {

// Into how many parts a run with an accuracy divides its steps, for contacts that a step as long as the scene's would let go too
// deep (division.hpp).
struct Fineness {
  int parts = 1;
  int calm = 0, deep = 0;  // steps one after the other that started with contacts less deep than that is worth, or too deep
};

// How far a step is from the converged one, over its natural residual, as the sampled steps of a run with an accuracy tell: the
// ratio that is reckoned with.
struct ErrorRatio {
  double ratio = 0;        // 0: of no step known
  std::int64_t next = -1;  // the step, since time 0, of which the error is to be estimated next; -1: none has been yet
};

// What has come in by an inlet, and what waits for room.
struct InletPast {
  Id drawn = 0;               // bodies below this number have become due
  double drawn_mass = 0;      // kg, of those
  std::vector<Id> waiting{};  // numbers of those that have found no room yet, ascending
  Id placed = 0;
  double placed_mass = 0;  // kg
};

// What has left by an outlet.
struct OutletPast {
  Id removed = 0;
  double removed_mass = 0;  // kg
};

// What has happened in a run of the scene's events, inlets and outlets, each in their order in the scene, and of its joints: the
// same on all ranks.
struct Past {
  std::vector<std::int64_t> events;  // the frame at whose start each took or takes effect, from 1; 0: it has not happened
  std::vector<InletPast> inlets;
  std::vector<OutletPast> outlets;
  std::vector<Break> breaks;  // in the order in which joints broke: by time, then by joint
};

// The multipliers of the last step, of each batch; of the contacts those from which the next velocity stage starts.
struct History : BatchHistories {
  ErrorRatio error_ratio;
  Fineness fineness;
  Past past;
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
