// While one lives no other run writes into the same folder, of whatever host, where the file system knows locks.
#pragma once

#include <mpi.h>

#include <string>

namespace unibody {

// Holds the file `unibody.lock` in the folder locked; the operating system unlocks it where the run is killed, and the file that
// is then left behind stops nobody.
class FolderLock {
 public:
  // Makes the folder where it is missing. Throws InputError on every rank where that fails, or where another run holds the lock,
  // which the message names. Collective.
  FolderLock(MPI_Comm comm, const std::string& directory);
  ~FolderLock();  // removes the file
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;  // rank 0: file descriptor
};

}  // namespace unibody
