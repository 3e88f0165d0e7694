// HDF5 with the few calls this program needs: handles that close themselves, rows written collectively, errors as exceptions.
#pragma once

#include <hdf5.h>
#include <mpi.h>

#include <string>
#include <utility>
#include <vector>

namespace unibody::h5 {

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

// Collective. Neither stamps objects with the time, so that equal contents are equal bytes.
Handle create_file(MPI_Comm comm, const std::string& path);
Handle open_file(MPI_Comm comm, const std::string& path);  // to read
Handle create_group(hid_t parent, const std::string& name);

// A contiguous data set of rows x columns (columns 0: one-dimensional), allocated at once: its place in the file does not depend
// on the number of ranks. Collective.
Handle create_dataset(hid_t parent, const std::string& name, hid_t type, hsize_t rows, hsize_t columns);

// Rows [first, first + count) of this rank. Writing is collective, also for ranks that have none; it says whether it went well
// instead of throwing, since the other ranks go on to the next collective call. Reading is not collective, and throws.
[[nodiscard]] bool write_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, const void* data);
void read_rows(hid_t dataset, hid_t memory_type, hsize_t first, hsize_t count, void* data);
std::vector<hsize_t> dimensions(hid_t dataset);
Handle open_dataset(hid_t parent, const std::string& name);

// Attributes. Collective where they write.
void write_attribute(hid_t object, const std::string& name, double value);
void write_attribute(hid_t object, const std::string& name, std::int64_t value);
void write_attribute(hid_t object, const std::string& name, const std::string& value);
double read_double(hid_t object, const std::string& name);
std::int64_t read_integer(hid_t object, const std::string& name);
std::string read_string(hid_t object, const std::string& name);

}  // namespace unibody::h5

namespace unibody {

// The first rank's non-empty fault, on every rank; empty when none has one. Collective.
std::string first_fault(MPI_Comm comm, const std::string& fault);

}  // namespace unibody
