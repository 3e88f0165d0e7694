#include "partition/migrate_constraints.hpp"

#include <algorithm>

#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_records = 151;  // and one more for each type

}  // namespace

ConstraintRecords constraint_records(const World& world, const ConstraintSet& constraints,
                                     const ConstraintMultipliers& multipliers, std::span<const int> home, int ranks) {
  ConstraintRecords records;
  for_each_type(constraints, [&](auto type, const auto& list) {
    auto& to = std::get<type.value>(records);
    to.resize(static_cast<std::size_t>(ranks));
    const auto& old = std::get<type.value>(multipliers);
    if (old.size() != list.size()) return;  // no step yet
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::array<int, std::tuple_size_v<decltype(list[i].ids)>> sent;
      std::size_t n = 0;
      for (const Id id : list[i].ids) {
        const Slot slot = world.find(id);
        if (slot < 0 || !world.is_home(slot)) continue;
        const int rank = home[static_cast<std::size_t>(slot)];
        if (std::find(sent.begin(), sent.begin() + static_cast<std::ptrdiff_t>(n), rank) !=
            sent.begin() + static_cast<std::ptrdiff_t>(n))
          continue;
        sent[n++] = rank;
        to[static_cast<std::size_t>(rank)].push_back({list[i].ids, old[i]});
      }
    }
  });
  return records;
}

ConstraintMultipliers take_constraint_records(MPI_Comm comm, const ConstraintSet& constraints, ConstraintRecords records) {
  ConstraintMultipliers result;
  for_each_type(constraints, [&](auto type, const auto& list) {
    const auto in = exchange_all(comm, std::get<type.value>(records), tag_records + static_cast<int>(type.value));
    auto all = in[0];
    for (std::size_t r = 1; r < in.size(); ++r) all.insert(all.end(), in[r].begin(), in[r].end());
    const auto before = [](const auto& a, const auto& b) { return a.ids < b.ids; };
    std::sort(all.begin(), all.end(), before);
    auto& to = std::get<type.value>(result);
    to.assign(list.size(), {});
    for (std::size_t i = 0; i < list.size(); ++i) {
      const auto at = std::lower_bound(all.begin(), all.end(), list[i], before);
      if (at != all.end() && at->ids == list[i].ids) to[i] = at->multipliers;
    }
  });
  return result;
}

std::vector<Id> partners(const World& world, const ConstraintSet& constraints) {
  std::vector<Id> wanted;
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list)
      for (const Id id : c.ids)
        if (world.find(id) < 0) wanted.push_back(id);
  });
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted;
}

}  // namespace unibody
