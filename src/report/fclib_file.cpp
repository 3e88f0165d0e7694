#include "report/fclib_file.hpp"

#include <unistd.h>

#include <filesystem>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/disk.hpp"
#include "core/errors.hpp"
#include "core/hdf5.hpp"

namespace unibody {

namespace {

void check(bool good, const std::string& name) {
  if (!good) throw std::runtime_error("HDF5: cannot write " + name);
}

void put(hid_t group, const std::string& name, const std::vector<double>& data) {
  const auto set = h5::create_dataset(group, name, H5T_IEEE_F64LE, data.size(), 0);
  check(h5::write_rows(set, H5T_NATIVE_DOUBLE, 0, data.size(), data.data()), name);
}

void put(hid_t group, const std::string& name, const std::vector<std::int32_t>& data) {
  const auto set = h5::create_dataset(group, name, H5T_STD_I32LE, data.size(), 0);
  check(h5::write_rows(set, H5T_NATIVE_INT32, 0, data.size(), data.data()), name);
}

void put(hid_t group, const std::string& name, const std::vector<std::int64_t>& data, hsize_t columns) {
  const hsize_t rows = data.size() / std::max<hsize_t>(1, columns);
  const auto set = h5::create_dataset(group, name, H5T_STD_I64LE, rows, columns);
  check(h5::write_rows(set, H5T_NATIVE_INT64, 0, rows, data.data()), name);
}

// Writes a text as H5LTmake_dataset_string does: a scalar, closed by a zero.
void put(hid_t group, const std::string& name, const std::string& text) {
  const h5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a type");
  check(H5Tset_size(type, text.size() + 1) >= 0, name);
  const h5::Handle space(H5Screate(H5S_SCALAR), H5Sclose, "make a data space");
  const h5::Handle create(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make a property list");
  check(H5Pset_obj_track_times(create, false) >= 0, name);
  const h5::Handle set(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, create, H5P_DEFAULT), H5Dclose, "make " + name);
  check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()) >= 0, name);
}

// Writes a matrix in compressed columns, which FCLIB marks by nz = -1.
void put(hid_t parent, const std::string& name, const SparseMatrix& m) {
  const auto group = h5::create_group(parent, name);
  const auto number = [](std::int64_t n) { return std::vector<std::int32_t>{static_cast<std::int32_t>(n)}; };
  put(group, "nzmax", number(static_cast<std::int64_t>(m.value.size())));
  put(group, "m", number(m.rows)), put(group, "n", number(m.columns)), put(group, "nz", number(-1));
  put(group, "p", m.begin), put(group, "i", m.row), put(group, "x", m.value);
}

void put_info(hid_t parent, const std::string& title, const std::string& description) {
  put(parent, "spacedim", std::vector<std::int32_t>{3});
  const auto info = h5::create_group(parent, "info");
  put(info, "title", title), put(info, "description", description);
}

void put_solution(hid_t group, const ContactProblem& problem) {
  put(group, "v", problem.v()), put(group, "u", problem.u()), put(group, "r", problem.r());
}

void write_here(const std::string& path, const ContactProblem& problem, const std::string& title,
                const std::string& description) {
  const SparseMatrix W = problem.W(), M = problem.M(), H = problem.H();
  const auto entries = static_cast<std::int64_t>(W.value.size() + M.value.size() + H.value.size());
  const auto numbers = static_cast<std::int64_t>(80 * problem.contacts.size() + 100 * problem.bodies.size());
  reserve_on_disk(path, 12 * entries + 8 * numbers + 65536);
  const auto file = h5::create_file(MPI_COMM_SELF, path);
  {
    const auto local = h5::create_group(file, "fclib_local"), vectors = h5::create_group(local, "vectors");
    put_info(local, title, description);
    put(local, "W", W);
    put(vectors, "q", problem.q()), put(vectors, "mu", problem.mu());
  }
  {
    const auto global = h5::create_group(file, "fclib_global"), vectors = h5::create_group(global, "vectors");
    put_info(global, title, description);
    put(global, "M", M), put(global, "H", H);
    put(vectors, "f", problem.f()), put(vectors, "w", problem.w()), put(vectors, "mu", problem.mu());
  }
  put_solution(h5::create_group(file, "solution"), problem);
  const auto guesses = h5::create_group(file, "guesses");
  put(guesses, "number_of_guesses", std::vector<std::int32_t>{1});
  put_solution(h5::create_group(guesses, "1"), problem);
  const auto own = h5::create_group(file, "unibody");
  std::vector<std::int64_t> bodies, contacts;
  for (const auto& b : problem.bodies) bodies.push_back(b.id);
  for (const auto& c : problem.contacts) contacts.insert(contacts.end(), {c.id_a, c.id_b, c.feature});
  put(own, "bodies", bodies, 0), put(own, "contacts", contacts, 3);
}

}  // namespace

void check_fclib_path(MPI_Comm comm, const std::string& path, bool overwrite) {
  namespace fs = std::filesystem;
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::string fault;
  if (rank == 0) {
    const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
    std::error_code error;
    if (fs::exists(path, error) && !overwrite)
      fault = "'" + path + "' exists: choose another file, or -overwrite to replace it";
    else if (fs::is_directory(path, error) || access(folder.c_str(), W_OK | X_OK) != 0)
      fault = "cannot write '" + path + "'";
    if (!fault.empty()) fault = "option -dump_fclib: " + fault;
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw InputError(fault);
}

void write_fclib(MPI_Comm comm, const std::string& path, const ContactProblem& problem, const std::string& title,
                 const std::string& description) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const h5::Quiet quiet;
  const std::string part = path + ".part";
  std::string fault;
  try {
    if (rank == 0) write_here(part, problem, title, description), publish_file(part, path);
  } catch (const std::exception& e) {
    fault = "cannot write '" + path + "': " + e.what();
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw RunError(fault);
}

}  // namespace unibody
