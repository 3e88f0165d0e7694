#include "checkpoint/checkpoint_past.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr const char* ratio_attribute = "error_ratio";
constexpr const char* next_attribute = "error_next_step";
constexpr const char *parts_attribute = "step_parts", *calm_attribute = "calm_steps", *deep_attribute = "deep_steps";

void write_accuracy(hid_t file, const History& history) {
  const bool is_first = history.fineness.parts == 1 && history.fineness.calm == 0 && history.fineness.deep == 0;
  if (history.error_ratio.next < 0 && is_first) return;
  h5::write_attribute(file, ratio_attribute, history.error_ratio.ratio);
  h5::write_attribute(file, next_attribute, history.error_ratio.next);
  const Fineness& fineness = history.fineness;
  h5::write_attribute(file, parts_attribute, std::int64_t{fineness.parts});
  h5::write_attribute(file, calm_attribute, std::int64_t{fineness.calm});
  h5::write_attribute(file, deep_attribute, std::int64_t{fineness.deep});
}

void read_accuracy(hid_t file, History& history) {
  history.error_ratio = {}, history.fineness = {};
  if (!h5::has_attribute(file, next_attribute)) return;
  ErrorRatio& known = history.error_ratio;
  known = {h5::read_double(file, ratio_attribute), h5::read_integer(file, next_attribute)};
  const auto small = [&](const char* name) {
    const std::int64_t x = h5::read_integer(file, name);
    if (x < 0 || x > std::numeric_limits<int>::max()) throw std::runtime_error(std::string("its ") + name + " is out of range");
    return static_cast<int>(x);
  };
  if (!(known.ratio >= 0 && std::isfinite(known.ratio)) || known.next < -1)
    throw std::runtime_error("its ratio of error to residual is out of range");
  history.fineness = {std::max(small(parts_attribute), 1), small(calm_attribute), small(deep_attribute)};
}

// A table of the group "past", of which rank 0 writes all rows, since every rank knows them. None where there are no rows.
class Table {
 public:
  Table(const char* name, hsize_t width, const char* about) : name_(name), columns_(width), about_(about) {}

  bool write(MPI_Comm comm, hid_t group, const std::vector<std::int64_t>& whole) const {
    return write_as(comm, group, H5T_STD_I64LE, H5T_NATIVE_INT64, whole);
  }
  bool write(MPI_Comm comm, hid_t group, const std::vector<double>& reals) const {
    return write_as(comm, group, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, reals);
  }
  // rows: how many there must be; none: any number.
  template <class Number>
  std::vector<Number> read(hid_t group, std::optional<hsize_t> rows) const {
    constexpr bool whole = std::is_integral_v<Number>;
    if ((rows && *rows == 0) || (!rows && !h5::has_link(group, name_))) return {};
    const auto table = h5::open_table(group, name_, rows, columns_, whole ? H5T_STD_I64LE : H5T_IEEE_F64LE);
    std::vector<Number> numbers(static_cast<std::size_t>(h5::rows_of(table) * columns_));
    h5::read_rows(table, whole ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, 0, h5::rows_of(table), numbers.data());
    const auto is_good = [](Number x) { return x >= 0 && std::isfinite(static_cast<double>(x)); };
    if (!std::ranges::all_of(numbers, is_good))
      throw std::runtime_error(std::string("a number of past/") + name_ + " is out of range");
    return numbers;
  }

 private:
  template <class Number>
  bool write_as(MPI_Comm comm, hid_t group, hid_t file_type, hid_t memory_type, const std::vector<Number>& numbers) const {
    if (numbers.empty()) return true;
    int rank = 0;
    check_mpi(MPI_Comm_rank(comm, &rank));
    const auto table = h5::create_dataset(group, name_, file_type, static_cast<hsize_t>(numbers.size()) / columns_, columns_);
    h5::write_attribute(table, "columns", std::string(about_));
    return h5::write_rows(table, memory_type, 0, rank == 0 ? numbers.size() / columns_ : 0, numbers.data());
  }

  const char* name_;
  hsize_t columns_;
  const char* about_;
};

const Table events("events", 1, "frame at whose start each took effect; 0: none");
const Table inlets("inlets", 2, "bodies drawn, placed"), inlet_masses("inlet_masses", 2, "mass drawn, placed (kg)");
const Table waiting("waiting", 2, "inlet, number of a body that waits for room");
const Table outlets("outlets", 1, "bodies removed"), outlet_masses("outlet_masses", 1, "mass removed (kg)");

