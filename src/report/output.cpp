#include "report/output.hpp"

#include <unistd.h>

#include <array>
#include <filesystem>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/disk.hpp"
#include "core/errors.hpp"
#include "partition/by_id.hpp"
#include "report/frames_xdmf.hpp"
#include "report/shape_output.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr std::array result_files{"frames.h5",     "frames.xdmf",     "report.csv",      "summary.json",
                                  "checkpoint.h5", "joints.csv",      "joints.h5",       "contacts.h5",
                                  "contacts.xdmf", "frames.h5.links", "joints.h5.links", "contacts.h5.links"};

std::string prepare_on_one_rank(const std::string& directory, bool overwrite, const std::string& keep, bool appends) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(directory, error);
  if (!fs::is_directory(directory, error)) return "cannot make the output directory '" + directory + "': " + error.message();
  for (const char* name : result_files) {
    const fs::path path = fs::path(directory) / name;
    if (appends || !fs::exists(path)) continue;
    if (!overwrite)
      return "'" + path.string() + "' exists: choose another folder (-output), -overwrite to replace it, or -restart to go on";
    if (!keep.empty() && fs::equivalent(path, keep, error)) continue;
    if (!fs::remove(path, error)) return "cannot remove '" + path.string() + "': " + error.message();
  }
  if (access(directory.c_str(), W_OK | X_OK) != 0) return "cannot write into the output directory '" + directory + "'";
  return {};
}

std::string cannot_write(const std::string& path) { return "cannot write " + path + ": is the disk full?"; }

// Columns [column, column + width) of the rows, packed.
template <class T, std::size_t Columns>
std::vector<T> pack(const std::vector<std::array<double, Columns>>& rows, std::size_t column, std::size_t width) {
  std::vector<T> packed;
  packed.reserve(rows.size() * width);
  for (const auto& row : rows)
    for (std::size_t c = column; c < column + width; ++c) packed.push_back(static_cast<T>(row[c]));
  return packed;
}

// Writes data sets of one group, this rank's block of rows each, and remembers whether all went well.
struct BlockWriter {
  hid_t group;
  Id count, first;
  bool good = true;

  template <class T>
  void write(const std::string& name, hid_t file_type, hid_t memory_type, std::size_t columns, const std::vector<T>& data) {
    const auto rows = data.size() / std::max<std::size_t>(1, columns);
    const auto dataset = h5::create_dataset(group, name, file_type, static_cast<hsize_t>(count), columns);
    good = h5::write_rows(dataset, memory_type, static_cast<hsize_t>(first), rows, data.data()) && good;
  }
  template <std::size_t Columns>
  void reals(const std::string& name, bool single, const std::vector<std::array<double, Columns>>& rows, std::size_t column,
             std::size_t width) {
    const std::size_t columns = width == 1 ? 0 : width;
    if (single)  // converted here: HDF5 would give up collective writing to convert
      write(name, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, columns, pack<float>(rows, column, width));
    else
      write(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, columns, pack<double>(rows, column, width));
  }
};

}  // namespace

void prepare_output_directory(MPI_Comm comm, const std::string& directory, bool overwrite, const std::string& keep,
                              bool appends) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const auto fault = first_fault(comm, rank == 0 ? prepare_on_one_rank(directory, overwrite, keep, appends) : "");
  if (!fault.empty()) throw InputError(fault);
}

Output::Output(MPI_Comm comm, const std::string& directory, const OutputSettings& settings, Id count, const World& world,
               std::vector<Surface> surfaces, std::int64_t kept_to, std::optional<ChangingBodies> changing)
    : comm_(comm),
      path_(directory + "/frames.h5"),
      xdmf_path_(directory + "/frames.xdmf"),
      single_(settings.single_precision),
      count_(count),
      surfaces_(std::move(surfaces)),
      changing_(std::move(changing)) {
  check_mpi(MPI_Comm_rank(comm, &rank_));
  int goes_on = 0;
  if (rank_ == 0 && kept_to >= 0) goes_on = std::filesystem::exists(path_) ? 1 : 0;
  check_mpi(MPI_Bcast(&goes_on, 1, MPI_INT, 0, comm));
  if (goes_on != 0)
    extend(kept_to);
  else
    create(world);
}

void Output::create(const World& world) {
  Id corners = 0;
  for (const Surface& surface : surfaces_) corners += surface.count * surface.corners + 4 * surface.tetrahedron_count;
  reserve(10 * count_ + corners);
  const h5::Quiet quiet;
  std::string fault;
  try {
    file_ = h5::create_file(comm_, path_);
    h5::write_attribute(file_, "format", std::string("unibody frames 1"));
    write_bodies(world);
    write_surfaces();
    write_shapes();
    frames_.create(comm_, file_, path_);
  } catch (const std::exception& e) {
    fault = e.what();
  }
  throw_if_any(fault);
  throw_if_any(rank_ == 0 && !xdmf_.start(xdmf_path_) ? "cannot write " + xdmf_path_ : "");
}

