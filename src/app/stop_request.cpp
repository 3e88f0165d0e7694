#include "app/stop_request.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>

#include "core/checked.hpp"
#include "core/errors.hpp"

namespace unibody {

namespace {

volatile std::sig_atomic_t caught = 0;  // the signal, 0: none

constexpr std::array signals{SIGTERM, SIGINT, SIGUSR1};
constexpr std::array names{"SIGTERM", "SIGINT", "SIGUSR1"};

void note(int signal) {
  if (signal == SIGINT) std::signal(SIGINT, SIG_DFL);
  caught = signal;
}

}  // namespace

StopRequest::StopRequest(MPI_Comm comm, double wall_limit)
    : comm_(comm), start_(MPI_Wtime()), limit_(wall_limit), before_(start_) {
  caught = 0;
  for (const int signal : signals) std::signal(signal, note);
}

StopRequest::~StopRequest() {
  for (const int signal : signals) std::signal(signal, SIG_DFL);
}

std::string StopRequest::reason() {
  const double now = MPI_Wtime();
  longest_ = std::max(longest_, now - before_), before_ = now;
  std::array<int, 2> found{static_cast<int>(caught), limit_ > 0 && now - start_ + longest_ > limit_ ? 1 : 0};
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, found.data(), 2, MPI_INT, MPI_MAX, comm_));
  for (std::size_t k = 0; k < signals.size(); ++k)
    if (found[0] == signals[k]) return names[k];
  return found[1] != 0 ? "-wall_limit" : "";
}

double wall_time_of(const std::string& option, const std::string& text) {
  const auto refuse = [&] {
    throw InputError("option " + option + ": found '" + text + "', expected a time as 3h55m, 90m, 45s or 3600 (s), more than 0");
  };
  double total = 0;
  const char *at = text.data(), *end = at + text.size();
  while (at != end) {
    double number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    if (error != std::errc() || !(number >= 0)) refuse();
    const char unit = after == end ? 's' : *after;
    if (unit != 'h' && unit != 'm' && unit != 's') refuse();
    total += number * (unit == 'h' ? 3600 : unit == 'm' ? 60 : 1);
    at = after == end ? end : after + 1;
  }
  if (!(total > 0) || total > 1e9) refuse();
  return total;
}

}  // namespace unibody
