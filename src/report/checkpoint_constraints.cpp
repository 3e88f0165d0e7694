#include "report/checkpoint_constraints.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "core/hash.hpp"
#include "report/by_id.hpp"

namespace unibody {

namespace {

template <class C>
std::string group_of() {
  return "constraints/" + std::string(C::name);
}

template <class C>
bool before(const ConstraintRow<C>& a, const ConstraintRow<C>& b) {
  return std::tie(a.owner, a.ids) < std::tie(b.owner, b.ids);
}

template <class C>
ConstraintRowList<C> rows_of_type(MPI_Comm comm, Id body_count, const World& world, const ConstraintList<C>& list,
                                  const MultiplierList<C>& multipliers) {
  const IdBlocks blocks = id_blocks(comm, body_count);
  ConstraintRowList<C> mine;
  std::vector<int> target;
  for (std::size_t i = 0; i < list.size(); ++i)
    for (const Id id : list[i].ids) {
      const Slot slot = world.find(id);
      if (slot >= 0 && world.is_static(slot)) continue;
      if (slot >= 0 && world.is_home(slot)) {
        mine.push_back({id, list[i].ids, multipliers[i]});
        target.push_back(blocks.owner(id));
      }
      break;  // the first that moves is the owner
    }
  auto rows = exchange<ConstraintRow<C>>(comm, target, mine);
  std::sort(rows.begin(), rows.end(), before<C>);
  return rows;
}

template <class C>
bool write_type(MPI_Comm comm, hid_t group, const ConstraintRowList<C>& rows) {
  const auto mine = static_cast<std::int64_t>(rows.size());
  std::int64_t last = 0, total = 0;
  MPI_Scan(&mine, &last, 1, MPI_INT64_T, MPI_SUM, comm);
  MPI_Allreduce(&mine, &total, 1, MPI_INT64_T, MPI_SUM, comm);
  if (total == 0) return true;
  std::vector<std::int64_t> ids;
  std::vector<double> multipliers;
  for (const auto& row : rows) {
    ids.push_back(row.owner);
    ids.insert(ids.end(), row.ids.begin(), row.ids.end());
    multipliers.insert(multipliers.end(), row.multipliers.begin(), row.multipliers.end());
  }
  const auto own = h5::create_group(group, std::string(C::name));
  const auto first = static_cast<hsize_t>(last - mine), count = static_cast<hsize_t>(total);
  const auto key = h5::create_dataset(own, "ids", H5T_STD_I64LE, count, C::stencil + 1);
  h5::write_attribute(key, "columns", std::string("owner, then the bodies"));
  const bool good = h5::write_rows(key, H5T_NATIVE_INT64, first, rows.size(), ids.data());
  const auto value = h5::create_dataset(own, "multipliers", H5T_IEEE_F64LE, count, C::rows);
  h5::write_attribute(value, "columns", std::string("impulse of each row (N s)"));
  return h5::write_rows(value, H5T_NATIVE_DOUBLE, first, rows.size(), multipliers.data()) && good;
}

template <class C>
Id rows_in_file(hid_t file) {
  const std::string name = group_of<C>();
  if (H5Lexists(file, "constraints", H5P_DEFAULT) <= 0 || H5Lexists(file, name.c_str(), H5P_DEFAULT) <= 0) return 0;
  const auto keys = h5::dimensions(h5::open_dataset(file, name + "/ids"));
  const auto values = h5::dimensions(h5::open_dataset(file, name + "/multipliers"));
  if (keys.size() != 2 || values.size() != 2 || keys[0] != values[0] || keys[1] != C::stencil + 1 || values[1] != C::rows)
    throw std::runtime_error("a table of constraints has another size");
  return static_cast<Id>(keys[0]);
}

template <class C>
ConstraintRowList<C> read_rows_of_type(hid_t file, Id first, Id last) {
  const auto n = static_cast<std::size_t>(last - first);
  ConstraintRowList<C> rows(n);
  if (n == 0) return rows;
  std::vector<std::int64_t> ids(n * (C::stencil + 1));
  std::vector<double> multipliers(n * C::rows);
  h5::read_rows(h5::open_dataset(file, group_of<C>() + "/ids"), H5T_NATIVE_INT64, static_cast<hsize_t>(first), n, ids.data());
  h5::read_rows(h5::open_dataset(file, group_of<C>() + "/multipliers"), H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), n,
                multipliers.data());
  for (std::size_t i = 0; i < n; ++i) {
    rows[i].owner = ids[i * (C::stencil + 1)];
    std::copy_n(ids.data() + i * (C::stencil + 1) + 1, C::stencil, rows[i].ids.begin());
    std::copy_n(multipliers.data() + i * C::rows, C::rows, rows[i].multipliers.begin());
  }
  return rows;
}

template <class List>
using TypeOf = typename std::remove_cvref_t<List>::value_type::type;

}  // namespace