const Table breaks("breaks", 4, "joint that has broken, time (s), force (N), torque (N m) that it bore");

bool is_none(const Past& past) { return past.events.empty() && past.inlets.empty() && past.outlets.empty(); }

bool write_happened(MPI_Comm comm, hid_t file, const Past& past) {
  if (is_none(past) && past.breaks.empty()) return true;
  std::vector<std::int64_t> drawn, waits, removed;
  std::vector<double> masses, removed_masses, broken;
  for (std::size_t i = 0; i < past.inlets.size(); ++i) {
    const InletPast& inlet = past.inlets[i];
    drawn.insert(drawn.end(), {inlet.drawn, inlet.placed});
    masses.insert(masses.end(), {inlet.drawn_mass, inlet.placed_mass});
    for (const Id number : inlet.waiting) waits.insert(waits.end(), {static_cast<std::int64_t>(i), number});
  }
  for (const OutletPast& outlet : past.outlets) removed.push_back(outlet.removed), removed_masses.push_back(outlet.removed_mass);
  for (const Break& one : past.breaks)
    broken.insert(broken.end(), {static_cast<double>(one.joint), one.time, one.force, one.torque});
  const auto group = h5::create_group(file, "past");
  bool good = events.write(comm, group, past.events);
  good = inlets.write(comm, group, drawn) && good;
  good = inlet_masses.write(comm, group, masses) && good;
  good = waiting.write(comm, group, waits) && good;
  good = outlets.write(comm, group, removed) && good;
  good = breaks.write(comm, group, broken) && good;
  return outlet_masses.write(comm, group, removed_masses) && good;
}

std::vector<Break> read_breaks(hid_t group, std::size_t joints) {
  const std::vector<double> numbers = breaks.read<double>(group, {});
  std::vector<Break> result;
  std::set<std::int64_t> known;
  for (std::size_t k = 0; k < numbers.size(); k += 4) {
    if (!(numbers[k] < static_cast<double>(joints)) || numbers[k] != std::floor(numbers[k]))
      throw std::runtime_error("a joint of past/breaks is none of the scene's");
    result.push_back({static_cast<std::int64_t>(numbers[k]), numbers[k + 1], numbers[k + 2], numbers[k + 3]});
    if (!known.insert(result.back().joint).second) throw std::runtime_error("a joint of past/breaks has broken twice");
  }
  return result;
}

void read_happened(hid_t file, std::size_t joints, Past& past) {
  if (is_none(past) && (joints == 0 || !h5::has_link(file, "past"))) return;
  if (!h5::has_link(file, "past")) throw std::runtime_error("it does not say what has happened of the scene's events and inlets");
  const h5::Handle group(H5Gopen2(file, "past", H5P_DEFAULT), H5Gclose, "open group past");
  past.events = events.read<std::int64_t>(group, past.events.size());
  const auto drawn = inlets.read<std::int64_t>(group, past.inlets.size());
  const auto masses = inlet_masses.read<double>(group, past.inlets.size());
  for (std::size_t i = 0; i < past.inlets.size(); ++i)
    past.inlets[i] = {drawn[2 * i], masses[2 * i], {}, drawn[2 * i + 1], masses[2 * i + 1]};
  const auto waits = waiting.read<std::int64_t>(group, {});
  for (std::size_t k = 0; k < waits.size(); k += 2) {
    if (waits[k] >= std::ssize(past.inlets)) throw std::runtime_error("a body of past/waiting waits for no inlet");
    InletPast& inlet = past.inlets[static_cast<std::size_t>(waits[k])];
    if (waits[k + 1] >= inlet.drawn || (!inlet.waiting.empty() && waits[k + 1] <= inlet.waiting.back()))
      throw std::runtime_error("a body of past/waiting is out of order");
    inlet.waiting.push_back(waits[k + 1]);
  }
  past.breaks = read_breaks(group, joints);
  const auto removed = outlets.read<std::int64_t>(group, past.outlets.size());
  const auto removed_masses = outlet_masses.read<double>(group, past.outlets.size());
  for (std::size_t o = 0; o < past.outlets.size(); ++o) past.outlets[o] = {removed[o], removed_masses[o]};
}

}  // namespace

bool write_past(MPI_Comm comm, hid_t file, const History& history) {
  write_accuracy(file, history);
  return write_happened(comm, file, history.past);
}

void read_past(hid_t file, std::size_t joints, History& history) {
  read_accuracy(file, history);
  read_happened(file, joints, history.past);
}

}  // namespace unibody
