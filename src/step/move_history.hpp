// Migration of history: constraints are made anew wherever their bodies go; what travels is what the next step starts from. That
// of the contacts goes with the bodies themselves (partition/migrate.hpp).
#pragma once

#include <span>
#include <tuple>
#include <type_traits>
#include <vector>

#include "partition/messages.hpp"
#include "step/history_records.hpp"
#include "step/rank_state.hpp"

namespace unibody {

template <class B>
struct HistoryRecords {
  using ByRank = std::tuple<>;
};
template <RecordedBatch B>
struct HistoryRecords<B> {
  using ByRank = ListsByRank<HistoryRecord<B>>;
};
template <class List>
struct AllHistoryRecords;
template <class... B>
struct AllHistoryRecords<BatchList<B...>> {
  using Tuple = std::tuple<typename HistoryRecords<B>::ByRank...>;
};
using HistoriesByRank = AllHistoryRecords<BatchTypes>::Tuple;

// Before the bodies go: what has to be sent, by rank. home: where each home body goes.
HistoriesByRank histories_by_rank(const RankState& state, std::span<const int> home);

// When the new constraints are there: the history of each, nothing where nothing is known of one. Collective.
void take_histories(RankState& state, HistoriesByRank records);

}  // namespace unibody
