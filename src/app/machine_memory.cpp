#include "app/machine_memory.hpp"

#include <algorithm>
#include <cstdio>
#include <new>

#include "core/checked.hpp"
#include "core/largest.hpp"
#include "core/memory.hpp"

namespace unibody {

Room room_of(MPI_Comm comm) {
  MPI_Comm machine = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  Room room;
  int neighbours = 1;
  check_mpi(MPI_Comm_size(machine, &neighbours));
  check_mpi(MPI_Comm_free(&machine));
  check_mpi(MPI_Comm_size(comm, &room.ranks));
  room.bytes = smallest_of_ranks(comm, std::min(bytes_of_machine() / neighbours, bytes_of_process()));
  return room;
}

namespace {

// Where memory runs out on one rank, the others must not wait for it: it ends the run where it stands, without unwinding, since
// much of what would be freed is freed by all ranks together.
long long bodies_in_scene = 0;
void out_of_memory() {
  int rank = 0, size = 1;
  check_mpi(MPI_Comm_rank(MPI_COMM_WORLD, &rank));
  check_mpi(MPI_Comm_size(MPI_COMM_WORLD, &size));
  std::fprintf(stderr,
               "unibody: rank %d: out of memory, with %lld bodies on %d rank%s: fewer bodies or more machines are needed\n", rank,
               bodies_in_scene, size, size == 1 ? "" : "s");
  MPI_Abort(MPI_COMM_WORLD, 3);
}

}  // namespace

void end_run_out_of_memory() { std::set_new_handler(out_of_memory); }
void tell_bodies_in_scene(long long bodies) { bodies_in_scene = bodies; }

}  // namespace unibody