void Output::extend(std::int64_t kept_to) {
  const h5::Quiet quiet;
  agree<InputError>(comm_, "'" + path_ + "' cannot be gone on with: ", [&] {
    const h5::Handle old = h5::open_file(path_);
    const auto ids = h5::open_dataset(old, "bodies/id"), sizes = h5::open_dataset(old, "bodies/size");
    const h5::Handle real(H5Dget_type(sizes), H5Tclose, "get the type of bodies/size");
    if (h5::dimensions(ids)[0] != static_cast<hsize_t>(count_)) throw std::runtime_error("it is of another number of bodies");
    if (H5Tget_size(real) != (single_ ? 4U : 8U)) throw std::runtime_error("it has another output.precision");
  });
  std::string fault;
  try {
    file_ = h5::open_file_to_extend(comm_, path_);
    frames_.extend(comm_, file_, path_, kept_to);
  } catch (const std::exception& e) {
    fault = e.what();
  }
  throw_if_any(fault);
  std::vector<double> times;
  std::vector<Id> rows;
  const std::vector<std::int64_t>& kept = frames_.kept();
  for (const std::int64_t frame : kept) {
    const h5::Handle group(H5Gopen2(frames_, h5::numbered(frame).c_str(), H5P_DEFAULT), H5Gclose,
                           "open group " + h5::numbered(frame));
    times.push_back(h5::read_double(group, "time"));
    rows.push_back(static_cast<Id>(h5::dimensions(h5::open_dataset(group, "position"))[0]));
  }
  bool good = rank_ != 0 || xdmf_.start(xdmf_path_);
  for (std::size_t k = 0; k < kept.size() && rank_ == 0 && good; ++k) good = append_xdmf(kept[k], times[k], rows[k]);
  throw_if_any(good ? "" : "cannot write " + xdmf_path_);
}

void Output::close() {
  const h5::Quiet quiet;
  bool good = frames_.close();
  good = file_.close() >= 0 && good;
  good = xdmf_.close() && good;
  throw_if_any(good ? "" : cannot_write(path_));
}

Output::~Output() {
  const h5::Quiet quiet;
  frames_.let_go();
  file_.close();
}

void Output::throw_if_any(const std::string& fault) const {
  const auto first = first_fault(comm_, fault);
  if (!first.empty()) throw RunError(first);
}

// Room for so many numbers and the frame's own records.
void Output::reserve(Id numbers) const {
  std::string fault;
  try {
    if (rank_ == 0) reserve_on_disk(path_, numbers * 8 + 65536);
  } catch (const std::exception& e) {
    fault = e.what();
  }
  throw_if_any(fault);
}

void Output::write_bodies(const World& world) {
  const auto row_of = [](const BodyProperties& p) {
    const bool dynamic = !p.is_static(), plane = p.shape.kind == ShapeKind::plane;
    const Vec3 size = plane ? Vec3::Zero() : p.shape.size, moments = dynamic ? p.inertia : Vec3::Zero();
    return std::array<double, 11>{size[0],
                                  size[1],
                                  size[2],
                                  dynamic ? p.mass : 0,
                                  moments[0],
                                  moments[1],
                                  moments[2],
                                  static_cast<double>(p.shape.kind),
                                  static_cast<double>(p.motion),
                                  static_cast<double>(p.material),
                                  static_cast<double>(p.shape.data)};
  };
  const auto of_world = [&](std::size_t slot) { return row_of(world.properties[slot]); };
  const Id first = id_blocks(comm_, count_).first(rank_);
  std::vector<std::array<double, 11>> rows;
  if (changing_)  // as the scene has them, whether they are there or not
    for (Id id = first; id < id_blocks(comm_, count_).first(rank_ + 1); ++id)
      rows.push_back(row_of(changing_->body_of(id).properties));
  else
    rows = rows_by_id(comm_, world, count_, of_world);
  std::vector<std::int64_t> ids(rows.size());
  for (std::size_t k = 0; k < ids.size(); ++k) ids[k] = first + static_cast<Id>(k);

  const auto group = h5::create_group(file_, "bodies");
  BlockWriter writer{group, count_, first};
  writer.write("id", H5T_STD_I64LE, H5T_NATIVE_INT64, 0, ids);
  writer.write("shape", H5T_STD_I8LE, H5T_NATIVE_INT8, 0, pack<std::int8_t>(rows, 7, 1));
  writer.reals("size", single_, rows, 0, 3);
  writer.reals("mass", single_, rows, 3, 1);
  writer.reals("inertia", single_, rows, 4, 3);
  writer.write("motion", H5T_STD_I8LE, H5T_NATIVE_INT8, 0, pack<std::int8_t>(rows, 8, 1));
  writer.write("material", H5T_STD_I32LE, H5T_NATIVE_INT32, 0, pack<std::int32_t>(rows, 9, 1));
  const ShapeLibrary& library = shape_library();
  if (!library.hulls.empty() || !library.compounds.empty() || !library.meshes.empty())
    writer.write("shape_number", H5T_STD_I32LE, H5T_NATIVE_INT32, 0, pack<std::int32_t>(rows, 10, 1));
  throw_if_any(writer.good ? "" : cannot_write(path_));
  std::string names;
  for (const auto name : shape_names) names.append(names.empty() ? "" : " ").append(name);
  h5::write_attribute(group, "shape_names", names);
  h5::write_attribute(group, "motion_names", std::string("dynamic fixed kinematic pinned"));
}

