#include "report/joint_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"
#include "partition/messages.hpp"
#include "report/kept_rows.hpp"

namespace unibody {

namespace {

constexpr int tag_states = 181;
constexpr std::size_t joint_values = 14;
constexpr const char* column_names =
    "coordinate (rad or m),drift (m),turn (rad),force_x (N),force_y (N),force_z (N),torque_x (N m),torque_y (N m),torque_z (N m),"
    "limit (N m or N),motor (N m or N),friction (N m or N),"
    "spring (N m or N),broken (1)";

template <class T>
void write_table(hid_t group, const char* name, hid_t file_type, hid_t memory_type, std::size_t columns,
                 const std::vector<T>& values, std::size_t rows) {
  const auto table = h5::create_dataset(group, name, file_type, rows, columns);
  if (!h5::write_rows(table, memory_type, 0, rows, values.data())) throw std::runtime_error("is the disk full?");
}

// What the joints are, for programs that draw them.
void write_joints(hid_t file, std::span<const Joint> joints) {
  const auto group = h5::create_group(file, "joints");
  std::vector<std::int64_t> ids;
  std::vector<std::int8_t> kinds;
  std::array<std::vector<double>, 2> anchors;
  std::vector<double> axes;
  for (const Joint& joint : joints) {
    ids.insert(ids.end(), joint.ids.begin(), joint.ids.end());
    kinds.push_back(static_cast<std::int8_t>(joint.kind));
    for (std::size_t side = 0; side < 2; ++side)
      anchors[side].insert(anchors[side].end(), joint.anchor[side].begin(), joint.anchor[side].end());
    const Vec3 axis = joint.frame[0] * Vec3::UnitZ();
    axes.insert(axes.end(), axis.begin(), axis.end());
  }
  const std::size_t n = joints.size();
  write_table(group, "bodies", H5T_STD_I64LE, H5T_NATIVE_INT64, 2, ids, n);
  write_table(group, "type", H5T_STD_I8LE, H5T_NATIVE_INT8, 0, kinds, n);
  write_table(group, "anchor_a", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, anchors[0], n);
  write_table(group, "anchor_b", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, anchors[1], n);
  write_table(group, "axis", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, axes, n);
  std::string names;
  for (const auto name : joint_names) names.append(names.empty() ? "" : " ").append(name);
  h5::write_attribute(group, "type_names", names);
}

}  // namespace

std::vector<NamedValue> joint_columns(MPI_Comm comm, std::span<const Joint> joints, const JointList& here,
                                      std::span<const JointSlots> slots, std::span<const JointState> states, double residual) {
  if (joints.empty()) return {};
  std::array<ExactSum, 2> squares;
  std::array<double, 2> largest{};
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!slots[i].counted) continue;
    const Joint& joint = joints[static_cast<std::size_t>(here[i])];
    const double drift = joint.compliance > 0 ? 0 : states[i].drift;
    const double turn = joint.turning > 0 ? 0 : states[i].turn;
    squares[0] += drift * drift, squares[1] += turn * turn;
    largest[0] = std::max(largest[0], drift), largest[1] = std::max(largest[1], turn);
  }
  const auto total = all_sums(comm, squares);
  make_largest(comm, largest);
  const auto n = static_cast<double>(joints.size());
  return {{"joint_drift_max (m)", largest[0]},
          {"joint_drift_rms (m)", std::sqrt(total[0] / n)},
          {"joint_turn_max (rad)", largest[1]},
          {"joint_turn_rms (rad)", std::sqrt(total[1] / n)},
          {"residual_joint (m)", residual}};
}

struct JointFiles::Row {
  std::int64_t number;
  std::array<double, joint_values> value;
};

JointFiles::JointFiles(MPI_Comm comm, const std::string& directory, std::span<const Joint> joints, std::int64_t kept_to)
    : comm_(comm), directory_(directory), joints_(joints) {
  check_mpi(MPI_Comm_rank(comm, &rank_));
  std::string fault;
  if (rank_ == 0) try {
      const h5::Quiet quiet;
      const bool has_rows = open_table(kept_to);
      open_file(kept_to);
      // Of a frame whose rows are in one file alone the forces are known no more: it is not written again.
      if (has_rows && !holds(kept_to)) kept_.push_back(kept_to);
    } catch (const std::runtime_error& e) {
      fault = "cannot write in '" + directory + "': " + e.what();
    }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw RunError(fault);
  std::int64_t count = static_cast<std::int64_t>(kept_.size());
  check_mpi(MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm));
  kept_.resize(static_cast<std::size_t>(count));
  check_mpi(MPI_Bcast(kept_.data(), static_cast<int>(count), MPI_INT64_T, 0, comm));
}

