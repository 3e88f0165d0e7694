#include "checkpoint/checkpoint_seal.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"

namespace unibody {

namespace {

constexpr std::uint64_t block = 1 << 20;  // bytes hashed at a time
const std::string title = "unibody checkpoint 5\n";

std::string seal_text(std::uint64_t bytes, std::uint64_t hash) {
  std::string text = title + "bytes behind this block: " + std::to_string(bytes) + "\nhash of them: " + hex(hash) + "\n";
  text.resize(seal_bytes, '\0');
  return text;
}

std::uint64_t size_of(std::ifstream& file) {
  file.seekg(0, std::ios::end);
  const auto end = file.tellg();
  if (!file || end < 0) throw std::runtime_error("it cannot be read");
  return static_cast<std::uint64_t>(end);
}

// The sum of the hashes of this rank's blocks, those whose number is its own modulo the number of ranks.
std::uint64_t hash_of_share(std::ifstream& file, std::uint64_t bytes, int rank, int ranks) {
  std::vector<char> buffer(block);
  std::uint64_t sum = 0;
  for (auto number = static_cast<std::uint64_t>(rank); number * block < bytes; number += static_cast<std::uint64_t>(ranks)) {
    const std::uint64_t length = std::min(block, bytes - number * block);
    file.seekg(static_cast<std::streamoff>(seal_bytes + number * block));
    if (!file.read(buffer.data(), static_cast<std::streamsize>(length))) throw std::runtime_error("it cannot be read");
    sum += Hash().add(number).add(std::string_view(buffer.data(), length)).value();
  }
  return sum;
}

struct Contents {
  std::uint64_t bytes = 0, hash = 0;
  std::string seal;  // what stands in the file
};

// What every rank finds in the file behind the seal. Throws on every rank.
Contents contents_of(MPI_Comm comm, const std::string& path) {
  int rank = 0, ranks = 1;
  check_mpi(MPI_Comm_rank(comm, &rank)), check_mpi(MPI_Comm_size(comm, &ranks));
  Contents found;
  std::string fault;
  try {
    std::ifstream file(path, std::ios::binary);
    const std::uint64_t size = size_of(file);
    if (size <= seal_bytes) throw std::runtime_error("it is too short");
    found.seal.resize(seal_bytes);
    file.seekg(0);
    if (!file.read(found.seal.data(), seal_bytes)) throw std::runtime_error("it cannot be read");
    found.bytes = size - seal_bytes;
    found.hash = hash_of_share(file, found.bytes, rank, ranks);
  } catch (const std::runtime_error& error) {
    fault = error.what();
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw std::runtime_error(fault);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &found.hash, 1, MPI_UINT64_T, MPI_SUM, comm));
  return found;
}

}  // namespace

void seal_file(MPI_Comm comm, const std::string& path) {
  const Contents found = contents_of(comm, path);
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::string fault;
  if (rank == 0) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const std::string text = seal_text(found.bytes, found.hash);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    file.close();
    if (!file) fault = "cannot write the seal: is the disk full?";
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw std::runtime_error(fault);
}

void check_seal(MPI_Comm comm, const std::string& path) {
  const Contents found = contents_of(comm, path);
  std::string fault;
  if (!found.seal.starts_with(title))
    fault = "it does not begin with '" + title.substr(0, title.size() - 1) + "'";
  else if (found.seal != seal_text(found.bytes, found.hash))
    fault = "it does not hold what was written there: bits have changed, or some are missing";
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw std::runtime_error(fault);
}

}  // namespace unibody
