#include "checkpoint/checkpoint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "checkpoint/checkpoint_histories.hpp"
#include "checkpoint/checkpoint_joints.hpp"
#include "checkpoint/checkpoint_past.hpp"
#include "checkpoint/checkpoint_rows.hpp"
#include "checkpoint/checkpoint_seal.hpp"
#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/disk.hpp"
#include "core/errors.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "partition/by_id.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

const std::string format = "unibody checkpoint 5";

bool in_range(const World& world, std::size_t first, std::size_t last, Id id) {
  const auto begin = world.id.begin() + static_cast<std::ptrdiff_t>(first),
             end = world.id.begin() + static_cast<std::ptrdiff_t>(last);
  return std::binary_search(begin, end, id);
}

// The points of the manifolds whose owner is home here, sent to the rank of the owner's block and put in the file's order.
std::vector<PointRow> point_rows(MPI_Comm comm, Id count, const World& world, const Multipliers& multipliers) {
  const IdBlocks blocks = id_blocks(comm, count);
  std::vector<PointRow> mine;
  std::vector<int> target;
  for (std::size_t i = 0; i < multipliers.manifolds.size(); ++i) {
    const RememberedManifold& m = multipliers.manifolds[i];
    const bool a_is_static = in_range(world, world.first_static(), world.size(), m.id_a);
    const Id owner = a_is_static ? m.id_b : m.id_a;
    if (!in_range(world, 0, world.homes, owner)) continue;
    for (std::size_t k = 0; k < multipliers.points_of(i).size(); ++k) mine.push_back(to_row(owner, multipliers, i, k));
    target.resize(mine.size(), blocks.owner(owner));
  }
  auto rows = exchange<PointRow>(comm, target, mine);
  std::sort(rows.begin(), rows.end(), [](const PointRow& a, const PointRow& b) { return order(a) < order(b); });
  return rows;
}

constexpr const char* id_table = "body_ids";

// count: of all that there may be. Where some are absent, the ids of the others stand beside the rows.
bool write_bodies(hid_t file, const RowsById<BodyRow>& bodies, Id count) {
  const auto first = static_cast<hsize_t>(bodies.first), total = static_cast<hsize_t>(bodies.total);
  const auto dataset = h5::create_dataset(file, "bodies", H5T_IEEE_F64LE, total, body_columns);
  const bool good = h5::write_rows(dataset, H5T_NATIVE_DOUBLE, first, bodies.rows.size(), bodies.rows.data());
  if (bodies.total == count) return good;
  const auto ids = h5::create_dataset(file, id_table, H5T_STD_I64LE, total, 1);
  return h5::write_rows(ids, H5T_NATIVE_INT64, first, bodies.ids.size(), bodies.ids.data()) && good;
}

constexpr std::size_t creep_columns = 6;
constexpr const char* creep_table = "multipliers/creep";  // a row for each point; there is none where nothing creeps

bool write_points(MPI_Comm comm, hid_t file, const std::vector<PointRow>& rows, std::int64_t total, bool has_creeps) {
  const auto mine = static_cast<std::int64_t>(rows.size());
  std::int64_t last = 0;
  check_mpi(MPI_Scan(&mine, &last, 1, MPI_INT64_T, MPI_SUM, comm));
  std::vector<std::int64_t> keys;
  std::vector<double> reals;
  for (const PointRow& p : rows) {
    keys.insert(keys.end(), {p.owner, p.id_a, p.id_b, p.place_in_manifold, p.placed});
    reals.insert(reals.end(), p.reals.begin(), p.reals.end());
  }
  const auto first = static_cast<hsize_t>(last - mine);
  const auto group = h5::create_group(file, "multipliers");
  const auto key = h5::create_dataset(group, "key", H5T_STD_I64LE, static_cast<hsize_t>(total), key_columns);
  const bool good = h5::write_rows(key, H5T_NATIVE_INT64, first, rows.size(), keys.data());
  h5::write_attribute(key, "columns", std::string("owner id_a id_b place_in_manifold placed"));
  const auto force = h5::create_dataset(group, "point", H5T_IEEE_F64LE, static_cast<hsize_t>(total), 7);
  h5::write_attribute(force, "columns", std::string("place[3] (m) normal (N) tangential[3] (N)"));
  const bool both = h5::write_rows(force, H5T_NATIVE_DOUBLE, first, rows.size(), reals.data()) && good;
  if (!has_creeps) return both;
  std::vector<double> creeps;
  for (const PointRow& p : rows) creeps.insert(creeps.end(), p.creep.begin(), p.creep.end());
  const auto creep = h5::create_dataset(file, creep_table, H5T_IEEE_F64LE, static_cast<hsize_t>(total), creep_columns);
  h5::write_attribute(creep, "columns", std::string("of a manifold's first point: slip[3] (m), turn[3] (rad)"));
  return h5::write_rows(creep, H5T_NATIVE_DOUBLE, first, rows.size(), creeps.data()) && both;
}

}  // namespace

