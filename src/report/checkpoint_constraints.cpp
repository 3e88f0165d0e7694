#include "report/checkpoint_constraints.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/checked.hpp"
#include "core/hdf5.hpp"
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
  check_mpi(MPI_Scan(&mine, &last, 1, MPI_INT64_T, MPI_SUM, comm));
  check_mpi(MPI_Allreduce(&mine, &total, 1, MPI_INT64_T, MPI_SUM, comm));
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
struct ConstraintTables {
  h5::Handle ids, multipliers;
  Id count = 0;
};

// Of a type that the file does not have, none.
template <class C>
ConstraintTables<C> tables_of(hid_t file) {
  ConstraintTables<C> tables;
  const std::string name = group_of<C>();
  if (!h5::has_link(file, "constraints") || !h5::has_link(file, name)) return tables;
  tables.ids = h5::open_table(file, name + "/ids", {}, C::stencil + 1, H5T_STD_I64LE);
  tables.multipliers = h5::open_table(file, name + "/multipliers", h5::rows_of(tables.ids), C::rows, H5T_IEEE_F64LE);
  tables.count = static_cast<Id>(h5::rows_of(tables.ids));
  return tables;
}

template <class C>
ConstraintRowList<C> read_rows(const ConstraintTables<C>& tables, Id first, Id last) {
  const auto n = static_cast<std::size_t>(last - first);
  ConstraintRowList<C> rows(n);
  std::vector<std::int64_t> ids(n * (C::stencil + 1));
  std::vector<double> multipliers(n * C::rows);
  h5::read_rows(tables.ids, H5T_NATIVE_INT64, static_cast<hsize_t>(first), n, ids.data());
  h5::read_rows(tables.multipliers, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), n, multipliers.data());
  if (!std::all_of(multipliers.begin(), multipliers.end(), [](double x) { return std::isfinite(x); }))
    throw std::runtime_error("a multiplier of a constraint is not finite");
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

bool write_constraint_rows(MPI_Comm comm, hid_t file, const ConstraintRows& rows) {
  std::int64_t total = 0;
  for_each_type(rows, [&](auto, const auto& list) { total += static_cast<std::int64_t>(list.size()); });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, comm));
  if (total == 0) return true;
  const auto group = h5::create_group(file, "constraints");
  bool good = true;
  ConstraintSet names;  // of the types, in the same order
  for_each_type(names, [&](auto type, const auto& list) {
    good = write_type<TypeOf<decltype(list)>>(comm, group, std::get<type.value>(rows)) && good;
  });
  return good;
}

ConstraintMultipliers read_constraint_multipliers(hid_t file, const ConstraintSet& constraints) {
  constexpr Id piece = 1'000'000;
  ConstraintMultipliers result;
  for_each_type(constraints, [&](auto type, const auto& list) {
    using C = TypeOf<decltype(list)>;
    auto& to = std::get<type.value>(result);
    to.assign(list.size(), {});
    const auto tables = tables_of<C>(file);
    for (Id first = 0; first < tables.count; first += piece)
      for (const auto& row : read_rows<C>(tables, first, std::min(tables.count, first + piece))) {
        const auto at =
            std::lower_bound(list.begin(), list.end(), row.ids, [](const auto& c, const auto& ids) { return c.ids < ids; });
        if (at != list.end() && at->ids == row.ids) to[static_cast<std::size_t>(at - list.begin())] = row.multipliers;
      }
  });
  return result;
}

}  // namespace unibody
