// The memory's bandwidth: a[i] = b[i] + s c[i] over arrays that fit no cache, on all ranks at once. Prints GB/s of the best of
// ten passes, 24 bytes an element counted.
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <vector>

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0, size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  const std::size_t n = 40'000'000 / static_cast<std::size_t>(size);  // 3 x 320 MB in all
  std::vector<double> a(n, 0), b(n, 1), c(n, 2);
  double best = 1e30;
  for (int pass = 0; pass < 10; ++pass) {
    const double s = 1 + 1e-3 * pass;
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + s * c[i];
    MPI_Barrier(MPI_COMM_WORLD);
    best = std::min(best, MPI_Wtime() - start);
    std::swap(a, b);  // so that no pass can be left out
  }
  const double check = a[n / 2];
  if (rank == 0 && check > 0) std::printf("%.2f\n", 24.0 * static_cast<double>(n) * size / best / 1e9);
  MPI_Finalize();
}
