// HDF5 with the few calls this program needs: handles that close themselves, rows written collectively, errors as exceptions.
#pragma once

#include <hdf5.h>
#include <mpi.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace unibody::h5 {

// Throws std::runtime_error saying `what` failed where the result of a call of HDF5 is negative.
void check(herr_t result, const std::string& what);

// Owns an HDF5 identifier. Negative identifiers throw std::runtime_error saying `what` failed.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close closer, const std::string& what);
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_), std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  herr_t close();  // now, with its result

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

// While one lives, HDF5 prints nothing: faults are reported by exceptions.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

// Collective. Neither stamps objects with the time, so that equal contents are equal bytes. user_block: bytes at the start of the
// file that HDF5 leaves alone, 0 or a power of two from 512 on.
Handle create_file(MPI_Comm comm, const std::string& path, hsize_t user_block = 0);
Handle create_group(hid_t parent, const std::string& name);

// A group, or a data set as create_dataset() makes it, that has no name yet. Collective.
Handle create_unlinked_group(hid_t file);
Handle create_unlinked_dataset(hid_t file, hid_t type, hsize_t rows, hsize_t columns);

// The name of a member that has a number: of six digits, or more where it needs them.
std::string numbered(std::int64_t number);

// Opens a file to write more into it. Collective.
Handle open_file_to_extend(MPI_Comm comm, const std::string& path);
// The same of one rank, while no other has it open.
Handle open_file_to_mend(const std::string& path);
// The numbers that a group's members have as names, ascending; other names are left out.
std::vector<std::int64_t> member_numbers(hid_t parent, const std::string& group);
// Removes a group or a data set from the file, which does not become smaller by it. Collective.
void remove_link(hid_t parent, const std::string& name);

// Opens a file to read, each rank for itself. Not collective.
Handle open_file(const std::string& path);

// A contiguous data set of rows x columns (columns 0: one-dimensional), allocated at once: its place in the file does not depend
// on the number of ranks. Collective.
Handle create_dataset(hid_t parent, const std::string& name, hid_t type, hsize_t rows, hsize_t columns);

// Rows [first, first + count) of this rank. Writing is collective, also for ranks that have none; it says whether it went well
// instead of throwing, since the other ranks go on to the next collective call. Reading is not collective, and throws.
[[nodiscard]] bool write_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, const void* data);
void read_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, void* data);
std::vector<hsize_t> dimensions(hid_t dataset);
Handle open_dataset(hid_t parent, const std::string& name);
bool has_link(hid_t parent, const std::string& name);

// Opens a data set of rows x columns numbers for reading, and throws std::runtime_error unless it has that many rows (none: any
// number), that many columns, numbers of that very type of the file, and lies whole and in one piece in the file. To be asked
// before anything of the size of a data set is allocated.
Handle open_table(hid_t parent, const std::string& name, std::optional<hsize_t> rows, hsize_t columns, hid_t type);
hsize_t rows_of(hid_t table);

// Attributes of one value each. Collective where they write. Reading throws std::runtime_error unless the attribute is one value
// of the kind that is asked for.
void write_attribute(hid_t object, const std::string& name, double value);
void write_attribute(hid_t object, const std::string& name, std::int64_t value);
void write_attribute(hid_t object, const std::string& name, const std::string& value);
bool has_attribute(hid_t object, const std::string& name);
double read_double(hid_t object, const std::string& name);
std::int64_t read_integer(hid_t object, const std::string& name);
std::string read_string(hid_t object, const std::string& name);

}  // namespace unibody::h5
