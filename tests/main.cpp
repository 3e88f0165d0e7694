// Runs GoogleTest under MPI: every rank runs every test; rank 0 prints, and a failure on any rank fails the program on all.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "core/before_mpi.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  unibody::choose_for_mpi();
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 3;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
  }
  int failed = RUN_ALL_TESTS();
  if (failed != 0 && rank != 0) {
    const auto& unit = *testing::UnitTest::GetInstance();
    for (int s = 0; s < unit.total_test_suite_count(); ++s) {
      const auto& suite = *unit.GetTestSuite(s);
      for (int t = 0; t < suite.total_test_count(); ++t) {
        const auto& info = *suite.GetTestInfo(t);
        if (info.should_run() && info.result()->Failed())
          fprintf(stderr, "rank %d: %s.%s failed: %s\n", rank, suite.name(), info.name(),
                  info.result()->GetTestPartResult(0).message());
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  PetscFinalize();
  return failed;
}