std::string fingerprint(const std::string& scene_text) { return hex(Hash().add(std::string_view(scene_text)).value()); }

void write_checkpoint(MPI_Comm comm, const std::string& path, const std::string& fingerprint, std::int64_t frame, double time,
                      Id count, const Elements& elements, const History& history, const SceneOutline* outline) {
  const World& world = elements.world;
  const HistoryRows rows = history_rows(comm, count, elements, history);
  const JointRowBlock joints = joint_row_block(comm, elements.joints, history.joints());
  const auto bodies =
      present_by_id(comm, world, count, [&](std::size_t s) { return to_row(world.properties[s], world.state(s)); });
  const auto points = point_rows(comm, count, world, history.contacts());
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const std::string part = path + ".part";
  std::array<std::int64_t, 2> sums{static_cast<std::int64_t>(points.size()), history.contacts().creeps.empty() ? 0 : 1};
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums.data(), sums.size(), MPI_INT64_T, MPI_SUM, comm));
  const std::int64_t total = sums[0];
  const h5::Quiet quiet;
  const std::string failed = "cannot write the checkpoint " + path + ": ";
  agree<RunError>(comm, failed, [&] {
    if (rank == 0) reserve_on_disk(part, (body_columns * count + (key_columns + 10) * total) * 8 + 65536);
  });
  agree<RunError>(comm, failed, [&] {
    auto file = h5::create_file(comm, part, seal_bytes);
    h5::write_attribute(file, "format", format);
    h5::write_attribute(file, "fingerprint", fingerprint);
    h5::write_attribute(file, "frame", frame);
    h5::write_attribute(file, "time", time);
    h5::write_attribute(file, "bodies", count);
    bool good = write_past(comm, file, history);
    good = write_bodies(file, bodies, count) && good;
    good = write_points(comm, file, points, total, sums[1] > 0) && good;
    good = write_history_rows(comm, file, rows) && good;
    good = write_joint_rows(file, joints) && good;
    if (outline != nullptr) good = write_outline(comm, file, *outline) && good;
    good = H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0 && good;
    good = file.close() >= 0 && good;
    if (!good) throw std::runtime_error("is the disk full?");
  });
  agree<RunError>(comm, failed, [&] { seal_file(comm, part); });
  agree<RunError>(comm, failed, [&] {
    if (rank == 0) publish_file(part, path);
  });
}

namespace {

[[noreturn]] void damaged(const std::string& path, const std::string& why) {
  throw InputError("'" + path + "' is damaged or no checkpoint: " + why);
}

// Runs `action` and turns what HDF5 or the checks throw into an InputError about `path`.
template <class Action>
auto reading(const std::string& path, Action action) {
  const h5::Quiet quiet;
  try {
    return action();
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& e) {
    damaged(path, e.what());
  }
}

// A directory of the ranks at which bodies are home: rank by id, each rank holding one block of ids.
class Directory {
 public:
  Directory(MPI_Comm comm, Id count, const World& world) : comm_(comm), blocks_(id_blocks(comm, count)) {
    int rank = 0;
    check_mpi(MPI_Comm_rank(comm, &rank));
    first_ = blocks_.first(rank);
    homes_.assign(static_cast<std::size_t>(blocks_.size(rank)), -1);
    std::vector<int> target(world.homes);
    std::vector<Entry> mine(world.homes);
    for (std::size_t k = 0; k < world.homes; ++k) mine[k] = {world.id[k], rank}, target[k] = blocks_.owner(world.id[k]);
    for (const Entry& e : exchange<Entry>(comm, target, mine))
      homes_[static_cast<std::size_t>(e.id - first_)] = static_cast<int>(e.rank);
  }

