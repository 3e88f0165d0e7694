// The history of a batch as records, each of a key and numbers, for what takes it elsewhere: migration and checkpoints.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "solve/batches.hpp"
#include "world/world.hpp"

namespace unibody {

template <class B>
concept RecordedBatch = KeyedBatch<B> || PairedBatch<B>;

template <class B>
struct HistoryTypes;
template <KeyedBatch B>
struct HistoryTypes<B> {
  using Key = typename B::Key;
  using Value = typename B::History::value_type;
};
template <PairedBatch B>
struct HistoryTypes<B> {
  using Key = std::array<Id, 2>;
  using Value = std::array<double, pair_width<typename B::History>>;
};

template <class B>
struct HistoryRecord {
  typename HistoryTypes<B>::Key key;
  typename HistoryTypes<B>::Value value;
};

// Calls f(record, ids of the bodies) for all that the history has.
template <class B, typename F>
void for_each_record(const Elements& elements, const typename B::History& history, F&& f) {
  if constexpr (PairedBatch<B>) {
    for (const auto& pair : history) f(HistoryRecord<B>{pair.key, pair.value}, std::span<const Id>(pair.key));
  } else {
    std::size_t i = 0;
    B::for_each_element(elements, [&](const typename B::Key& key, std::span<const Id> ids) {
      if (i < history.size()) f(HistoryRecord<B>{key, history[i]}, ids);
      ++i;
    });
  }
}

// The history of what is here; nothing where no record is of one. There may be more records than that, and some twice.
template <class B>
typename B::History history_of(const Elements& elements, std::vector<HistoryRecord<B>> records) {
  std::ranges::sort(records, {}, &HistoryRecord<B>::key);
  typename B::History history;
  if constexpr (PairedBatch<B>) {
    const auto is_home = [&](Id id) {
      const Slot slot = elements.world.find(id);
      return slot >= 0 && elements.world.is_home(slot);
    };
    for (const auto& record : records)
      if ((is_home(record.key[0]) || is_home(record.key[1])) && (history.empty() || history.back().key != record.key))
        history.push_back({record.key, record.value});
  } else {
    B::for_each_element(elements, [&](const typename B::Key& key, std::span<const Id>) {
      const auto at = std::ranges::lower_bound(records, key, {}, &HistoryRecord<B>::key);
      history.push_back(at != records.end() && at->key == key ? at->value : typename HistoryTypes<B>::Value{});
    });
  }
  return history;
}

}  // namespace unibody
