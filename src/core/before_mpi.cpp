#include "core/before_mpi.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace unibody {

namespace {

// Each launcher gives the ranks that it starts one of these: mpirun, srun with PMIx, srun or Hydra with PMI.
bool has_launcher() {
  constexpr std::array given{"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"};
  return std::any_of(given.begin(), given.end(), [](const char* name) { return std::getenv(name) != nullptr; });
}

void choose(const char* name, const char* value) { setenv(name, value, 0); }

}  // namespace

void choose_for_mpi() {
  choose("OMPI_MCA_sharedfp", "^sm");
  if (has_launcher()) return;
  choose("OMPI_MCA_ess_singleton_isolated", "1");
  choose("OMPI_MCA_orte_create_session_dirs", "0");
}

}  // namespace unibody