void Output::write_surfaces() {
  if (surfaces_.empty()) return;
  const auto group = h5::create_group(file_, "surfaces");
  bool good = true;
  for (std::size_t n = 0; n < surfaces_.size(); ++n) {
    const Surface& surface = surfaces_[n];
    const auto own = h5::create_group(group, h5::numbered(static_cast<std::int64_t>(n)));
    const auto write_cells = [&](const char* name, Id count, int corners, const auto& cell_at) {
      const IdBlocks blocks = id_blocks(comm_, count);
      std::vector<std::int64_t> ids;
      for (Id k = blocks.first(rank_); k < blocks.first(rank_ + 1); ++k) {
        const auto cell = cell_at(k);
        ids.insert(ids.end(), cell.begin(), cell.begin() + corners);
      }
      BlockWriter writer{own, count, blocks.first(rank_)};
      writer.write(name, H5T_STD_I64LE, H5T_NATIVE_INT64, static_cast<std::size_t>(corners), ids);
      good = writer.good && good;
    };
    write_cells("cells", surface.count, surface.corners, surface.cell);
    if (surface.tetrahedron_count > 0) write_cells("tetrahedra", surface.tetrahedron_count, 4, surface.tetrahedron);
    if (changing_) {  // the same by the places of nodes among nodes
      const auto among_nodes = [this](auto ids) {
        for (Id& id : ids) id -= changing_->first_node;
        return ids;
      };
      write_cells("node_cells", surface.count, surface.corners, [&](Id k) { return among_nodes(surface.cell(k)); });
      if (surface.tetrahedron_count > 0)
        write_cells("node_tetrahedra", surface.tetrahedron_count, 4, [&](Id k) { return among_nodes(surface.tetrahedron(k)); });
    }
    if (surface.elasticity) {
      const Id count = surface.tetrahedron_count > 0 ? surface.tetrahedron_count : surface.count;
      const IdBlocks blocks = id_blocks(comm_, count);
      std::vector<std::array<double, 2>> rows;
      for (Id k = blocks.first(rank_); k < blocks.first(rank_ + 1); ++k) rows.push_back(surface.elasticity(k));
      BlockWriter writer{own, count, blocks.first(rank_)};
      writer.reals("elasticity", single_, rows, 0, 2);
      good = writer.good && good;
    }
    if (!surface.energy_volume.empty()) h5::write_attribute(own, "energy_volume", surface.energy_volume);
    h5::write_attribute(own, "name", surface.name.empty() ? "surface " + std::to_string(n) : surface.name);
  }
  throw_if_any(good ? "" : cannot_write(path_));
}

// Rank 0 writes the shapes for all; nothing is written where the library is empty.
void Output::write_shapes() {
  const ShapeLibrary& library = shape_library();
  const std::size_t counts[] = {library.hulls.size(), library.meshes.size(), library.compounds.size()};
  if (counts[0] + counts[1] + counts[2] == 0) return;
  const auto group = h5::create_group(file_, "shapes");
  bool good = true;
  const auto write = [&](const std::string& name, auto&& fill) {
    const auto own = h5::create_group(group, name);
    good = fill(own) && good;
  };
  const auto rows_of = [&]<class T, std::size_t n>(const h5::Handle& own, const char* name, hid_t file_type, hid_t memory_type,
                                                   const std::vector<std::array<T, n>>& rows) {
    std::vector<T> flat;
    if (rank_ == 0)
      for (const auto& row : rows) flat.insert(flat.end(), row.begin(), row.end());
    BlockWriter writer{own, static_cast<Id>(rows.size()), 0};
    writer.write(name, file_type, memory_type, n, flat);
    return writer.good;
  };
  for (int k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < counts[k]; ++i)
      write((k == 0 ? "hull_" : "mesh_") + std::to_string(i), [&](const h5::Handle& own) {
        const ShapeSurface s = surface_of(k == 0 ? ShapeKind::hull : ShapeKind::mesh, i);
        return rows_of(own, "nodes", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, s.nodes) &&
               rows_of(own, "triangles", H5T_STD_I64LE, H5T_NATIVE_INT64, s.triangles);
      });
  for (std::size_t i = 0; i < counts[2]; ++i)
    write("compound_" + std::to_string(i),
          [&](const h5::Handle& own) { return rows_of(own, "parts", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, part_rows(i)); });
  throw_if_any(good ? "" : cannot_write(path_));
}

