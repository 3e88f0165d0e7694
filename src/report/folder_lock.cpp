#include "report/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"

namespace unibody {

namespace {

std::string this_process() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  return "process " + std::to_string(getpid()) + " on " + host.data();
}

std::string holder_of(int file) {
  std::array<char, 320> text{};
  const ssize_t length = pread(file, text.data(), text.size() - 1, 0);
  return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : "another process";
}

// Whether the open file is still the one of that name: its holder may have removed it since it was opened.
bool is_at(int file, const std::string& path) {
  struct stat open_one {
  }, named{};
  return fstat(file, &open_one) == 0 && stat(path.c_str(), &named) == 0 && open_one.st_ino == named.st_ino &&
         open_one.st_dev == named.st_dev;
}

// Returns the descriptor of the locked file.
int lock_file(const std::string& path, const std::string& directory) {
  for (;;) {
    const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file < 0) throw std::runtime_error("cannot write into the output directory '" + directory + "': " + std::strerror(errno));
    const int error = flock(file, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (error == EWOULDBLOCK) {
      const std::string holder = holder_of(file);
      ::close(file);
      throw std::runtime_error("another run, " + holder + ", writes into '" + directory +
                               "': choose another output directory, or wait until it has ended");
    }
    if (error != 0)
      std::fprintf(stderr, "unibody: '%s' cannot be locked (%s): take care that no other run writes there\n", directory.c_str(),
                   std::strerror(error));
    if (is_at(file, path)) {
      const std::string text = this_process();
      if (ftruncate(file, 0) == 0 && pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size())) return file;
      const int why = errno;
      ::close(file);
      throw std::runtime_error("cannot write '" + path + "': " + std::strerror(why));
    }
    ::close(file);
  }
}

}  // namespace

FolderLock::FolderLock(MPI_Comm comm, const std::string& directory) : path_(directory + "/unibody.lock") {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  agree<InputError>(comm, "", [&] {
    if (rank != 0) return;
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (!std::filesystem::is_directory(directory, error))
      throw std::runtime_error("cannot make the output directory '" + directory + "': " + error.message());
    file_ = lock_file(path_, directory);
  });
}

FolderLock::~FolderLock() {
  if (file_ < 0) return;
  static_cast<void>(::unlink(path_.c_str()));  // where that fails the file stays, unlocked
  static_cast<void>(::close(file_));
}

}  // namespace unibody
