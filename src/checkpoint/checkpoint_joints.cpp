#include "checkpoint/checkpoint_joints.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/checked.hpp"
#include "core/hdf5.hpp"
#include "partition/by_id.hpp"

namespace unibody {

namespace {

constexpr hsize_t columns = std::tuple_size_v<decltype(JointImpulses::value)> + std::tuple_size_v<decltype(JointImpulses::load)>;
static_assert(sizeof(JointImpulses) == columns * sizeof(double));

}  // namespace

JointRowBlock joint_row_block(MPI_Comm comm, const JointInput* joints, std::span<const JointImpulses> impulses) {
  struct Row {
    std::int64_t number;
    JointImpulses impulses;
  };
  if (joints == nullptr) return {};
  const auto count = std::ssize(joints->joints);
  const JointList& list = *joints->list;
  const IdBlocks blocks = id_blocks(comm, count);
  std::vector<Row> mine;
  std::vector<int> target;
  for (std::size_t i = 0; i < list.size(); ++i)
    if ((*joints->slots)[i].counted) mine.push_back({list[i], impulses[i]}), target.push_back(blocks.owner(list[i]));
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  JointRowBlock block{count, blocks.first(rank), std::vector<JointImpulses>(static_cast<std::size_t>(blocks.size(rank)))};
  for (const Row& row : exchange<Row>(comm, target, mine))
    block.rows[static_cast<std::size_t>(row.number - block.first)] = row.impulses;
  return block;
}

bool write_joint_rows(hid_t file, const JointRowBlock& block) {
  if (block.count == 0) return true;
  const auto table = h5::create_dataset(file, "joints", H5T_IEEE_F64LE, static_cast<hsize_t>(block.count), columns);
  h5::write_attribute(table, "columns",
                      std::string("impulse of each row, limit, motor, friction (N s or N m s), mean load (N and N m)"));
  return h5::write_rows(table, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(block.first), block.rows.size(), block.rows.data());
}

std::vector<JointImpulses> read_joint_impulses(hid_t file, const JointList& list) {
  std::vector<JointImpulses> result(list.size());
  if (list.empty()) return result;
  if (!h5::has_link(file, "joints")) throw std::runtime_error("it has no joints");
  const auto table = h5::open_table(file, "joints", {}, columns, H5T_IEEE_F64LE);
  if (list.back() >= static_cast<std::int64_t>(h5::rows_of(table))) throw std::runtime_error("it has fewer joints");
  constexpr std::int64_t piece = 100'000;
  for (std::size_t i = 0; i < list.size();) {  // the joints here, a piece of the file at a time
    const std::int64_t first = list[i];
    const std::int64_t count = std::min(piece, list.back() + 1 - first);
    std::vector<JointImpulses> rows(static_cast<std::size_t>(count));
    h5::read_rows(table, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), rows.size(), rows.data());
    for (; i < list.size() && list[i] < first + count; ++i) result[i] = rows[static_cast<std::size_t>(list[i] - first)];
  }
  const auto is_finite = [](double x) { return std::isfinite(x); };
  for (const JointImpulses& impulses : result)
    if (!std::ranges::all_of(impulses.value, is_finite) || !std::ranges::all_of(impulses.load, is_finite))
      throw std::runtime_error("an impulse or load of a joint is not finite");
  return result;
}

}  // namespace unibody