ConstraintRows constraint_rows(MPI_Comm comm, Id body_count, const World& world, const ConstraintSet& constraints,
                               const ConstraintMultipliers& multipliers) {
  ConstraintRows rows;
  for_each_type(constraints, [&](auto type, const auto& list) {
    using C = TypeOf<decltype(list)>;
    std::get<type.value>(rows) = rows_of_type<C>(comm, body_count, world, list, std::get<type.value>(multipliers));
  });
  return rows;
}

std::uint64_t sum_of_hashes(const ConstraintRows& rows) {
  std::uint64_t sum = 0;
  for_each_type(rows, [&](auto type, const auto& list) {
    for (const auto& row : list) {
      Hash hash;
      hash.add(static_cast<std::int64_t>(type.value)).add(row.owner);
      for (const Id id : row.ids) hash.add(id);
      for (const double x : row.multipliers) hash.add(x);
      sum += hash.value();
    }
  });
  return sum;
}

bool write_constraint_rows(MPI_Comm comm, hid_t file, const ConstraintRows& rows) {
  std::int64_t total = 0;
  for_each_type(rows, [&](auto, const auto& list) { total += static_cast<std::int64_t>(list.size()); });
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, comm);
  if (total == 0) return true;
  const auto group = h5::create_group(file, "constraints");
  bool good = true;
  ConstraintSet names;  // of the types, in the same order
  for_each_type(names, [&](auto type, const auto& list) {
    good = write_type<TypeOf<decltype(list)>>(comm, group, std::get<type.value>(rows)) && good;
  });
  return good;
}

ConstraintRows read_constraint_rows(MPI_Comm comm, hid_t file) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  ConstraintRows rows;
  ConstraintSet names;
  for_each_type(names, [&](auto type, const auto& list) {
    using C = TypeOf<decltype(list)>;
    const IdBlocks share = id_blocks(comm, rows_in_file<C>(file));
    std::get<type.value>(rows) = read_rows_of_type<C>(file, share.first(rank), share.first(rank + 1));
  });
  return rows;
}

ConstraintMultipliers read_constraint_multipliers(hid_t file, const ConstraintSet& constraints) {
  constexpr Id piece = 1'000'000;
  ConstraintMultipliers result;
  for_each_type(constraints, [&](auto type, const auto& list) {
    using C = TypeOf<decltype(list)>;
    auto& to = std::get<type.value>(result);
    to.assign(list.size(), {});
    const Id total = rows_in_file<C>(file);
    for (Id first = 0; first < total; first += piece)
      for (const auto& row : read_rows_of_type<C>(file, first, std::min(total, first + piece))) {
        const auto at =
            std::lower_bound(list.begin(), list.end(), row.ids, [](const auto& c, const auto& ids) { return c.ids < ids; });
        if (at != list.end() && at->ids == row.ids) to[static_cast<std::size_t>(at - list.begin())] = row.multipliers;
      }
  });
  return result;
}

}  // namespace unibody
