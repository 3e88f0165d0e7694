#include "core/disk.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace unibody {

namespace {

// 0, or why `bytes` more do not fit behind the end of the open file.
int reserve(int file, std::int64_t bytes) {
  struct stat status {};
  if (fstat(file, &status) != 0) return errno;
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      static_cast<rlim_t>(status.st_size + bytes) > limit.rlim_cur)
    return EFBIG;
  if (fallocate(file, FALLOC_FL_KEEP_SIZE, status.st_size, bytes) == 0) return 0;
  if (errno != EOPNOTSUPP && errno != ENOSYS) return errno;
  struct statvfs disk {};  // a file system that cannot reserve: the free space is the best there is to ask for
  if (fstatvfs(file, &disk) != 0) return 0;
  return static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) < static_cast<double>(bytes) ? ENOSPC : 0;
}

void force(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags);
  const bool good = file >= 0 && ::fsync(file) == 0;
  if (file >= 0) ::close(file);
  if (!good) throw std::runtime_error("cannot force '" + path + "' to the disk");
}

}  // namespace

void reserve_on_disk(const std::string& path, std::int64_t bytes) {
  const int file = ::open(path.c_str(), O_CREAT | O_WRONLY, 0644);
  const int error = file < 0 ? errno : reserve(file, bytes);
  if (file >= 0) ::close(file);
  if (error != 0)
    throw std::runtime_error("no room for " + std::to_string(bytes) + " bytes in '" + path + "': " + std::strerror(error));
}

void publish_file(const std::string& temporary, const std::string& path) {
  force(temporary, O_RDONLY);
  if (std::rename(temporary.c_str(), path.c_str()) != 0)
    throw std::runtime_error("cannot rename '" + temporary + "' to '" + path + "'");
  const auto directory = std::filesystem::path(path).parent_path().string();
  force(directory.empty() ? "." : directory, O_RDONLY | O_DIRECTORY);
}

}  // namespace unibody
