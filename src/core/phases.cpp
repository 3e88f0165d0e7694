#include "core/phases.hpp"

#include <mpi.h>

#include <string>

#include "core/checked.hpp"

namespace unibody {

PhaseClock::PhaseClock() {
  static PetscClassId id = 0;
  if (id == 0) check_petsc(PetscClassIdRegister("Unibody", &id));
  for (std::size_t i = 0; i < phase_names.size(); ++i) {
    const std::string name = "unibody_" + std::string(phase_names[i]);
    check_petsc(PetscLogEventGetId(name.c_str(), &events_[i]));
    if (events_[i] < 0) check_petsc(PetscLogEventRegister(name.c_str(), id, &events_[i]));
  }
  since_ = MPI_Wtime();
}

void PhaseClock::tick() {
  const double now = MPI_Wtime();
  seconds_[static_cast<std::size_t>(current_)] += now - since_;
  since_ = now;
}

void PhaseClock::enter(Phase phase) {
  tick();
  current_ = phase;
  check_mpi(MPI_Pcontrol(static_cast<int>(phase)));
  check_petsc(PetscLogEventBegin(events_[static_cast<std::size_t>(phase)], 0, 0, 0, 0));
}

void PhaseClock::leave(Phase outer) {
  check_petsc(PetscLogEventEnd(events_[static_cast<std::size_t>(current_)], 0, 0, 0, 0));
  tick();
  current_ = outer;
  check_mpi(MPI_Pcontrol(static_cast<int>(outer)));
}

}  // namespace unibody