void Output::write(std::int64_t frame, double time, const World& world) {
  const auto present = present_by_id(comm_, world, count_, [&](std::size_t slot) {
    const BodyState s = world.state(slot);
    const Vec3 x = world.period.wrapped(s.position), &v = s.velocity, &w = s.angular_velocity;
    const Quat& q = s.orientation;
    return std::array<double, 13>{x[0], x[1], x[2], q.w(), q.x(), q.y(), q.z(), v[0], v[1], v[2], w[0], w[1], w[2]};
  });
  if (!changing_) check_block_complete(comm_, id_blocks(comm_, count_), static_cast<Id>(present.rows.size()));
  const auto& rows = present.rows;
  reserve((changing_ ? 20 : 13) * present.total);
  const h5::Quiet quiet;
  std::string fault;
  try {
    const auto group = h5::create_unlinked_group(file_);
    BlockWriter writer{group, present.total, present.first};
    writer.reals("position", single_, rows, 0, 3);
    writer.reals("orientation", single_, rows, 3, 4);
    writer.reals("velocity", single_, rows, 7, 3);
    writer.reals("angular_velocity", single_, rows, 10, 3);
    if (changing_) writer.good = write_present(group, present) && writer.good;
    h5::write_attribute(group, "time", time);
    h5::write_attribute(group, "frame", frame);
    if (!writer.good || !frames_.add(group, frame)) fault = cannot_write(path_);
  } catch (const std::exception& e) {
    fault = e.what();
  }
  throw_if_any(fault);
  throw_if_any(rank_ == 0 && !append_xdmf(frame, time, present.total) ? cannot_write(xdmf_path_) : "");
}

Id Output::nodes() const { return changing_ ? count_ - changing_->first_node : 0; }

// What a frame says beside states where bodies come and go: who is there, and the nodes of surfaces by themselves.
bool Output::write_present(hid_t group, const RowsById<std::array<double, 13>>& present) {
  BlockWriter writer{group, present.total, present.first};
  std::vector<std::int64_t> row(present.ids.size());
  std::vector<std::array<double, 4>> of_body;
  std::vector<std::array<double, 13>> of_node;
  for (std::size_t k = 0; k < row.size(); ++k) {
    row[k] = present.first + static_cast<Id>(k);
    const Shape shape = changing_->body_of(present.ids[k]).properties.shape;
    const Vec3 size = shape.kind == ShapeKind::plane ? Vec3(Vec3::Zero()) : shape.size;
    of_body.push_back({size[0], size[1], size[2], static_cast<double>(shape.kind)});
    if (present.ids[k] >= changing_->first_node) of_node.push_back(present.rows[k]);
  }
  writer.write("id", H5T_STD_I64LE, H5T_NATIVE_INT64, 0, present.ids);
  writer.write("row", H5T_STD_I64LE, H5T_NATIVE_INT64, 0, row);
  writer.reals("size", single_, of_body, 0, 3);
  writer.write("shape", H5T_STD_I8LE, H5T_NATIVE_INT8, 0, pack<std::int8_t>(of_body, 3, 1));
  if (nodes() == 0) return writer.good;
  BlockWriter node_writer{group, nodes(), std::max<Id>(0, present.first - (present.total - nodes()))};  // nodes come last
  node_writer.reals("node_position", single_, of_node, 0, 3);
  node_writer.reals("node_velocity", single_, of_node, 7, 3);
  return writer.good && node_writer.good;
}

// One write puts the new frame and the closing tags over the old closing tags, so that the file is whole before and after.
bool Output::append_xdmf(std::int64_t frame, double time, Id rows) {
  const FramesXdmf text{single_, surfaces_, changing_.has_value(), nodes()};
  return xdmf_.append(text.frame(frame, time, rows));
}

}  // namespace unibody
