// Where the time goes: one clock, always in exactly one phase, mirrored in PETSc's log events so that -log_view tells the same,
// and told to what profiles MPI by MPI_Pcontrol, whose level is the phase's number.
#pragma once

#include <petsclog.h>
#include <petsctime.h>

#include <array>
#include <string_view>

namespace unibody {

enum class Phase { other, collide, solve, halo, partition, output };
inline constexpr std::array<std::string_view, 6> phase_names{"other", "collide", "solve", "halo", "partition", "output"};

class PhaseClock {
 public:
  PhaseClock();

  const std::array<double, phase_names.size()>& seconds() const { return seconds_; }
  double operator[](Phase phase) const { return seconds_[static_cast<std::size_t>(phase)]; }

  // The clock is in `phase` while this lives; the phase that it interrupts goes on afterwards.
  class Scope {
   public:
    Scope(PhaseClock& clock, Phase phase) : clock_(clock), outer_(clock.current_) { clock_.enter(phase); }
    ~Scope() { clock_.leave(outer_); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    PhaseClock& clock_;
    Phase outer_;
  };

 private:
  void tick();
  void enter(Phase phase);
  void leave(Phase outer);

  std::array<double, phase_names.size()> seconds_{};
  std::array<PetscLogEvent, phase_names.size()> events_{};
  Phase current_ = Phase::other;
  double since_ = 0;
};

}  // namespace unibody
