#include "report/state_hash.hpp"

#include "core/checked.hpp"
#include "core/hash.hpp"

namespace unibody {

namespace {

std::uint64_t body_hash(Id id, const BodyState& s) {
  Hash hash;
  hash.add(id);
  for (int k = 0; k < 3; ++k) hash.add(s.position[k]);
  hash.add(s.orientation.w()).add(s.orientation.x()).add(s.orientation.y()).add(s.orientation.z());
  for (int k = 0; k < 3; ++k) hash.add(s.velocity[k]);
  for (int k = 0; k < 3; ++k) hash.add(s.angular_velocity[k]);
  return hash.value();
}

}  // namespace

// The id is part of each body's hash, so the hashes may be added in any order, modulo 2^64: no body needs to travel.
std::uint64_t state_hash(MPI_Comm comm, const World& world) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::uint64_t sum = 0;
  for (std::size_t slot = 0; slot < world.homes; ++slot) sum += body_hash(world.id[slot], world.state(slot));
  for (std::size_t slot = world.first_static(); rank == 0 && slot < world.size(); ++slot)
    sum += body_hash(world.id[slot], world.state(slot));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  return Hash().add(sum).value();
}

}  // namespace unibody
