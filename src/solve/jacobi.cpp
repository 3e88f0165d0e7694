// Jacobi and accelerated Jacobi (paper, Algorithm 1, with the signs and the scaling corrected).
//
// Every constraint reads the velocities of the last iteration and all of them move at once. The masses are split among the
// constraints of a body, so a step length of 1 is safe; with momentum the error falls as 1/k^2 rather than 1/k.

#include <mpi.h>

#include <array>
#include <cstring>

#include "core/checked.hpp"
#include "solve/momentum.hpp"
#include "solve/solver.hpp"
#include "solve/stop_test.hpp"

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
// other theirs, through mailboxes where all of them are on one node: that takes one message's time where MPI's own reductions
// take several. Whatever the order, the sums are the same.
class Reduction {
 public:
  explicit Reduction(const Exchange& exchange) : comm_(exchange.comm()), boxes_(exchange.boxes_of_sums()) {
    check_mpi(MPI_Comm_size(comm_, &ranks_)), check_mpi(MPI_Comm_rank(comm_, &rank_));
    way_ = boxes_.reach_all() && ranks_ <= most_by_mail ? Way::mail : ranks_ <= most_by_messages ? Way::messages : Way::reduction;
    if (way_ != Way::reduction) return;
    check_mpi(MPI_Type_contiguous(sizeof(SweepSums), MPI_BYTE, &type_));
    check_mpi(MPI_Type_commit(&type_));
    check_mpi(MPI_Op_create(combine, 1, &op_));
  }
  ~Reduction() {
    wait();
    if (way_ != Way::reduction) return;
    check_mpi(MPI_Type_free(&type_));
    check_mpi(MPI_Op_free(&op_));
  }
  Reduction(const Reduction&) = delete;
  Reduction& operator=(const Reduction&) = delete;

  void start(const SweepSums& sums) {
    own_ = sums_ = sums;
    under_way_ = true;
    if (way_ == Way::reduction) {
      check_mpi(MPI_Iallreduce(MPI_IN_PLACE, &sums_, 1, type_, op_, comm_, requests_.data()));
      return;
    }
    MPI_Request* request = requests_.data();
    for_each_other([&](int other, SweepSums& told) {
      if (way_ == Way::mail) {
        std::memcpy(boxes_.letter(other), &own_, sizeof own_);
        boxes_.send(other);
      } else {
        check_mpi(MPI_Irecv(&told, sizeof told, MPI_BYTE, other, tag_sums, comm_, request++));
        check_mpi(MPI_Isend(&own_, sizeof own_, MPI_BYTE, other, tag_sums, comm_, request++));
      }
    });
  }
  const SweepSums& wait() {
    if (!under_way_) return sums_;
    under_way_ = false;
    const int requests = way_ == Way::reduction ? 1 : way_ == Way::messages ? 2 * (ranks_ - 1) : 0;
    check_mpi(MPI_Waitall(requests, requests_.data(), MPI_STATUSES_IGNORE));
    if (way_ == Way::reduction) return sums_;
    for_each_other([&](int other, SweepSums& told) {
      if (way_ == Way::mail) std::memcpy(&told, boxes_.receive(other), sizeof told);
      add(told, sums_);
    });
    return sums_;
  }

 private:
  enum class Way { mail, messages, reduction };
  static constexpr int most_by_mail = 16, most_by_messages = 4, tag_sums = 191;

  template <typename F>
  void for_each_other(F&& f) {
    for (int other = 0; other < ranks_; ++other)
      if (other != rank_) f(other, told_[static_cast<std::size_t>(other)]);
  }

  MPI_Comm comm_;
  Mailboxes& boxes_;
  Way way_ = Way::messages;
  int ranks_ = 1, rank_ = 0;
  bool under_way_ = false;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
  std::array<MPI_Request, 2 * (most_by_messages - 1)> requests_;
  std::array<SweepSums, most_by_mail> told_;  // of each other rank
  SweepSums own_, sums_;
};

// The sums' unit: 2^-30 of the largest term of the first sweep. Later terms are smaller as a rule; larger ones are clamped.
double unit_for(double largest) { return largest > 0 && std::isfinite(largest) ? std::ldexp(1, std::ilogb(largest) - 30) : 1; }

SolveReport iterate(System& system, const Exchange& exchange, int iterations, double tolerance, bool accelerated) {
  SolveReport report;
  Reduction reduction(exchange);
  Momentum momentum(system.acceleration);
  StopTest stop(system, exchange, tolerance);
  double unit = 1;
  if (system.keeps_places) system.move_places();
  for (int k = 0; k < iterations && !report.converged; ++k) {
    Extrapolation extrapolation;
    bool measures = false;
    double change = 0;
    if (k > 0) {
      const SweepSums& sums = reduction.wait();
      change = sums.change, measures = stop.is_worth_measuring(change);
      if (accelerated) extrapolation = momentum.next(sums, k > 1);
      if (k == 1) unit = unit_for(sums.largest);
    } else if (accelerated) {
      extrapolation = momentum.next({}, false);
    }
    const bool last = k == iterations - 1;
    if (last || measures) extrapolation = {};  // what is applied in the end must lie in the cone

    if (system.observer) system.observer();
    if (system.renews) for_each_acting(system, [&](auto, auto& batch) { batch.renew(system); });
    SweepSums sums;
    sums.unit = unit;
    for_each_acting(system, [&](auto, auto& batch) { batch.sweep(system, extrapolation, sums); });
    reduction.start(sums);
    system.apply_wrenches();
    if (last) for_each_acting(system, [&](auto, auto& batch) { batch.end_stage(system); });
    exchange.refresh(system.bodies);
    if (system.keeps_places) system.move_places(system.homes);
    ++report.iterations;
    if (last || !measures) continue;
    report.converged = stop.passes(change);
    if (!report.converged) continue;
    for_each_acting(system, [&](auto, auto& batch) { batch.end_stage(system); });
    exchange.refresh(system.bodies);
  }
  report.residual = stop.residual();
  report.restarts = momentum.restarts();
  return report;
}

}  // namespace

SolveReport accelerated_jacobi(System& system, const Exchange& exchange, int iterations, double tolerance) {
  return iterate(system, exchange, iterations, tolerance, true);
}

SolveReport jacobi(System& system, const Exchange& exchange, int iterations, double tolerance) {
  return iterate(system, exchange, iterations, tolerance, false);
}

}  // namespace unibody
