// The wall times of a run's frames by phase.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "core/checked.hpp"
#include "core/largest.hpp"
#include "core/phases.hpp"
#include "report/report.hpp"
#include "report/summary.hpp"

namespace unibody {

// Where the wall time of a frame went, the slowest rank's figure for each phase.
class FrameTimes {
 public:
  FrameTimes(MPI_Comm comm, const PhaseClock& clock) : comm_(comm), clock_(clock), before_(clock.seconds()) {
    for (std::size_t i = 0; i < phases.size(); ++i) phases[i].name = phase_names[i];
  }
  void frame_done(FrameReport& report) {
    std::array<double, phase_names.size()> spent = clock_.seconds();
    for (std::size_t i = 0; i < spent.size(); ++i) spent[i] -= before_[i];
    before_ = clock_.seconds();
    for (std::size_t i = 0; i < spent.size(); ++i) own_[i] += spent[i];
    make_largest(comm_, spent);
    for (std::size_t i = 0; i < spent.size(); ++i) phases[i].seconds.add(spent[i]);
    const auto of = [&](Phase phase) { return spent[static_cast<std::size_t>(phase)]; };
    report.wall_collide = of(Phase::collide), report.wall_solve = of(Phase::solve);
    report.wall_halo = of(Phase::halo), report.wall_output = of(Phase::output);
  }
  // Writes into `phases` how the ranks' own totals compare: the least, the mean and the most of them. Collective.
  void finish() {
    std::array<double, phase_names.size()> least = own_, sum = own_, most = own_;
    for (double& seconds : least) seconds = -seconds;
    make_largest(comm_, least), make_largest(comm_, most);
    for (double& seconds : least) seconds = -seconds;
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, sum.data(), mpi_count(sum.size()), MPI_DOUBLE, MPI_SUM, comm_));
    int ranks = 1;
    check_mpi(MPI_Comm_size(comm_, &ranks));
    for (std::size_t i = 0; i < phases.size(); ++i)
      phases[i].least_rank = least[i], phases[i].mean_rank = sum[i] / ranks, phases[i].most_rank = most[i];
  }
  std::vector<PhaseTimes> phases = std::vector<PhaseTimes>(phase_names.size());

 private:
  MPI_Comm comm_;
  const PhaseClock& clock_;
  std::array<double, phase_names.size()> before_, own_{};
};

}  // namespace unibody