  // Sends each point to the home ranks of its two bodies, by way of the ranks that know them.
  // Statics have no home: they are not asked for, since one rank would have to answer for all that lies on the ground.
  std::vector<PointRow> deliver(const World& world, const std::vector<PointRow>& rows) const {
    struct Addressed {
      Id id;  // whose home is to be looked up
      PointRow row;
    };
    std::vector<Addressed> ask;
    std::vector<int> target;
    for (const PointRow& p : rows)
      for (Id id : {p.id_a, p.id_b})
        if (!in_range(world, world.first_static(), world.size(), id)) ask.push_back({id, p}), target.push_back(blocks_.owner(id));
    std::vector<PointRow> send;
    std::vector<int> home;
    for (const Addressed& a : exchange<Addressed>(comm_, target, ask)) {
      const int rank = homes_[static_cast<std::size_t>(a.id - first_)];
      if (rank >= 0) send.push_back(a.row), home.push_back(rank);
    }
    return exchange<PointRow>(comm_, home, send);
  }

 private:
  struct Entry {
    std::int64_t id, rank;
  };
  MPI_Comm comm_;
  IdBlocks blocks_;
  Id first_ = 0;
  std::vector<int> homes_;
};

Multipliers assemble(std::vector<PointRow> rows, bool has_creeps) {
  const auto key = [](const PointRow& p) { return std::array{p.id_a, p.id_b, p.place_in_manifold}; };
  std::sort(rows.begin(), rows.end(), [&](const PointRow& a, const PointRow& b) { return key(a) < key(b); });
  // A pair with both bodies home here arrived twice.
  rows.erase(std::unique(rows.begin(), rows.end(), [&](const PointRow& a, const PointRow& b) { return key(a) == key(b); }),
             rows.end());
  Multipliers result;
  for (const PointRow& p : rows) {
    const auto& manifolds = result.manifolds;
    if (manifolds.empty() || manifolds.back().id_a != p.id_a || manifolds.back().id_b != p.id_b)
      result.begin_manifold(p.id_a, p.id_b);
    if (has_creeps && p.place_in_manifold == 0) result.set_last_creep({Vec3(p.creep.data()), Vec3(p.creep.data() + 3)});
    append(result, p);
  }
  return result;
}

struct PointTables {
  h5::Handle key, point, creep;  // creep: where there is one
  Id count = 0;
};

PointTables point_tables(hid_t file) {
  PointTables tables;
  tables.key = h5::open_table(file, "multipliers/key", {}, key_columns, H5T_STD_I64LE);
  tables.point = h5::open_table(file, "multipliers/point", h5::rows_of(tables.key), 7, H5T_IEEE_F64LE);
  if (h5::has_link(file, creep_table))
    tables.creep = h5::open_table(file, creep_table, h5::rows_of(tables.key), creep_columns, H5T_IEEE_F64LE);
  tables.count = static_cast<Id>(h5::rows_of(tables.key));
  return tables;
}

std::vector<PointRow> read_points(const PointTables& tables, Id first, Id last) {
  const auto n = static_cast<std::size_t>(last - first);
  std::vector<std::int64_t> keys(n * key_columns);
  std::vector<double> reals(n * 7);
  h5::read_rows(tables.key, H5T_NATIVE_INT64, static_cast<hsize_t>(first), n, keys.data());
  h5::read_rows(tables.point, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), n, reals.data());
  std::vector<PointRow> rows(n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto* i = keys.data() + k * key_columns;
    rows[k] = {i[0], i[1], i[2], i[3], i[4], {}, {}};
    std::copy_n(reals.data() + k * 7, 7, rows[k].reals.begin());
  }
  if (tables.creep < 0) return rows;
  std::vector<double> creeps(n * creep_columns);
  h5::read_rows(tables.creep, H5T_NATIVE_DOUBLE, static_cast<hsize_t>(first), n, creeps.data());
  for (std::size_t k = 0; k < n; ++k) std::copy_n(creeps.data() + k * creep_columns, creep_columns, rows[k].creep.begin());
  return rows;
}

