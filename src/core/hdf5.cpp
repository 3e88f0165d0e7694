#include "core/hdf5.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <stdexcept>

#include "core/checked.hpp"

namespace unibody::h5 {

void check(herr_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error("HDF5: cannot " + what);
}

namespace {

// MPI_COMM_NULL: of one rank, without MPI-IO.
Handle file_access(MPI_Comm comm) {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make a property list");
  if (comm != MPI_COMM_NULL) check(H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL), "use MPI-IO");
  // The format of HDF5 1.8: objects without times, and no mark in the file that a killed run would leave behind.
  check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "choose a file format");
  return access;
}

// Removes PATH-NUMBER-NUMBER.lock, in which Open MPI would keep the shared pointer of the file: it holds it open, and a run that
// is killed leaves nothing behind.
void remove_pointer_files(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const std::string begin = fs::path(path).filename().string() + "-";
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin) || !name.ends_with(".lock")) continue;
    const std::string_view numbers = std::string_view(name).substr(begin.size(), name.size() - begin.size() - 5);
    if (numbers.find_first_not_of("0123456789-") == std::string_view::npos) fs::remove(entry->path(), error);
  }
}

// After all ranks have opened the file. Collective.
void remove_what_mpi_keeps(MPI_Comm comm, const std::string& path) {
  check_mpi(MPI_Barrier(comm));
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  if (rank == 0) remove_pointer_files(path);
}

Handle row_space(hid_t dataset, hsize_t first, hsize_t count) {
  Handle space(H5Dget_space(dataset), H5Sclose, "get a data space");
  if (count == 0) return check(H5Sselect_none(space), "select rows"), std::move(space);
  std::vector<hsize_t> extent = dimensions(dataset), start(extent.size(), 0);
  if (extent.empty()) throw std::runtime_error("HDF5: a data set without rows");
  start[0] = first, extent[0] = count;
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr), "select rows");
  return space;
}

Handle memory_space(hid_t file_space) {
  const hssize_t selected = H5Sget_select_npoints(file_space);
  check(selected < 0 ? -1 : 0, "count what is selected");
  const auto count = static_cast<hsize_t>(selected);
  Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose, "make a data space");
  if (count == 0) check(H5Sselect_none(space), "select nothing");
  return space;
}

Handle table_space(hsize_t rows, hsize_t columns) {
  const std::array<hsize_t, 2> extent{rows, columns};
  return Handle(H5Screate_simple(columns == 0 ? 1 : 2, extent.data(), nullptr), H5Sclose, "make a data space");
}

Handle allocated_at_once() {
  Handle create(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make a property list");
  check(H5Pset_obj_track_times(create, false), "turn times off");
  check(H5Pset_layout(create, H5D_CONTIGUOUS), "choose a layout");
  check(H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY), "choose when to allocate");
  check(H5Pset_fill_time(create, H5D_FILL_TIME_NEVER), "turn filling off");
  return create;
}

void write_scalar(hid_t object, const std::string& name, hid_t type, hid_t memory_type, const void* value) {
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, "make a data space");
  Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "make attribute " + name);
  check(H5Awrite(attribute, memory_type, value), "write attribute " + name);
}

// An attribute that holds one value of that class.
Handle open_attribute(hid_t object, const std::string& name, H5T_class_t kind, const std::string& expected) {
  Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "find attribute " + name);
  const Handle space(H5Aget_space(attribute), H5Sclose, "get a data space"), type(H5Aget_type(attribute), H5Tclose, "get a type");
  if (H5Sget_simple_extent_type(space) != H5S_SCALAR || H5Tget_class(type) != kind)
    throw std::runtime_error("attribute " + name + " is not " + expected);
  return attribute;
}

std::string bracketed(const std::vector<hsize_t>& extent) {
  std::string text;
  for (const hsize_t n : extent) text.append(text.empty() ? "" : ", ").append(std::to_string(n));
  return "[" + text + "]";
}

}  // namespace

Handle::Handle(hid_t id, Close closer, const std::string& what) : id_(id), close_(closer) {
  if (id < 0) throw std::runtime_error("HDF5: cannot " + what);
}

