#include "checkpoint/checkpoint_histories.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/checked.hpp"
#include "core/hdf5.hpp"
#include "partition/by_id.hpp"

namespace unibody {

namespace {

template <class B>
constexpr std::size_t key_size = std::tuple_size_v<typename HistoryTypes<B>::Key>;
template <class B>
constexpr std::size_t value_size = std::tuple_size_v<typename HistoryTypes<B>::Value>;

template <class B>
std::string value_columns() {
  if constexpr (PairedBatch<B>)
    return std::string(B::history_columns);
  else
    return "impulse of each row (N s)";
}

// Calls f(place in the list, std::type_identity<batch>) for each kind that has a group.
template <typename F>
void for_each_group(F&& f) {
  for_each_batch_type([&]<class B>(auto place, std::type_identity<B> batch) {
    if constexpr (is_in_groups<B>) f(place, batch);
  });
}

template <class B>
bool before(const HistoryRow<B>& a, const HistoryRow<B>& b) {
  return std::tie(a.owner, a.key) < std::tie(b.owner, b.key);
}

template <class B>
std::vector<HistoryRow<B>> rows_of(MPI_Comm comm, Id body_count, const Elements& elements, const typename B::History& history) {
  const IdBlocks blocks = id_blocks(comm, body_count);
  const World& world = elements.world;
  std::vector<HistoryRow<B>> mine;
  std::vector<int> target;
  for_each_record<B>(elements, history, [&](const HistoryRecord<B>& record, std::span<const Id> ids) {
    for (const Id id : ids) {
      const Slot slot = world.find(id);
      if (slot >= 0 && world.is_static(slot)) continue;
      if (slot >= 0 && world.is_home(slot)) {
        mine.push_back({id, record.key, record.value});
        target.push_back(blocks.owner(id));
      }
      break;  // the first that moves is the owner
    }
  });
  auto rows = exchange<HistoryRow<B>>(comm, target, mine);
  std::sort(rows.begin(), rows.end(), before<B>);
  return rows;
}

template <class B>
bool write_group(MPI_Comm comm, hid_t group, const std::vector<HistoryRow<B>>& rows) {
  const auto mine = static_cast<std::int64_t>(rows.size());
  std::int64_t last = 0, total = 0;
  check_mpi(MPI_Scan(&mine, &last, 1, MPI_INT64_T, MPI_SUM, comm));
  check_mpi(MPI_Allreduce(&mine, &total, 1, MPI_INT64_T, MPI_SUM, comm));
  if (total == 0) return true;
  std::vector<std::int64_t> keys;
  std::vector<double> values;
  for (const auto& row : rows) {
    keys.push_back(row.owner);
    keys.insert(keys.end(), row.key.begin(), row.key.end());
    values.insert(values.end(), row.value.begin(), row.value.end());
  }
  const auto own = h5::create_group(group, std::string(B::name));
  const auto first = static_cast<hsize_t>(last - mine), count = static_cast<hsize_t>(total);
  const auto key = h5::create_dataset(own, "ids", H5T_STD_I64LE, count, key_size<B> + 1);
  h5::write_attribute(key, "columns", std::string("owner, then the bodies"));
  const bool good = h5::write_rows(key, H5T_NATIVE_INT64, first, rows.size(), keys.data());
  const auto value = h5::create_dataset(own, "multipliers", H5T_IEEE_F64LE, count, value_size<B>);
  h5::write_attribute(value, "columns", value_columns<B>());
  return h5::write_rows(value, H5T_NATIVE_DOUBLE, first, rows.size(), values.data()) && good;
}

struct Tables {
  h5::Handle keys, values;
  Id count = 0;
};

// The tables of one batch. Where the file has none of it, they are empty.
template <class B>
Tables tables_of(hid_t file) {
  Tables tables;
  const std::string name = "constraints/" + std::string(B::name);
  if (!h5::has_link(file, "constraints") || !h5::has_link(file, name)) return tables;
  tables.keys = h5::open_table(file, name + "/ids", {}, key_size<B> + 1, H5T_STD_I64LE);
  tables.values = h5::open_table(file, name + "/multipliers", h5::rows_of(tables.keys), value_size<B>, H5T_IEEE_F64LE);
  tables.count = static_cast<Id>(h5::rows_of(tables.keys));
  return tables;
}

void check_pair(Id owner, const std::array<Id, 2>& pair, Id body_count) {
  if (pair[0] < 0 || pair[0] >= pair[1] || pair[1] >= body_count || (owner != pair[0] && owner != pair[1]))
    throw std::runtime_error("a row is of no pair of bodies");
}

template <class B>
std::vector<HistoryRow<B>> read_rows(const Tables& tables, Id first, Id last, Id body_count) {
  const auto n = static_cast<std::size_t>(last - first);
  std::vector<HistoryRow<B>> rows(n);
  std::vector<std::int64_t> keys(n * (key_size<B> + 1));
  std::vector<double> values(n * value_size<B>);
  h5::read_rows(tables.keys, H5T_NATIVE_INT64, static_cast<hsize_t>(first), n, keys.data());
  h5::read_rows(tables.values, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), n, values.data());
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
    throw std::runtime_error("a multiplier of a constraint is not finite");
  for (std::size_t i = 0; i < n; ++i) {
    rows[i].owner = keys[i * (key_size<B> + 1)];
    std::copy_n(keys.data() + i * (key_size<B> + 1) + 1, key_size<B>, rows[i].key.begin());
    std::copy_n(values.data() + i * value_size<B>, value_size<B>, rows[i].value.begin());
    if constexpr (PairedBatch<B>) check_pair(rows[i].owner, rows[i].key, body_count);
  }
  return rows;
}

// Which rows of the file are of something here.
template <class B>
class KeysHere {
 public:
  using Key = typename HistoryTypes<B>::Key;