bool JointFiles::open_table(std::int64_t kept_to) {
  const std::string path = directory_ + "/joints.csv", header = std::string("frame,time (s),joint,type,") + column_names;
  const bool goes_on = kept_to >= 0 && keep_rows(path, header, kept_to);
  csv_ = std::fopen(path.c_str(), goes_on ? "a" : "w");
  if (csv_ == nullptr || (!goes_on && std::fprintf(csv_, "%s\n", header.c_str()) < 0)) throw std::runtime_error("joints.csv");
  return goes_on;
}

void JointFiles::open_file(std::int64_t kept_to) {
  const std::string path = directory_ + "/joints.h5";
  if (kept_to < 0 || !std::filesystem::exists(path)) {
    h5_ = h5::create_file(MPI_COMM_SELF, path);
    h5::write_attribute(h5_, "columns", std::string(column_names));
    h5::write_attribute(h5_, "rows", std::string("joints, in the order of the scene"));
    write_joints(h5_, joints_);
    frames_.create(MPI_COMM_SELF, h5_, path);
    return;
  }
  h5_ = h5::open_file_to_extend(MPI_COMM_SELF, path);
  frames_.extend(MPI_COMM_SELF, h5_, path, kept_to);
  kept_ = frames_.kept();
}

JointFiles::~JointFiles() {
  if (csv_ != nullptr) std::fclose(csv_);
}

void JointFiles::close() {
  const h5::Quiet quiet;
  bool good = frames_.close();
  good = h5_.close() >= 0 && good;
  good = (csv_ == nullptr || std::fclose(std::exchange(csv_, nullptr)) == 0) && good;
  const auto fault = first_fault(comm_, good ? "" : "cannot write joints in '" + directory_ + "': is the disk full?");
  if (!fault.empty()) throw RunError(fault);
}

void JointFiles::write(std::int64_t frame, double time, const JointList& list, std::span<const JointSlots> slots,
                       std::span<const JointState> states) {
  ListsByRank<Row> to;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!slots[i].counted) continue;
    const JointState& s = states[i];
    to[0].push_back({list[i],
                     {s.coordinate, s.drift, s.turn, s.force[0], s.force[1], s.force[2], s.torque[0], s.torque[1], s.torque[2],
                      s.limit, s.motor, s.friction, s.spring, s.broken ? 1.0 : 0.0}});
  }
  std::vector<Row> rows = joined(exchange_lists(comm_, to, tag_states));
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.number < b.number; });
  std::string fault;
  if (rank_ == 0) try {
      const h5::Quiet quiet;
      write_rows(frame, time, rows);
    } catch (const std::runtime_error& e) {
      fault = "cannot write joints in '" + directory_ + "': " + e.what();
    }
  fault = first_fault(comm_, fault);
  if (!fault.empty()) throw RunError(fault);
}

void JointFiles::write_rows(std::int64_t frame, double time, const std::vector<Row>& rows) {
  std::vector<double> values;
  bool good = true;
  for (const Row& row : rows) {
    const auto kind = static_cast<std::size_t>(joints_[static_cast<std::size_t>(row.number)].kind);
    good = std::fprintf(csv_, "%lld,%.17g,%lld,%s", static_cast<long long>(frame), time, static_cast<long long>(row.number),
                        joint_names[kind].data()) >= 0 &&
           good;
    for (const double x : row.value) good = std::fprintf(csv_, ",%.17g", x) >= 0 && good;
    good = std::fputc('\n', csv_) != EOF && good;
    values.insert(values.end(), row.value.begin(), row.value.end());
  }
  const auto table = h5::create_unlinked_dataset(h5_, H5T_IEEE_F64LE, rows.size(), joint_values);
  h5::write_attribute(table, "time", time);
  good = h5::write_rows(table, H5T_NATIVE_DOUBLE, 0, rows.size(), values.data()) && good;
  good = good && frames_.add(table, frame) && std::fflush(csv_) == 0;
  if (!good) throw std::runtime_error("is the disk full?");
}

}  // namespace unibody
