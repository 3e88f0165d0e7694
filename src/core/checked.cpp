#include "core/checked.hpp"

#include <petscsys.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace unibody {

void end_all_ranks(const std::string& what, const char* path, int line) {
  int is_ready = 0, is_over = 0, rank = 0;
  const bool asked = MPI_Initialized(&is_ready) == MPI_SUCCESS && MPI_Finalized(&is_over) == MPI_SUCCESS;
  const bool runs = asked && is_ready != 0 && is_over == 0;
  if (runs && MPI_Comm_rank(MPI_COMM_WORLD, &rank) != MPI_SUCCESS) rank = -1;
  std::string name = path;
  if (const auto slash = name.rfind('/'); slash != std::string::npos) name.erase(0, slash + 1);
  std::fprintf(stderr, "unibody: rank %d: %s (%s:%d)\n", rank, what.c_str(), name.c_str(), line);
  std::fflush(nullptr);
  if (runs) MPI_Abort(MPI_COMM_WORLD, 3);
  std::_Exit(3);  // where MPI does not run, or did not end the program
}

void fail_mpi(int code, const char* file, int line) {
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  const bool known = MPI_Error_string(code, text.data(), &length) == MPI_SUCCESS && length > 0;
  end_all_ranks("MPI failed: " + (known ? std::string(text.data()) : "error " + std::to_string(code)), file, line);
}

void fail_petsc(int code, const char* file, int line) {
  const char* text = nullptr;
  const bool known = PetscErrorMessage(code, &text, nullptr) == 0 && text != nullptr;
  end_all_ranks("PETSc failed: " + (known ? std::string(text) : "error") + " (" + std::to_string(code) + ")", file, line);
}

int mpi_count(std::size_t count, const char* file, int line) {
  if (count > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    end_all_ranks(std::to_string(count) + " records in one message, more than MPI can count: more ranks are needed", file, line);
  return static_cast<int>(count);
}

}  // namespace unibody
