#include "report/checkpoint_joints.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/hash.hpp"
#include "report/by_id.hpp"

namespace unibody {

namespace {

constexpr hsize_t columns = std::tuple_size_v<decltype(JointImpulses::value)>;
static_assert(sizeof(JointImpulses) == columns * sizeof(double));

std::int64_t rows_in_file(hid_t file) {
  if (H5Lexists(file, "joints", H5P_DEFAULT) <= 0) return 0;
  const auto extent = h5::dimensions(h5::open_dataset(file, "joints"));
  if (extent.size() != 2 || extent[1] != columns) throw std::runtime_error("the table of joints has another size");
  return static_cast<std::int64_t>(extent[0]);
}

std::vector<JointImpulses> read_rows(hid_t file, std::int64_t first, std::int64_t count) {
  std::vector<JointImpulses> rows(static_cast<std::size_t>(count));
  if (count > 0)
    h5::read_rows(h5::open_dataset(file, "joints"), H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), rows.size(), rows.data());
  return rows;
}

}  // namespace

JointRowBlock joint_row_block(MPI_Comm comm, std::int64_t count, const JointList& list, std::span<const JointSlots> slots,
                              std::span<const JointImpulses> impulses) {
  struct Row {
    std::int64_t number;
    JointImpulses impulses;
  };
  if (count == 0) return {};
  const IdBlocks blocks = id_blocks(comm, count);
  std::vector<Row> mine;
  std::vector<int> target;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (slots[i].counted) mine.push_back({list[i], impulses[i]}), target.push_back(blocks.owner(list[i]));
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  JointRowBlock block{count, blocks.first(rank), std::vector<JointImpulses>(static_cast<std::size_t>(blocks.size(rank)))};
  for (const Row& row : exchange<Row>(comm, target, mine))
    block.rows[static_cast<std::size_t>(row.number - block.first)] = row.impulses;
  return block;
}

std::uint64_t sum_of_hashes(const JointRowBlock& block) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < block.rows.size(); ++i) {
    Hash hash;
    hash.add(std::string_view("joint")).add(block.first + static_cast<std::int64_t>(i));
    for (const double x : block.rows[i].value) hash.add(x);
    sum += hash.value();
  }
  return sum;
}

bool write_joint_rows(hid_t file, const JointRowBlock& block) {
  if (block.count == 0) return true;
  const auto table = h5::create_dataset(file, "joints", H5T_IEEE_F64LE, static_cast<hsize_t>(block.count), columns);
  h5::write_attribute(table, "columns", std::string("impulse of each row, limit, motor, friction (N s or N m s)"));
  return h5::write_rows(table, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(block.first), block.rows.size(), block.rows.data());
}

JointRowBlock read_joint_rows(MPI_Comm comm, hid_t file) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const std::int64_t count = rows_in_file(file);
  if (count == 0) return {};
  const IdBlocks blocks = id_blocks(comm, count);
  return {count, blocks.first(rank), read_rows(file, blocks.first(rank), blocks.size(rank))};
}

std::vector<JointImpulses> read_joint_impulses(hid_t file, const JointList& list) {
  std::vector<JointImpulses> result(list.size());
  if (list.empty()) return result;
  if (list.back() >= rows_in_file(file)) throw std::runtime_error("it has fewer joints");
  constexpr std::int64_t piece = 100'000;
  for (std::size_t i = 0; i < list.size();) {  // the joints here, a piece of the file at a time
    const std::int64_t first = list[i];
    const std::int64_t count = std::min(piece, list.back() + 1 - first);
    const auto rows = read_rows(file, first, count);
    for (; i < list.size() && list[i] < first + count; ++i) result[i] = rows[static_cast<std::size_t>(list[i] - first)];
  }
  return result;
}

}  // namespace unibody
