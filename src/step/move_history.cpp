#include "step/move_history.hpp"

#include <algorithm>

#include "partition/messages.hpp"

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
    if constexpr (KeyedBatch<B>) {
      auto& to = std::get<decltype(place)::value>(records);
      to.resize(static_cast<std::size_t>(state.halo.size()));
      const auto& history = state.history.of<B>();
      std::size_t i = 0;
      B::for_each_element(state.elements(), [&](const typename B::Key& key, std::span<const Id> ids) {
        if (i < history.size())
          for (const int rank : ranks_of(state.world, ids, home)) to[static_cast<std::size_t>(rank)].push_back({key, history[i]});
        ++i;
      });
    }
  });
  return records;
}

void take_histories(RankState& state, HistoriesByRank records) {
  for_each_batch_type([&]<class B>(auto place, std::type_identity<B>) {
    if constexpr (KeyedBatch<B>) {
      constexpr std::size_t number = decltype(place)::value;
      const auto in = exchange_all(state.comm(), std::get<number>(records), tag_records + static_cast<int>(number));
      std::vector<HistoryRecord<B>> all;
      for (const auto& from : in) all.insert(all.end(), from.begin(), from.end());
      const auto before = [](const HistoryRecord<B>& a, const HistoryRecord<B>& b) { return a.key < b.key; };
      std::sort(all.begin(), all.end(), before);
      typename B::History history;
      B::for_each_element(state.elements(), [&](const typename B::Key& key, std::span<const Id>) {
        const auto at = std::lower_bound(all.begin(), all.end(), HistoryRecord<B>{key, {}}, before);
        history.push_back(at != all.end() && at->key == key ? at->value : typename B::History::value_type{});
      });
      state.history.of<B>() = std::move(history);
    }
  });
}

}  // namespace unibody
