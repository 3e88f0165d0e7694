// Jacobi and accelerated Jacobi (paper, Algorithm 1, with the signs and the scaling corrected).
//
// Every contact reads the velocities of the last iteration and all of them move at once. The masses are split among the contacts
// of a body, so a step length of 1 is safe; with momentum the error falls as 1/k^2 rather than 1/k.

#include <mpi.h>

#include <array>
#include <span>

#include "constraints/constraint_batches.hpp"
#include "solve/momentum.hpp"
#include "solve/solver.hpp"

namespace unibody {

namespace {

void add(const SweepSums& a, SweepSums& b) {
  b.gradient += a.gradient, b.progress += a.progress;
  b.largest = std::max(b.largest, a.largest), b.change = std::max(b.change, a.change);
}

void combine(void* in, void* inout, int* length, MPI_Datatype*) {
  for (int i = 0; i < *length; ++i) add(static_cast<const SweepSums*>(in)[i], static_cast<SweepSums*>(inout)[i]);
}

// The sums of one sweep over all ranks: started after the sweep, awaited when the next one needs them. A few ranks tell each
// other theirs, which takes one message's time where MPI's own reductions take several; whatever the order, the sums are the
// same.
class Reduction {
 public:
  explicit Reduction(MPI_Comm comm) : comm_(comm) {
    int size = 1;
    MPI_Comm_size(comm, &size);
    others_ = size - 1;
    if (others_ > most_told) {
      MPI_Type_contiguous(sizeof(SweepSums), MPI_BYTE, &type_);
      MPI_Type_commit(&type_);
      MPI_Op_create(combine, 1, &op_);
    } else {
      MPI_Comm_rank(comm, &rank_);
    }
  }
  ~Reduction() {
    wait();
    if (others_ <= most_told) return;
    MPI_Type_free(&type_);
    MPI_Op_free(&op_);
  }
  Reduction(const Reduction&) = delete;
  Reduction& operator=(const Reduction&) = delete;

  void start(const SweepSums& sums) {
    own_ = sums_ = sums;
    under_way_ = true;
    if (others_ > most_told) {
      MPI_Iallreduce(MPI_IN_PLACE, &sums_, 1, type_, op_, comm_, requests_.data());
      return;
    }
    MPI_Request* request = requests_.data();
    for (int other = 0, i = 0; other <= others_; ++other) {
      if (other == rank_) continue;
      MPI_Irecv(&told_[static_cast<std::size_t>(i++)], sizeof(SweepSums), MPI_BYTE, other, tag_sums, comm_, request++);
      MPI_Isend(&own_, sizeof(SweepSums), MPI_BYTE, other, tag_sums, comm_, request++);
    }
  }
  const SweepSums& wait() {
    if (!under_way_) return sums_;
    under_way_ = false;
    const int told = others_ > most_told ? 0 : others_;
    MPI_Waitall(others_ > most_told ? 1 : 2 * told, requests_.data(), MPI_STATUSES_IGNORE);
    for (const SweepSums& sums : std::span(told_).first(static_cast<std::size_t>(told))) add(sums, sums_);
    return sums_;
  }

 private:
  static constexpr int most_told = 3, tag_sums = 191;
  MPI_Comm comm_;
  int others_ = 0, rank_ = 0;
  bool under_way_ = false;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
  std::array<MPI_Request, 2 * most_told> requests_;
  std::array<SweepSums, most_told> told_;
  SweepSums own_, sums_;
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
