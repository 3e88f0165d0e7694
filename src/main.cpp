#include <petscsys.h>

#include <cstdio>

#include "app/options.hpp"
#include "app/run.hpp"
#include "core/before_mpi.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/memory.hpp"

namespace {

int fail(int rank, const char* what, int code) {
  if (rank == 0) std::fprintf(stderr, "unibody: %s\n", what);
  return code;
}

int guarded_run(int argc, char** argv, int rank) {
  try {
    const int code = unibody::run(MPI_COMM_WORLD, unibody::parse_options(argc, argv));
    const bool told = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    return told || rank != 0 ? code : fail(rank, "cannot write to the standard output: is the disk full?", 3);
  } catch (const unibody::InputError& error) {
    return fail(rank, error.what(), 2);
  } catch (const unibody::RunError& error) {
    return fail(rank, error.what(), 3);
  } catch (const std::exception& error) {  // not foreseen, so perhaps on this rank alone: the others must not wait for it
    std::fprintf(stderr, "unibody: rank %d: %s\n", rank, error.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
    return 3;
  }
}

}  // namespace

int main(int argc, char** argv) {
  unibody::give_freed_memory_back();
  unibody::choose_for_mpi();
  unibody::check_mpi(MPI_Init(&argc, &argv));
  int rank = 0;
  unibody::check_mpi(MPI_Comm_rank(MPI_COMM_WORLD, &rank));
  const int code = guarded_run(argc, argv, rank);
  unibody::check_mpi(MPI_Finalize());
  return code;
}
