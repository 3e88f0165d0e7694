#include "partition/migrate_joints.hpp"

#include <algorithm>

#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_joints = 171;

}  // namespace

std::vector<std::vector<JointRecord>> joint_records(const World& world, std::span<const Joint> joints, const JointList& list,
                                                    std::span<const JointImpulses> impulses, std::span<const int> home,
                                                    int ranks) {
  std::vector<std::vector<JointRecord>> records(static_cast<std::size_t>(ranks));
  for (std::size_t i = 0; i < list.size() && i < impulses.size(); ++i) {
    int sent = -1;
    for (const Id id : joints[static_cast<std::size_t>(list[i])].ids) {
      const Slot slot = id < 0 ? -1 : world.find(id);
      if (slot < 0 || !world.is_home(slot)) continue;
      const int rank = home[static_cast<std::size_t>(slot)];
      if (rank != sent) records[static_cast<std::size_t>(rank)].push_back({list[i], impulses[i]});
      sent = rank;
    }
  }
  return records;
}

std::vector<JointImpulses> take_joint_records(MPI_Comm comm, const JointList& list,
                                              const std::vector<std::vector<JointRecord>>& records) {
  std::vector<JointImpulses> result(list.size());
  for (const auto& from : exchange_all(comm, records, tag_joints))
    for (const JointRecord& record : from) {
      const auto at = std::lower_bound(list.begin(), list.end(), record.number);
      if (at != list.end() && *at == record.number) result[static_cast<std::size_t>(at - list.begin())] = record.impulses;
    }
  return result;
}

}  // namespace unibody
