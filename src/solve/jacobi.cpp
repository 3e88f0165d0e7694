// Jacobi and accelerated Jacobi (paper, Algorithm 1, with the signs and the scaling corrected).
//
// Every contact reads the velocities of the last iteration and all of them move at once. The masses are split among the contacts
// of a body, so a step length of 1 is safe; with momentum the error falls as 1/k^2 rather than 1/k.

#include <mpi.h>

#include "constraints/constraint_batches.hpp"
#include "solve/momentum.hpp"
#include "solve/solver.hpp"

namespace unibody {

namespace {

void combine(void* in, void* inout, int* length, MPI_Datatype*) {
  const auto* a = static_cast<const SweepSums*>(in);
  auto* b = static_cast<SweepSums*>(inout);
  for (int i = 0; i < *length; ++i) {
    b[i].gradient += a[i].gradient, b[i].progress += a[i].progress;
    b[i].largest = std::max(b[i].largest, a[i].largest), b[i].change = std::max(b[i].change, a[i].change);
  }
}

// The sums of one sweep over all ranks: started after the sweep, awaited when the next one needs them.
class Reduction {
 public:
  explicit Reduction(MPI_Comm comm) : comm_(comm) {
    MPI_Comm_size(comm, &size_);
    if (size_ == 1) return;
    MPI_Type_contiguous(sizeof(SweepSums), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
    MPI_Op_create(combine, 1, &op_);
  }
  ~Reduction() {
    if (size_ == 1) return;
    wait();
    MPI_Type_free(&type_);
    MPI_Op_free(&op_);
  }
  Reduction(const Reduction&) = delete;
  Reduction& operator=(const Reduction&) = delete;

  void start(const SweepSums& sums) {
    sums_ = sums;
    if (size_ > 1) MPI_Iallreduce(MPI_IN_PLACE, &sums_, 1, type_, op_, comm_, &request_);
  }
  const SweepSums& wait() {
    if (size_ > 1) MPI_Wait(&request_, MPI_STATUS_IGNORE);
    return sums_;
  }

 private:
  MPI_Comm comm_;
  int size_ = 1;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
  MPI_Request request_ = MPI_REQUEST_NULL;
  SweepSums sums_;
};

// The sums' unit: 2^-30 of the largest term of the first sweep. Later terms are smaller as a rule; larger ones are clamped.
double unit_for(double largest) { return largest > 0 && std::isfinite(largest) ? std::ldexp(1, std::ilogb(largest) - 30) : 1; }

SolveReport iterate(System& system, const Cut& cut, int iterations, double tolerance, bool accelerated) {
  SolveReport report;
  Reduction reduction(cut.comm());
  Momentum momentum(system.acceleration);
  double unit = 1;
  bool last = iterations < 1;
  if (system.constraints) system.move_places();
  for (int k = 0; !last; ++k) {
    Extrapolation beyond;
    if (k > 0) {
      const SweepSums& sums = reduction.wait();
      report.residual = sums.change;
      report.converged = sums.change <= tolerance;
      if (accelerated) beyond = momentum.next(sums, k > 1);
      if (k == 1) unit = unit_for(sums.largest);
    } else if (accelerated) {
      beyond = momentum.next({}, false);
    }
    last = k == iterations - 1 || report.converged;
    if (last) beyond = {};  // what is applied in the end must lie in the cone

    if (system.before_iteration) system.before_iteration();
    SweepSums sums;
    sums.unit = unit;
    system.contacts.sweep_jacobi(system.bodies, system.wrenches, beyond, sums, system.counted);
    system.rolling.sweep_jacobi(system.contacts, system.bodies, system.wrenches, beyond, sums, system.counted);
    system.surface.sweep_jacobi(system.bodies, system.wrenches, beyond, sums);
    if (system.attachments) system.attachments->sweep_jacobi(system.bodies, system.wrenches, beyond, sums);
    if (system.joints) system.joints->sweep_jacobi(system.bodies, system.wrenches, beyond, sums);
    if (system.constraints) system.constraints->sweep_jacobi(system.start(), system.bodies, system.impulses, beyond, sums);
    reduction.start(sums);
    system.apply_wrenches();
    if (last) {
      system.contacts.settle(system.homes, system.first_static, system.bodies);
      system.contacts.hold_centres(system.homes, system.first_static, system.bodies);
    }
    cut.exchange(system.bodies);
    if (system.constraints) system.move_places(system.homes);
    ++report.iterations;
  }
  report.restarts = momentum.restarts();
  return report;
}

}  // namespace

SolveReport accelerated_jacobi(System& system, const Cut& cut, int iterations, double tolerance) {
  return iterate(system, cut, iterations, tolerance, true);
}

SolveReport jacobi(System& system, const Cut& cut, int iterations, double tolerance) {
  return iterate(system, cut, iterations, tolerance, false);
}

}  // namespace unibody
