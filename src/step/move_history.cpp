#include "step/move_history.hpp"

#include <algorithm>

namespace unibody {

namespace {

constexpr int tag_records = 151;  // and one more for each batch

// The ranks to which a constraint's bodies go, each once.
std::vector<int> ranks_of(const World& world, std::span<const Id> ids, std::span<const int> home) {
  std::vector<int> ranks;
  for (const Id id : ids) {
    const Slot slot = id < 0 ? -1 : world.find(id);
    if (slot < 0 || !world.is_home(slot)) continue;
    const int rank = home[static_cast<std::size_t>(slot)];
    if (std::find(ranks.begin(), ranks.end(), rank) == ranks.end()) ranks.push_back(rank);
  }
  return ranks;
}

}  // namespace

HistoriesByRank histories_by_rank(const RankState& state, std::span<const int> home) {
  HistoriesByRank records;
  for_each_batch_type([&]<class B>(auto place, std::type_identity<B>) {
    if constexpr (RecordedBatch<B>) {
      auto& to = std::get<decltype(place)::value>(records);
      for_each_record<B>(state.elements(), state.history.of<B>(), [&](const HistoryRecord<B>& record, std::span<const Id> ids) {
        for (const int rank : ranks_of(state.world, ids, home)) to[rank].push_back(record);
      });
    }
  });
  return records;
}

void take_histories(RankState& state, HistoriesByRank records) {
  for_each_batch_type([&]<class B>(auto place, std::type_identity<B>) {
    if constexpr (RecordedBatch<B>) {
      constexpr std::size_t number = decltype(place)::value;
      const auto from = exchange_lists(state.comm(), std::get<number>(records), tag_records + static_cast<int>(number));
      state.history.of<B>() = history_of<B>(state.elements(), joined(from));
    }
  });
}

}  // namespace unibody