// Throws unless the row is of a pair of bodies and follows on the one before it, if there is one: the file has them in their
// order, the points of a manifold numbered from 0, all with a place or a single one without.
void check_point(const PointRow& row, const PointRow* before, Id bodies) {
  const bool pair = row.id_a >= 0 && row.id_a < row.id_b && row.id_b < bodies && (row.owner == row.id_a || row.owner == row.id_b);
  const bool numbers = row.placed == 0 || row.placed == 1;
  const auto is_finite = [](double x) { return std::isfinite(x); };
  const bool reals = std::ranges::all_of(row.reals, is_finite) && std::ranges::all_of(row.creep, is_finite);
  const auto manifold = [](const PointRow& p) { return std::array{p.owner, p.id_a, p.id_b}; };
  const bool goes_on = before != nullptr && manifold(*before) == manifold(row);
  const bool follows = goes_on ? row.place_in_manifold == before->place_in_manifold + 1 && row.placed == 1 && before->placed == 1
                               : row.place_in_manifold == 0 && (before == nullptr || manifold(*before) < manifold(row));
  if (!pair || !numbers || !reals || !follows) throw std::runtime_error("a multiplier of no contact point");
}

// The body's numbers, which are those of an enumeration, of a place in a list, or real: anything else is no body.
Body checked_body(Id id, const BodyRow& row, bool of_same_scene) {
  const auto fail = [&](const char* what) {
    throw std::runtime_error("body " + std::to_string(id) + " has " + what + " out of range");
  };
  if (!std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); })) fail("a number");
  const auto is_whole = [](double x, double low, double high) { return x >= low && x <= high && x == std::floor(x); };
  const double *shape = row.data() + (body_columns - 4), *motion = shape + 1, *material = shape + 2, *group = shape + 3;
  if (!is_whole(*shape, 0, 0x1p40)) fail("a shape");
  if (!is_whole(*motion, 0, static_cast<double>(Motion::pinned))) fail("a motion");
  if (!is_whole(*material, 0, 0x1p31 - 1)) fail("a material");
  if (!is_whole(*group, -1, 0x1p31 - 1)) fail("a group");
  Body body = from_row(id, row);
  const Shape& of = body.properties.shape;
  if (static_cast<std::size_t>(of.kind) >= shape_names.size() || (of_same_scene && of.data >= shape_library().count(of.kind)))
    fail("a shape");
  if (!(of.size.minCoeff() >= 0)) fail("a size");
  if (!(std::abs(body.state.orientation.norm() - 1) < 1e-6)) fail("an orientation");
  if (!body.properties.is_static() && !(body.properties.mass > 0 && body.properties.inertia.minCoeff() >= 0)) fail("a mass");
  return body;
}

}  // namespace

namespace {

// Ascending, each of a body that there may be.
std::vector<Id> read_ids(hid_t file, Id count, Id present) {
  const auto table = h5::open_table(file, id_table, present, 1, H5T_STD_I64LE);
  std::vector<Id> ids(static_cast<std::size_t>(present));
  h5::read_rows(table, H5T_NATIVE_INT64, 0, ids.size(), ids.data());
  const bool ascend = std::ranges::adjacent_find(ids, std::ranges::greater_equal()) == ids.end();
  if (!ascend || (!ids.empty() && (ids.front() < 0 || ids.back() >= count)))
    throw std::runtime_error("its ids of bodies are none");
  return ids;
}

}  // namespace

