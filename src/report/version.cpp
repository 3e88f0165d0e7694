#include "report/version.hpp"

#include <hdf5.h>
#include <metis.h>
#include <mpi.h>
#include <petscversion.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "core/checked.hpp"

// CMakeLists.txt has the version and finds the commit.
#ifndef UNIBODY_VERSION
#define UNIBODY_VERSION "unknown"
#endif
#ifndef UNIBODY_COMMIT
#define UNIBODY_COMMIT "unknown"
#endif

namespace unibody {

namespace {

std::string dotted(int a, int b, int c) { return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c); }

std::string version_of_mpi() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  check_mpi(MPI_Get_library_version(text.data(), &length));
  std::string mpi(text.data(), static_cast<std::size_t>(length));
  mpi.resize(std::min(mpi.size(), mpi.find_first_of(",\n")));
  constexpr std::string_view of_mpich = " Version:\t";  // "MPICH Version:\t4.0.2\n..."; Open MPI says "Open MPI v4.1.4, ..."
  if (const auto at = mpi.find(of_mpich); at != std::string::npos) mpi.replace(at, of_mpich.size(), " ");
  return mpi;
}

std::string compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "gcc " __VERSION__;
#else
  return "unknown";
#endif
}

}  // namespace

std::vector<std::pair<std::string, std::string>> versions() {
  unsigned a = 0, b = 0, c = 0;
  H5get_libversion(&a, &b, &c);
  return {{"unibody", UNIBODY_VERSION},
          {"commit", UNIBODY_COMMIT},
          {"compiler", compiler()},
          {"petsc", dotted(PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
          {"mpi", version_of_mpi()},
          {"hdf5", dotted(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c))},
          {"metis", dotted(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)}};
}

std::string version_text() {
  std::string text;
  for (const auto& [what, which] : versions()) text += what + " " + which + "\n";
  return text;
}

}  // namespace unibody
