#include "core/memory.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

namespace unibody {

double bytes_of_machine() {
  double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double most = 0;
    if (std::ifstream(file) >> most && most > 0) bytes = std::min(bytes, most);  // "max": no number
  }
  return bytes;
}

double bytes_of_process() {
  rlimit limit{};
  const bool bounded = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return bounded ? static_cast<double>(limit.rlim_cur) : std::numeric_limits<double>::infinity();
}

void give_freed_memory_back() {
#ifdef __GLIBC__
  // An array of this size or more gets a mapping of its own, which the system takes back when the array is freed. Smaller
  // arrays are made and freed in each step, and their memory stays with the process. No result depends on whether glibc obeys.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // B, the most that glibc takes
  mallopt(M_MMAP_MAX, 65536);           // mappings, as glibc has it by itself
#endif
}

}  // namespace unibody
