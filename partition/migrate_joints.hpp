// Joints are known to all ranks; only their impulses travel with their bodies.
#pragma once

#include <mpi.h>

#include <span>

#include "joints/joint_set.hpp"

namespace unibody {

struct JointRecord {
  std::int64_t number;  // of the joint
  JointImpulses impulses;
};

// Before the bodies go: what has to be sent, by rank. home: where each home body goes.
std::vector<std::vector<JointRecord>> joint_records(const World& world, std::span<const Joint> joints, const JointList& list,
                                                    std::span<const JointImpulses> impulses, std::span<const int> home,
                                                    int ranks);

// When the bodies are there: the impulses of each joint of the new list, 0 where nothing is known of one. Collective.
std::vector<JointImpulses> take_joint_records(MPI_Comm comm, const JointList& list,
                                              const std::vector<std::vector<JointRecord>>& records);

}  // namespace unibody
