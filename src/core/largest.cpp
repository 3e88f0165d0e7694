#include "core/largest.hpp"

#include "core/checked.hpp"

namespace unibody {

void make_largest(MPI_Comm comm, std::span<double> values) {
  for (double& value : values) value = or_infinity(value);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values.data(), mpi_count(values.size()), MPI_DOUBLE, MPI_MAX, comm));
}

}  // namespace unibody
