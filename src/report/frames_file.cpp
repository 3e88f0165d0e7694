#include "report/frames_file.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

#include "core/errors.hpp"

namespace unibody {

namespace {

constexpr hsize_t any_rows = HSIZE_UNDEF;

std::string numbered(const std::string& group, std::int64_t number) { return group + "/" + h5::numbered(number); }

h5::Handle open_group(hid_t file, const std::string& name) {
  return {H5Gopen2(file, name.c_str(), H5P_DEFAULT), H5Gclose, "open group " + name};
}

// The file in a folder of results; says why there is none.
std::string file_of(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  constexpr const char* expected = ": expected the output folder of a run of unibody, or its frames.h5";
  if (!fs::exists(path, error)) throw InputError("there is no '" + path + "'" + expected);
  if (!fs::is_directory(path, error)) return path;
  const auto file = (fs::path(path) / "frames.h5").string();
  if (!fs::exists(file, error)) throw InputError("there is no frames.h5 in '" + path + "'" + expected);
  return file;
}

}  // namespace

FramesFile::FramesFile(const std::string& path) : path_(file_of(path)) {
  const h5::Quiet quiet;
  try {
    file_ = h5::open_file(path_);
  } catch (const std::runtime_error&) {
    refuse("can't be opened as an HDF5 file: expected the frames.h5 of a run of unibody");
  }
  if (!h5::has_link(file_, "frames")) refuse("has no group /frames: expected the frames.h5 of a run of unibody");
  frames_ = h5::member_numbers(file_, "frames");
  if (frames_.empty()) refuse("holds no frame yet: expected one at least");
  const std::string first = numbered("/frames", frames_.front()), name = first + "/position";
  body_count_ =
      static_cast<Id>(h5::has_link(file_, first + "/id") ? h5::dimensions(h5::open_dataset(file_, "bodies/id"))[0]
                                                         : h5::dimensions(open_array(name, any_rows, {3}, H5T_FLOAT))[0]);
}

void FramesFile::refuse(const std::string& fault) const { throw InputError("'" + path_ + "' " + fault); }

h5::Handle FramesFile::open_array(const std::string& name, hsize_t rows, std::initializer_list<hsize_t> columns,
                                  H5T_class_t kind) const {
  const hid_t id = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
  if (id < 0) refuse("has no dataset " + name);
  h5::Handle dataset(id, H5Dclose, "open " + name);
  const h5::Handle type(H5Dget_type(dataset), H5Tclose, "get the type of " + name);
  const auto extent = h5::dimensions(dataset);
  const bool fits = extent.size() == 2 && (rows == any_rows || extent[0] == rows) &&
                    std::find(columns.begin(), columns.end(), extent[1]) != columns.end() && H5Tget_class(type) == kind;
  if (fits) {
    const hsize_t bytes = extent[0] * extent[1] * H5Tget_size(type);
    if (extent[0] > (hsize_t{1} << 48) || H5Dget_storage_size(dataset) != bytes) refuse(name + " is not all in the file");
    return dataset;
  }
  std::string found, expected = rows == any_rows ? "N" : std::to_string(rows);
  for (const hsize_t n : extent) found.append(found.empty() ? "" : ", ").append(std::to_string(n));
  expected.append(", ").append(std::to_string(*columns.begin()));
  for (auto it = columns.begin() + 1; it != columns.end(); ++it) expected.append(" or ").append(std::to_string(*it));
  refuse(name + " is [" + found + "]: expected [" + expected + "] " + (kind == H5T_FLOAT ? "real" : "whole") + " numbers");
}

std::vector<FramesFile::Cells> FramesFile::surfaces() const {
  const h5::Quiet quiet;
  if (!h5::has_link(file_, "surfaces")) refuse("has no group /surfaces: expected the results of a scene with cloths or threads");
  std::vector<Cells> result;
  for (const std::int64_t number : h5::member_numbers(file_, "surfaces")) {
    const std::string group = numbered("/surfaces", number), name = group + "/cells";
    const auto dataset = open_array(name, any_rows, {3, 2}, H5T_INTEGER);
    const auto extent = h5::dimensions(dataset);
    Cells surface;
    surface.corners = static_cast<int>(extent[1]);
    std::vector<Id> ids(static_cast<std::size_t>(extent[0] * extent[1]));
    h5::read_rows(dataset, H5T_NATIVE_INT64, 0, extent[0], ids.data());
    for (auto id = ids.begin(); id != ids.end(); id += surface.corners) {
      std::array<Id, 3> cell{-1, -1, -1};
      std::copy(id, id + surface.corners, cell.begin());
      surface.cells.push_back(cell);
    }
    for (const Id id : ids)
      if (id < 0 || id >= body_count_)
        refuse(name + " names body " + std::to_string(id) + ": expected 0 to " + std::to_string(body_count_ - 1));
    const auto own = open_group(file_, group);
    const bool named = h5::has_attribute(own, "name");
    surface.name = named ? h5::read_string(own, "name") : "surface " + std::to_string(number);
    result.push_back(std::move(surface));
  }
  if (result.empty()) refuse("has no surface in /surfaces: expected the results of a scene with cloths or threads");
  return result;
}

double FramesFile::time(std::int64_t frame) const {
  const h5::Quiet quiet;
  const std::string group = numbered("/frames", frame);
  if (!h5::has_link(file_, group)) refuse("has no group " + group);
  const auto own = open_group(file_, group);
  if (!h5::has_attribute(own, "time")) refuse("has no attribute time (s) at " + group);
  return h5::read_double(own, "time");
}

// Of those that are there, and 0 of the others.
void FramesFile::read_present(const std::string& name, const std::string& ids_name, std::vector<Vec3>& out) const {
  const auto ids_table = h5::open_dataset(file_, ids_name);
  const auto extent = h5::dimensions(ids_table);
  if (extent.size() != 1 || extent[0] > static_cast<hsize_t>(body_count_)) refuse(ids_name + " is no list of bodies");
  std::vector<Id> ids(extent[0]);
  std::vector<Vec3> places(extent[0]);
  h5::read_rows(ids_table, H5T_NATIVE_INT64, 0, extent[0], ids.data());
  h5::read_rows(open_array(name, extent[0], {3}, H5T_FLOAT), H5T_NATIVE_DOUBLE, 0, extent[0], places.data());
  out.assign(static_cast<std::size_t>(body_count_), Vec3::Zero());
  for (std::size_t k = 0; k < ids.size(); ++k) {
    if (ids[k] < 0 || ids[k] >= body_count_) refuse(ids_name + " names body " + std::to_string(ids[k]) + ", which there is not");
    out[static_cast<std::size_t>(ids[k])] = places[k];
  }
}

void FramesFile::positions(std::int64_t frame, std::vector<Vec3>& out) const {
  const h5::Quiet quiet;
  const std::string name = numbered("/frames", frame) + "/position";
  const auto rows = static_cast<hsize_t>(body_count_);
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const std::string ids_name = numbered("/frames", frame) + "/id";
  if (!h5::has_link(file_, ids_name)) {
    const auto dataset = open_array(name, rows, {3}, H5T_FLOAT);
    out.resize(rows);
    h5::read_rows(dataset, H5T_NATIVE_DOUBLE, 0, rows, out.data());
  } else {
    read_present(name, ids_name, out);
  }
  for (std::size_t k = 0; k < out.size(); ++k)
    if (!out[k].allFinite()) refuse(name + " of body " + std::to_string(k) + " is not finite: expected a place (m)");
}

}  // namespace unibody
