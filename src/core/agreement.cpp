#include "core/agreement.hpp"

#include "core/checked.hpp"

namespace unibody {

std::string first_fault(MPI_Comm comm, const std::string& fault) {
  int rank = 0, ranks = 1;
  check_mpi(MPI_Comm_rank(comm, &rank)), check_mpi(MPI_Comm_size(comm, &ranks));
  int first = fault.empty() ? ranks : rank;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first == ranks) return {};
  int size = mpi_count(fault.size());
  check_mpi(MPI_Bcast(&size, 1, MPI_INT, first, comm));
  std::string text = fault;
  text.resize(static_cast<std::size_t>(size));
  check_mpi(MPI_Bcast(text.data(), size, MPI_CHAR, first, comm));
  return text;
}

}  // namespace unibody
