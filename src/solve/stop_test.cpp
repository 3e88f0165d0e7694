#include "solve/stop_test.hpp"

#include <mpi.h>

#include <algorithm>

#include "core/checked.hpp"

namespace unibody {

bool StopTest::passes(double change) {
  residual_ = std::ranges::max(residuals(system_));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &residual_, 1, MPI_DOUBLE, MPI_MAX, exchange_.comm()));
  if (residual_ <= tolerance_) return true;
  // A little less than where the two would be in proportion, and never so soon that it is measured in every iteration.
  worth_measuring_ = change * std::min(0.7, 0.9 * tolerance_ / residual_);
  return false;
}

}  // namespace unibody
