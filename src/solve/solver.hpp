// Solvers: each takes a System and makes its multipliers satisfy one stage's rows. One file a solver, one signature, one table.
#pragma once

#include <functional>
#include <memory_resource>
#include <string>
#include <string_view>
#include <vector>

#include "constraints/solve_state.hpp"
#include "constraints/solver_settings.hpp"
#include "partition/exchange.hpp"
#include "solve/batches.hpp"

namespace unibody {

// Everything one step's solve works on.
struct System : SolveState {
  explicit System(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  // Makes the system as it was at first, but for the batches that last.
  void clear(std::pmr::memory_resource* memory);

  template <class B>
  B& batch() {
    return std::get<B>(batches);
  }
  template <class B>
  const B& batch() const {
    return std::get<B>(batches);
  }
  ContactBatch& contacts() { return batch<ContactBatch>(); }
  const ContactBatch& contacts() const { return batch<ContactBatch>(); }

  Batches batches;
  Stage stage;
  Acceleration acceleration = Acceleration::nesterov;  // of this stage: not automatic
  std::function<void()> observer;                      // is called before each iteration; empty: nobody looks on
  bool renews = false;                                 // some batch on some rank renews its rows before each iteration
};

// Starts a stage of all batches that act in it.
void start_stage(System& system, const Stage& stage);

// After stages of some islands: all batches act again, in all islands, as they stand.
void take_all_islands(System& system);

// The natural residual of each batch on this rank (m) that acts in the present stage; others have 0.
std::array<double, BatchTypes::size> residuals(const System& system);

// Calls f(place in the list, batch) for each batch that acts in the present stage.
template <class AnySystem, typename F>
void for_each_acting(AnySystem& system, F&& f) {
  const bool velocity = system.stage.kind == Stage::Kind::velocity, free = system.stage.islands == Islands::free;
  for_each_batch(system.batches, [&]<class B>(auto place, B& batch) {
    if ((B::in_velocity_stage || !velocity) && (B::in_free_islands || !free)) f(place, batch);
  });
}

struct SolveReport {
  int iterations = 0;
  int restarts = 0;     // of the momentum
  double residual = 0;  // m, natural residual over all ranks where it was measured last; 0: it was not (stop_test.hpp)
  bool converged = false;
};

// When a stage stops before its last iteration. Natural residuals, m.
struct StopRule {
  double tolerance = 0;  // at which it stops; 0: at none
  double allowed = 0;    // at which it stops from `least` iterations on; then it also gives up where more of them hardly help
  int least = 0;
  // Returns an error of the solution that no row shows (m, the same on all ranks). The stage may end where its residual is less
  // than share_of_hidden of that, since more of its iterations would not lessen it (stop_test.hpp). Collective; may be empty.
  std::function<double()> hidden;
  static constexpr double share_of_hidden = 0.01;

  StopRule(double at) : tolerance(at), allowed(at) {}  // NOLINT: a tolerance alone is a rule
  StopRule(double at, double later, int from) : tolerance(at), allowed(later), least(from) {}
};

// Runs at most `iterations` iterations, fewer as the rule says. Starts from the multipliers in the batch, whose impulses must
// have been applied. On return guests are up to date.
using SolveFunction = SolveReport (*)(System&, const Exchange&, int iterations, const StopRule& rule);

SolveReport accelerated_jacobi(System&, const Exchange&, int iterations, const StopRule& rule);
SolveReport jacobi(System&, const Exchange&, int iterations, const StopRule& rule);
SolveReport gauss_seidel(System&, const Exchange&, int iterations, const StopRule& rule);

// How two stages divide a step: SolverSettings says more of both.
struct Split {
  double velocity_share;  // of the iterations, the velocity stage's
  double leak;            // of the position stage's multipliers, kept by the velocity stage
  double swelling = 0;    // of g h: the coherent speed at which a pile may swell before nothing leaks; 0: any
  // Iterations of the velocity stage for each weight of a body that a contact may bear before it leaks less; 0: it may bear
  // any.
  double iterations_a_weight = 0;
  // A manifold that the velocity stage left unsolved keeps so much, after a frame, of the differences of its points' normal
  // multipliers from their mean, where nothing renews them. The old forces lag behind the motion. Their sum bears the body's
  // weight and hardly changes. Their differences hold a rocking body upright; because they lag, they push it on, and it rocks
  // further with each swing, to a standing motion of whole columns in a pile.
  double uneven_share = 1;
};

// From so many iterations on a stage reaches so far down a pile that momentum and a large leak help.
inline constexpr int least_for_momentum = 30;

struct Solver {
  std::string_view name;
  SolveFunction solve;             // null: `newton`, of which each step is a reference_step
  bool sweeps_by_colour;           // the batch is laid out by colour rather than in key order
  Split (*split)(int iterations);  // where the settings leave it to the solver
};

// The solver of that name; the scene reader has checked that there is one.
const Solver& find_solver(std::string_view name);

}  // namespace unibody
