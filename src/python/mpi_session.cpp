#include "python/mpi_session.hpp"

#include <petscsys.h>

#include <memory>

#include "app/petsc_session.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/hdf5.hpp"

namespace unibody {

namespace {

namespace py = pybind11;

std::unique_ptr<PetscSession> petsc;

}  // namespace

void start_mpi(const py::object& close_all) {
  if (petsc) return;
  h5::avoid_shared_semaphores();
  int runs = 0;
  check_mpi(MPI_Initialized(&runs));
  if (runs == 0) check_mpi(MPI_Init(nullptr, nullptr));
  // Simulations of a few processes each may start at any time: none waits for processes that have none.
  PetscBool petsc_runs = PETSC_FALSE;
  check_petsc(PetscInitialized(&petsc_runs));
  if (petsc_runs == PETSC_FALSE) PETSC_COMM_WORLD = MPI_COMM_SELF;
  petsc = std::make_unique<PetscSession>(MPI_COMM_SELF, std::vector<std::string>{"-no_signal_handler"});
  const bool ends_mpi = runs == 0;
  py::module_::import("atexit").attr("register")(py::cpp_function([close_all, ends_mpi] {
    close_all();
    petsc.reset();
    int ended = 0;
    check_mpi(MPI_Finalized(&ended));
    if (ends_mpi && ended == 0) check_mpi(MPI_Finalize());
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