herr_t Handle::close() { return id_ < 0 ? 0 : close_(std::exchange(id_, H5I_INVALID_HID)); }

Quiet::Quiet() {
  check(H5Eget_auto2(H5E_DEFAULT, &function_, &data_), "find how faults are printed");
  check(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), "stop printing faults");
}
Quiet::~Quiet() { static_cast<void>(H5Eset_auto2(H5E_DEFAULT, function_, data_)); }  // in vain: more is printed, no more

Handle create_file(MPI_Comm comm, const std::string& path, hsize_t user_block) {
  const Handle access = file_access(comm);
  Handle create(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "make a property list");
  check(H5Pset_obj_track_times(create, false), "turn times off");
  check(H5Pset_userblock(create, user_block), "leave room at the start");
  Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, create, access), H5Fclose, "create " + path);
  remove_what_mpi_keeps(comm, path);
  return file;
}

Handle open_file_to_extend(MPI_Comm comm, const std::string& path) {
  const Handle access = file_access(comm);
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, access), H5Fclose, "open " + path);
  remove_what_mpi_keeps(comm, path);
  return file;
}

Handle open_file_to_mend(const std::string& path) {
  const Handle access = file_access(MPI_COMM_NULL);
  return Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, access), H5Fclose, "open " + path);
}

std::string numbered(std::int64_t number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%06lld", static_cast<long long>(number));
  return text.data();
}

std::vector<std::int64_t> member_numbers(hid_t parent, const std::string& group) {
  std::vector<std::int64_t> numbers;
  const Handle opened(H5Gopen2(parent, group.c_str(), H5P_DEFAULT), H5Gclose, "open group " + group);
  H5G_info_t info{};
  check(H5Gget_info(opened, &info), "list " + group);
  for (hsize_t k = 0; k < info.nlinks; ++k) {
    std::array<char, 32> text{};
    const auto size = H5Lget_name_by_idx(opened, ".", H5_INDEX_NAME, H5_ITER_INC, k, text.data(), text.size(), H5P_DEFAULT);
    check(size < 0 ? -1 : 0, "list " + group);
    if (size == 0 || size >= static_cast<ssize_t>(text.size())) continue;
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + size, number);
    if (error == std::errc() && end == text.data() + size) numbers.push_back(number);
  }
  std::ranges::sort(numbers);
  return numbers;
}

void remove_link(hid_t parent, const std::string& name) { check(H5Ldelete(parent, name.c_str(), H5P_DEFAULT), "remove " + name); }

Handle open_file(const std::string& path) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make a property list");
  return Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "open " + path);
}

Handle create_group(hid_t parent, const std::string& name) {
  Handle create(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "make a property list");
  check(H5Pset_obj_track_times(create, false), "turn times off");
  return Handle(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, create, H5P_DEFAULT), H5Gclose, "make group " + name);
}

Handle create_unlinked_group(hid_t file) {
  const Handle create(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "make a property list");
  check(H5Pset_obj_track_times(create, false), "turn times off");
  return Handle(H5Gcreate_anon(file, create, H5P_DEFAULT), H5Gclose, "make a group");
}

Handle create_dataset(hid_t parent, const std::string& name, hid_t type, hsize_t rows, hsize_t columns) {
  const Handle space = table_space(rows, columns), create = allocated_at_once();
  return Handle(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, create, H5P_DEFAULT), H5Dclose,
                "make data set " + name);
}

Handle create_unlinked_dataset(hid_t file, hid_t type, hsize_t rows, hsize_t columns) {
  const Handle space = table_space(rows, columns), create = allocated_at_once();
  return Handle(H5Dcreate_anon(file, type, space, create, H5P_DEFAULT), H5Dclose, "make a data set");
}

bool write_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, const void* data) {
  if (dimensions(dataset)[0] == 0) return true;  // on all ranks alike; HDF5 has allocated nothing to write to
  const Handle file_space = row_space(dataset, first, count), memory = memory_space(file_space);
  Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "make a property list");
  check(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE), "write collectively");
  const double nothing = 0;  // HDF5 wants an address even where nothing is written
  return H5Dwrite(dataset, memory_type, memory, file_space, transfer, count == 0 ? &nothing : data) >= 0;
}