  explicit KeysHere(const Elements& elements) : world_(elements.world) {
    if constexpr (KeyedBatch<B>)
      B::for_each_element(elements, [&](const Key& key, std::span<const Id>) { keys_.push_back(key); });
  }
  bool has(const Key& key) const {
    if constexpr (KeyedBatch<B>)
      return std::ranges::binary_search(keys_, key);
    else
      return std::ranges::any_of(key, [&](Id id) {
        const Slot slot = world_.find(id);
        return slot >= 0 && world_.is_home(slot);
      });
  }

 private:
  const World& world_;
  std::vector<Key> keys_;
};

}  // namespace

HistoryRows history_rows(MPI_Comm comm, Id body_count, const Elements& elements, const BatchHistories& histories) {
  HistoryRows rows;
  for_each_group([&]<class B>(auto place, std::type_identity<B>) {
    std::get<decltype(place)::value>(rows) = rows_of<B>(comm, body_count, elements, histories.of<B>());
  });
  return rows;
}

bool write_history_rows(MPI_Comm comm, hid_t file, const HistoryRows& rows) {
  std::int64_t total = 0;
  for_each_group([&](auto place, auto) { total += std::ssize(std::get<decltype(place)::value>(rows)); });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, comm));
  if (total == 0) return true;
  const auto group = h5::create_group(file, "constraints");
  bool good = true;
  for_each_group([&]<class B>(auto place, std::type_identity<B>) {
    good = write_group<B>(comm, group, std::get<decltype(place)::value>(rows)) && good;
  });
  return good;
}

void read_histories(hid_t file, Id body_count, const Elements& elements, BatchHistories& histories) {
  constexpr Id piece = 1'000'000;
  for_each_group([&]<class B>(auto, std::type_identity<B>) {
    const Tables tables = tables_of<B>(file);
    const KeysHere<B> here(elements);
    std::vector<HistoryRecord<B>> records;
    for (Id first = 0; first < tables.count; first += piece)
      for (const auto& row : read_rows<B>(tables, first, std::min(tables.count, first + piece), body_count))
        if (here.has(row.key)) records.push_back({row.key, row.value});
    histories.of<B>() = history_of<B>(elements, std::move(records));
  });
}

}  // namespace unibody
