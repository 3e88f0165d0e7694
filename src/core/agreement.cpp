#include "core/agreement.hpp"

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr double patience = 10;  // s

void wait_for_all(MPI_Request& request, const std::string& fault) {
  if (fault.empty()) return check_mpi(MPI_Wait(&request, MPI_STATUS_IGNORE));
  const double start = MPI_Wtime();
  for (int done = 0; done == 0;) {
    check_mpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE));
    if (done == 0 && MPI_Wtime() - start > patience) end_all_ranks(fault, __FILE__, __LINE__);
  }
}

}  // namespace

std::string first_fault(MPI_Comm comm, const std::string& fault) {
  int rank = 0, ranks = 1;
  check_mpi(MPI_Comm_rank(comm, &rank)), check_mpi(MPI_Comm_size(comm, &ranks));
  int first = fault.empty() ? ranks : rank;
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Iallreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm, &request));
  wait_for_all(request, fault);
  if (first == ranks) return {};
  int size = mpi_count(fault.size());
  check_mpi(MPI_Bcast(&size, 1, MPI_INT, first, comm));
  std::string text = fault;
  text.resize(static_cast<std::size_t>(size));
  check_mpi(MPI_Bcast(text.data(), size, MPI_CHAR, first, comm));
  return text;
}

}  // namespace unibody