void read_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, void* data) {
  if (count == 0) return;
  const Handle file_space = row_space(dataset, first, count), memory = memory_space(file_space);
  check(H5Dread(dataset, memory_type, memory, file_space, H5P_DEFAULT, data), "read rows");
}

std::vector<hsize_t> dimensions(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose, "get a data space");
  const int rank = H5Sget_simple_extent_ndims(space);
  check(rank, "get the number of dimensions");
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr), "get the extents");
  return extent;
}

Handle open_dataset(hid_t parent, const std::string& name) {
  return Handle(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "find data set " + name);
}

Handle open_table(hid_t parent, const std::string& name, std::optional<hsize_t> rows, hsize_t columns, hid_t type) {
  Handle dataset = open_dataset(parent, name);
  const Handle stored(H5Dget_type(dataset), H5Tclose, "get the type of " + name),
      made(H5Dget_create_plist(dataset), H5Pclose, "get the layout of " + name);
  const auto extent = dimensions(dataset);
  const std::string is = "table " + name + " is " + bracketed(extent);
  if (extent.size() != 2 || extent[1] != columns || (rows && extent[0] != *rows))
    throw std::runtime_error(is + ": expected [" + (rows ? std::to_string(*rows) : "N") + ", " + std::to_string(columns) + "]");
  if (H5Tequal(stored, type) <= 0) throw std::runtime_error(is + " of numbers of another type");
  hsize_t in_file = 0;
  const Handle file(H5Iget_file_id(dataset), H5Fclose, "find the file");
  check(H5Fget_filesize(file, &in_file), "get the size of the file");
  const hsize_t row = columns * H5Tget_size(type);
  if (H5Pget_layout(made) != H5D_CONTIGUOUS || (row > 0 && extent[0] > in_file / row) ||
      H5Dget_storage_size(dataset) != (extent[0] * row))
    throw std::runtime_error(is + ", which is not all in the file");
  return dataset;
}

hsize_t rows_of(hid_t table) { return dimensions(table).at(0); }

bool has_attribute(hid_t object, const std::string& name) {
  const htri_t found = H5Aexists(object, name.c_str());
  check(found, "look for " + name);
  return found > 0;
}

bool has_link(hid_t parent, const std::string& name) {
  const htri_t found = H5Lexists(parent, name.c_str(), H5P_DEFAULT);
  check(found, "look for " + name);
  return found > 0;
}

void write_attribute(hid_t object, const std::string& name, double value) {
  write_scalar(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void write_attribute(hid_t object, const std::string& name, std::int64_t value) {
  write_scalar(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void write_attribute(hid_t object, const std::string& name, const std::string& value) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a type");
  check(H5Tset_size(type, std::max<std::size_t>(1, value.size())), "size a string");
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), "pad a string");
  write_scalar(object, name, type, type, value.c_str());
}

double read_double(hid_t object, const std::string& name) {
  double value = 0;
  check(H5Aread(open_attribute(object, name, H5T_FLOAT, "one real number"), H5T_NATIVE_DOUBLE, &value), "read attribute " + name);
  return value;
}

std::int64_t read_integer(hid_t object, const std::string& name) {
  std::int64_t value = 0;
  check(H5Aread(open_attribute(object, name, H5T_INTEGER, "one whole number"), H5T_NATIVE_INT64, &value),
        "read attribute " + name);
  return value;
}

std::string read_string(hid_t object, const std::string& name) {
  constexpr std::size_t longest = 1 << 16;
  const std::string expected = "one text of up to " + std::to_string(longest) + " bytes";
  const Handle attribute = open_attribute(object, name, H5T_STRING, expected);
  const Handle type(H5Aget_type(attribute), H5Tclose, "get a type");
  const std::size_t size = H5Tget_size(type);
  if (H5Tis_variable_str(type) != 0 || size == 0 || size > longest)
    throw std::runtime_error("attribute " + name + " is not " + expected);
  std::string value(size, '\0');
  check(H5Aread(attribute, type, value.data()), "read attribute " + name);
  value.resize(value.find('\0') == std::string::npos ? value.size() : value.find('\0'));
  return value;
}

}  // namespace unibody::h5
