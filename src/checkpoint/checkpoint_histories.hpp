// The part of a checkpoint that holds what constraints other than contacts start the next step from: a group for each kind of
// batch, but for the joints, which have a table of their own (checkpoint_joints.hpp).
#pragma once

#include <mpi.h>

#include <cstdint>

#include "core/hdf5.hpp"
#include "step/history.hpp"
#include "step/history_records.hpp"
#include "world/world.hpp"

namespace unibody {

// The rows of one kind: a constraint stands where the id block of its first moving body is, in order of that body, then of keys.
template <class B>
struct HistoryRow {
  Id owner;
  typename HistoryTypes<B>::Key key;
  typename HistoryTypes<B>::Value value;  // N s; of a PairedBatch as its history_columns say
};
template <class B>
inline constexpr bool is_in_groups = RecordedBatch<B> && !std::is_same_v<B, JointBatch>;
template <class B>
struct HistoryRowsOf {
  using List = std::tuple<>;
};
template <class B>
requires is_in_groups<B>
struct HistoryRowsOf<B> {
  using List = std::vector<HistoryRow<B>>;
};
template <class List>
struct AllHistoryRows;
template <class... B>
struct AllHistoryRows<BatchList<B...>> {
  using Tuple = std::tuple<typename HistoryRowsOf<B>::List...>;
};
using HistoryRows = AllHistoryRows<BatchTypes>::Tuple;

// This rank's share of the file's rows. Collective.
HistoryRows history_rows(MPI_Comm comm, Id body_count, const Elements& elements, const BatchHistories& histories);

// Writes group `constraints`, of the kinds that the scene has; false: the disk fails. Collective.
[[nodiscard]] bool write_history_rows(MPI_Comm comm, hid_t file, const HistoryRows& rows);

// What the constraints that are here start from. Each rank reads all rows of the file, a piece at a time. Throws
// std::runtime_error where a table is not what it should be.
void read_histories(hid_t file, Id body_count, const Elements& elements, BatchHistories& histories);

}  // namespace unibody
