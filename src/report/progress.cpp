#include "report/progress.hpp"

#include <mpi.h>
#include <unistd.h>

#include <cstdio>

namespace unibody {

Progress::Progress(int rank, std::int64_t first, std::int64_t last, Id bodies, double tolerance)
    : rank_(rank),
      terminal_(isatty(STDOUT_FILENO) != 0),
      first_(first),
      last_(last),
      bodies_(bodies),
      tolerance_(tolerance),
      start_(MPI_Wtime()) {}

void Progress::frame_done(const FrameReport& report) {
  if (rank_ != 0) return;
  const double now = MPI_Wtime(), wait = terminal_ ? 0.1 : 5;
  const bool final = report.step == last_;
  if (!final && now - printed_ < wait) return;
  printed_ = now;
  const double a_frame = (now - start_) / static_cast<double>(report.step - first_);
  const auto left = static_cast<std::int64_t>(a_frame * static_cast<double>(last_ - report.step) + 0.5);
  std::printf(
      "%sframe %lld/%lld  t %.3f s  residual %.2e m%s  penetration %.2e m  iterations %lld  %.1f ms/frame  %.2g bodies/s  left "
      "%lld:%02lld",
      terminal_ ? "\r\033[K" : "", static_cast<long long>(report.step), static_cast<long long>(last_), report.time,
      report.natural_residual, report.converged || tolerance_ == 0 ? "" : " (not converged)", report.measures.penetration_max,
      static_cast<long long>(report.iterations), 1e3 * a_frame, static_cast<double>(bodies_) / a_frame,
      static_cast<long long>(left / 60), static_cast<long long>(left % 60));
  if (!terminal_ || final) std::printf("\n");
  std::fflush(stdout);
}

}  // namespace unibody
