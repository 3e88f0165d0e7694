// Preloaded into the program, counts what each rank tells the others: calls and bytes of MPI by phase of the run, function and
// tag. UNIBODY_COUNTS names a folder that exists; when the run ends, rank R writes R.csv there: phase, function, tag, calls,
// bytes. Bytes are those that a rank sends, of collectives those that it puts in. The program says by MPI_Pcontrol which phase it
// is in.
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <mpi.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace {

constexpr int no_tag = -1;

struct Count {
  std::int64_t calls = 0, bytes = 0;
};

class Counts {
 public:
  void enter(int phase) { phase_ = phase; }

  void add(const char* function, int tag, std::int64_t bytes) {
    Count& count = found_[{phase_, function, tag}];
    ++count.calls, count.bytes += bytes;
  }

  // What a request that is started again and again sends each time.
  void prepare(MPI_Request request, int tag, std::int64_t bytes) { prepared_[request] = {tag, bytes}; }
  void start(MPI_Request request) {
    const auto sends = prepared_.find(request);
    if (sends != prepared_.end()) add("MPI_Start", sends->second.first, sends->second.second);
  }

  void write() const {
    const char* const folder = std::getenv("UNIBODY_COUNTS");
    int rank = 0;
    if (folder == nullptr || PMPI_Comm_rank(MPI_COMM_WORLD, &rank) != MPI_SUCCESS) return;
    const std::string path = std::string(folder) + "/" + std::to_string(rank) + ".csv";
    std::FILE* const file = std::fopen(path.c_str(), "w");
    if (file == nullptr) return std::perror(path.c_str());
    std::fputs("phase,function,tag,calls,bytes\n", file);
    for (const auto& [key, count] : found_)
      std::fprintf(file, "%d,%s,%d,%lld,%lld\n", std::get<0>(key), std::get<1>(key).c_str(), std::get<2>(key),
                   static_cast<long long>(count.calls), static_cast<long long>(count.bytes));
    if (std::fclose(file) != 0) std::perror(path.c_str());
  }

 private:
  int phase_ = 0;
  std::map<std::tuple<int, std::string, int>, Count> found_;
  std::map<MPI_Request, std::pair<int, std::int64_t>> prepared_;
};

Counts& counts() {
  static Counts all;
  return all;
}

std::int64_t bytes_of(std::int64_t count, MPI_Datatype type) {
  int size = 0;
  return PMPI_Type_size(type, &size) == MPI_SUCCESS ? count * size : 0;
}

std::int64_t sum_of(const int* counts_of_ranks, MPI_Comm comm) {
  int ranks = 0;
  std::int64_t sum = 0;
  if (PMPI_Comm_size(comm, &ranks) == MPI_SUCCESS)
    for (int r = 0; r < ranks; ++r) sum += counts_of_ranks[r];
  return sum;
}

}  // namespace

extern "C" {

int MPI_Pcontrol(const int level, ...) {
  counts().enter(level);
  return MPI_SUCCESS;
}

int MPI_Finalize() {
  counts().write();
  return PMPI_Finalize();
}

#define COUNT_SEND(name, ...)                                                                                               \
  int MPI_##name(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm __VA_OPT__(, MPI_Request* r)) { \
    counts().add("MPI_" #name, tag, bytes_of(n, type));                                                                     \
    return PMPI_##name(data, n, type, to, tag, comm __VA_OPT__(, r));                                                       \
  }
COUNT_SEND(Send)
COUNT_SEND(Ssend)
COUNT_SEND(Isend, request)
COUNT_SEND(Issend, request)

int MPI_Send_init(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  const int code = PMPI_Send_init(data, n, type, to, tag, comm, request);
  counts().prepare(*request, tag, bytes_of(n, type));
  return code;
}
int MPI_Start(MPI_Request* request) {
  counts().start(*request);
  return PMPI_Start(request);
}
int MPI_Startall(int n, MPI_Request requests[]) {
  for (int i = 0; i < n; ++i) counts().start(requests[i]);
  return PMPI_Startall(n, requests);
}

int MPI_Barrier(MPI_Comm comm) {
  counts().add("MPI_Barrier", no_tag, 0);
  return PMPI_Barrier(comm);
}
int MPI_Ibarrier(MPI_Comm comm, MPI_Request* request) {
  counts().add("MPI_Ibarrier", no_tag, 0);
  return PMPI_Ibarrier(comm, request);
}
int MPI_Bcast(void* data, int n, MPI_Datatype type, int root, MPI_Comm comm) {
  counts().add("MPI_Bcast", no_tag, bytes_of(n, type));
  return PMPI_Bcast(data, n, type, root, comm);
}
int MPI_Reduce(const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, int root, MPI_Comm comm) {
  counts().add("MPI_Reduce", no_tag, bytes_of(n, type));
  return PMPI_Reduce(from, to, n, type, op, root, comm);
}
int MPI_Allreduce(const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  counts().add("MPI_Allreduce", no_tag, bytes_of(n, type));
  return PMPI_Allreduce(from, to, n, type, op, comm);
}
int MPI_Iallreduce(const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request* request) {
  counts().add("MPI_Iallreduce", no_tag, bytes_of(n, type));
  return PMPI_Iallreduce(from, to, n, type, op, comm, request);
}
int MPI_Exscan(const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  counts().add("MPI_Exscan", no_tag, bytes_of(n, type));
  return PMPI_Exscan(from, to, n, type, op, comm);
}
int MPI_Scan(const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  counts().add("MPI_Scan", no_tag, bytes_of(n, type));
  return PMPI_Scan(from, to, n, type, op, comm);
}
int MPI_Gather(const void* from, int n, MPI_Datatype type, void* to, int m, MPI_Datatype type_there, int root, MPI_Comm comm) {
  counts().add("MPI_Gather", no_tag, bytes_of(n, type));
  return PMPI_Gather(from, n, type, to, m, type_there, root, comm);
}
int MPI_Allgather(const void* from, int n, MPI_Datatype type, void* to, int m, MPI_Datatype type_there, MPI_Comm comm) {
  counts().add("MPI_Allgather", no_tag, from == MPI_IN_PLACE ? bytes_of(m, type_there) : bytes_of(n, type));
  return PMPI_Allgather(from, n, type, to, m, type_there, comm);
}
int MPI_Allgatherv(const void* from, int n, MPI_Datatype type, void* to, const int* m, const int* places, MPI_Datatype type_there,
                   MPI_Comm comm) {
  counts().add("MPI_Allgatherv", no_tag, from == MPI_IN_PLACE ? 0 : bytes_of(n, type));
  return PMPI_Allgatherv(from, n, type, to, m, places, type_there, comm);
}
int MPI_Alltoall(const void* from, int n, MPI_Datatype type, void* to, int m, MPI_Datatype type_there, MPI_Comm comm) {
  int ranks = 0;
  PMPI_Comm_size(comm, &ranks);
  counts().add("MPI_Alltoall", no_tag, ranks * bytes_of(n, type));
  return PMPI_Alltoall(from, n, type, to, m, type_there, comm);
}
int MPI_Alltoallv(const void* from, const int* n, const int* places, MPI_Datatype type, void* to, const int* m,
                  const int* places_there, MPI_Datatype type_there, MPI_Comm comm) {
  counts().add("MPI_Alltoallv", no_tag, bytes_of(sum_of(n, comm), type));
  return PMPI_Alltoallv(from, n, places, type, to, m, places_there, type_there, comm);
}

}  // extern "C"