Checkpoint::Checkpoint(MPI_Comm comm, const std::string& path, const std::string& fingerprint) : comm_(comm), path_(path) {
  agree<InputError>(comm, "", [&] {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) throw InputError("there is no checkpoint '" + path + "'");
  });
  agree<InputError>(comm, "", [&] { reading(path, [&] { check_seal(comm, path); }); });
  agree<InputError>(comm, "", [&] {
    reading(path, [&] {
      file_ = h5::open_file(path);
      if (h5::read_string(file_, "format") != format) throw std::runtime_error("its format is not '" + format + "'");
      const auto found = h5::read_string(file_, "fingerprint");
      if (!found.starts_with(fingerprint))
        throw InputError("'" + path + "' belongs to another scene or other overrides (fingerprint " + found + ", this scene " +
                         fingerprint + ")");
      frame_ = h5::read_integer(file_, "frame"), time_ = h5::read_double(file_, "time");
      if (frame_ < 0 || !std::isfinite(time_) || time_ < 0) throw std::runtime_error("its frame or time is out of range");
      const auto bodies = h5::open_table(file_, "bodies", {}, body_columns, H5T_IEEE_F64LE);
      count_ = h5::read_integer(file_, "bodies");
      present_ = static_cast<Id>(h5::rows_of(bodies));
      has_ids_ = h5::has_link(file_, id_table);
      if (has_ids_) ids_ = read_ids(file_, count_, present_);
      if (count_ != present_ && !has_ids_) throw std::runtime_error("its number of bodies is not that of its table");
    });
  });
}

SceneOutline Checkpoint::outline() const {
  return reading(path_, [&] { return read_outline(file_, count_); });
}

std::vector<Body> Checkpoint::read_bodies(Id first, Id last, bool of_same_scene) const {
  return reading(path_, [&] {
    if (first < 0 || last > count_ || first > last) throw std::runtime_error("it has no such bodies");
    const auto row_of = [&](Id id) -> Id { return has_ids_ ? std::ranges::lower_bound(ids_, id) - ids_.begin() : id; };
    const Id begin = row_of(first), end = row_of(last);
    std::vector<BodyRow> rows(static_cast<std::size_t>(end - begin));
    h5::read_rows(h5::open_table(file_, "bodies", present_, body_columns, H5T_IEEE_F64LE), H5T_NATIVE_DOUBLE,
                  static_cast<hsize_t>(begin), rows.size(), rows.data());
    std::vector<Body> bodies(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Id row = begin + static_cast<Id>(k);
      bodies[k] = checked_body(has_ids_ ? ids_[static_cast<std::size_t>(row)] : row, rows[k], of_same_scene);
    }
    return bodies;
  });
}

void Checkpoint::read_histories(const Elements& elements, History& history) const {
  reading(path_, [&] {
    unibody::read_histories(file_, count_, elements, history);
    read_past(file_, elements.joints == nullptr ? 0 : elements.joints->joints.size(), history);
    if (elements.joints != nullptr) history.joints() = read_joint_impulses(file_, *elements.joints->list);
  });
}

Multipliers Checkpoint::read_multipliers(const World& world) const {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm_, &rank));
  std::vector<PointRow> rows;
  bool has_creeps = false;
  agree<InputError>(comm_, "", [&] {
    rows = reading(path_, [&] {
      const PointTables tables = point_tables(file_);
      has_creeps = tables.creep >= 0;
      const IdBlocks share = id_blocks(comm_, tables.count);
      const Id first = share.first(rank), before = std::max<Id>(0, first - 1);  // the last of the rank before is looked at, too
      auto read = read_points(tables, before, share.first(rank + 1));
      for (auto k = static_cast<std::size_t>(first - before); k < read.size(); ++k)
        check_point(read[k], k > 0 ? &read[k - 1] : nullptr, count_);
      read.erase(read.begin(), read.begin() + std::min<std::ptrdiff_t>(first - before, std::ssize(read)));
      return read;
    });
  });
  return assemble(Directory(comm_, count_, world).deliver(world, rows), has_creeps);
}

}  // namespace unibody
