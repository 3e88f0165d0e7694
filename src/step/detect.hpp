// Before a step: which constraints there are here, where their bodies are, and what touches what.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// All constraints of the bodies that are home here, without history, and what all ranks must agree on about them. The next
// refresh of the halo finds the guests anew. Collective.
void make_constraints(RankState& state);

// Brings the guests up to date with their homes. Collective.
void refresh_guests(RankState& state);

// Lays out the batches that last, and finds the bodies that they share. Needed whenever slots may have moved.
void build_lasting(RankState& state, System& system);

// Finds what touches what, into state.contacts. Returns whether more bodies are at one place than can be there (crowds.hpp), on
// any rank. Collective.
bool find_contacts(RankState& state);

struct CrowdCount {
  std::int64_t bodies = 0, most = 0;  // in crowds; in the largest
  Id one = -1;                        // of those in the largest
};
CrowdCount count_crowds(const RankState& state);  // over all ranks

}  // namespace unibody
