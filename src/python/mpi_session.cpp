#include "python/mpi_session.hpp"

#include <memory>

#include "core/errors.hpp"
#include "library/session.hpp"

namespace unibody {

namespace {

namespace py = pybind11;

std::unique_ptr<LibrarySession> session;

}  // namespace

void start_mpi(const py::object& close_all) {
  if (session) return;
  session = std::make_unique<LibrarySession>();
  py::module_::import("atexit").attr("register")(py::cpp_function([close_all] {
    close_all();
    session.reset();
  }));
}

MPI_Comm communicator_of(const py::object& comm) {
  if (comm.is_none()) return MPI_COMM_WORLD;
  if (!py::hasattr(comm, "py2f"))
    throw InputError("comm: found an object of type " + py::str(py::type::of(comm).attr("__name__")).cast<std::string>() +
                     ", expected None or a communicator of mpi4py");
  const MPI_Comm found = MPI_Comm_f2c(comm.attr("py2f")().cast<MPI_Fint>());
  if (found == MPI_COMM_NULL) throw InputError("comm: found the communicator of no process, expected another one");
  return found;
}

}  // namespace unibody
