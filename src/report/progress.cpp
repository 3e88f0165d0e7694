#include "report/progress.hpp"

#include <fcntl.h>
#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace unibody {

namespace {

// Whether a person sees what is printed as it is printed. Open MPI gives the first rank a terminal of its own, whatever mpirun's
// output goes to; where it does is seen from that process, which has started this one where both are on one machine.
bool writes_to_terminal() {
  if (isatty(STDOUT_FILENO) == 0) return false;
  if (std::getenv("OMPI_COMM_WORLD_RANK") == nullptr) return true;
  const std::string path = "/proc/" + std::to_string(getppid()) + "/fd/1";
  const int file = open(path.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK);
  if (file < 0) return false;
  const bool terminal = isatty(file) != 0;
  close(file);
  return terminal;
}

// "[#####---------------]"
std::string bar(std::int64_t done, std::int64_t all) {
  constexpr std::int64_t width = 20;
  const auto full = static_cast<std::size_t>(all > 0 ? width * done / all : width);
  return "[" + std::string(full, '#') + std::string(width - full, '-') + "]";
}

}  // namespace

Progress::Progress(int rank, std::int64_t first, std::int64_t last, Id bodies)
    : rank_(rank),
      terminal_(rank == 0 && writes_to_terminal()),
      first_(first),
      last_(last),
      bodies_(bodies),
      start_(MPI_Wtime()),
      printed_(start_) {}

void Progress::frame_done(const FrameReport& report) {
  if (rank_ != 0) return;
  body_frames_ += report_value(report, "bodies").value_or(static_cast<double>(bodies_));
  const double now = MPI_Wtime(), wait = terminal_ ? 0.1 : 5;
  const bool final = report.step == last_;
  if (!final && now - printed_ < wait) return;
  printed_ = now;
  const double a_frame = (now - start_) / static_cast<double>(report.step - first_);
  const auto left = static_cast<std::int64_t>(a_frame * static_cast<double>(last_ - report.step) + 0.5);
  std::printf(
      "%s%sframe %lld/%lld  t %.3f s  residual %.2e m  penetration %.2e m  iterations %lld  %.1f ms/frame  %.2g bodies/s  left "
      "%lld:%02lld",
      terminal_ ? "\r\033[K" : "", terminal_ ? (bar(report.step, last_) + " ").c_str() : "", static_cast<long long>(report.step),
      static_cast<long long>(last_), report.time, report.natural_residual, report.measures.penetration_max,
      static_cast<long long>(report.iterations), 1e3 * a_frame, body_frames_ / (now - start_), static_cast<long long>(left / 60),
      static_cast<long long>(left % 60));
  if (!terminal_ || final) std::printf("\n");
  std::fflush(stdout);
}

}  // namespace unibody
