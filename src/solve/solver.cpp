#include "solve/solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "core/errors.hpp"

namespace unibody {

namespace {

// The leak is integral feedback on the position error and needs a velocity stage that contracts well: where that has few
// iterations, or plain Jacobi's, towers tremble with any more. (scripts/bench split and towers.) Where they don't reach down a
// pile, the pile sways as a whole, and the leak would pump it. It is therefore bounded by the weights that each contact bears,
// which takes all of that gain away (piles of 10 to 100 layers). With the few iterations of a Gauss-Seidel without the time for
// momentum the bound would cost ten times the penetration: its leak is cut off, and its forces taken back, while the pile swells.
//
// The more iterations a stage has, the less it needs the old differences of a face's forces, and the faster they may be forgotten
// (Split::uneven_share): in e-folds of so many iterations beyond 30. Fewer than 30 hold a column upright only with all of them.
double uneven_share(int iterations, double per_fold) {
  return std::exp(-std::max(0, iterations - least_for_momentum) / per_fold);
}

Split of_accelerated_jacobi(int iterations) {
  return {0.8, iterations >= least_for_momentum ? 0.6 : iterations >= 20 ? 0.15 : 0, 0, 4, uneven_share(iterations, 120)};
}
Split of_jacobi(int) { return {0.5, 0}; }
Split of_gauss_seidel(int iterations) {
  if (iterations >= least_for_momentum) return {0.65, 0.3, 0, 2, uneven_share(iterations, 60)};
  return {0.5, iterations >= 8 ? 0.3 : 0.15, 0.002};
}

constexpr Solver solvers[] = {
    {"accelerated_jacobi", accelerated_jacobi, false, of_accelerated_jacobi},
    {"jacobi", jacobi, false, of_jacobi},
    {"gauss_seidel", gauss_seidel, true, of_gauss_seidel},
    {"newton", nullptr, false, of_jacobi},
};

}  // namespace

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const Solver& solver : solvers) names.emplace_back(solver.name);
  return names;
}

System::System(std::pmr::memory_resource* memory) : SolveState(memory), batches(memory) {}

void System::clear(std::pmr::memory_resource* memory) {
  static_cast<SolveState&>(*this) = SolveState(memory);
  for_each_batch(batches, [&]<class B>(auto, B& batch) {
    if constexpr (Batches::is_in_memory<B>) batch = B(memory);
  });
  stage = {}, renews = false, observer = nullptr;
}

void start_stage(System& system, const Stage& stage) {
  system.stage = stage;
  for_each_batch(system.batches, [&](auto, auto& batch) { batch.start_stage(stage); });
}

void take_all_islands(System& system) {
  system.stage.islands = Islands::all;
  system.contacts().select_islands(Islands::all);
}

std::array<double, BatchTypes::size> residuals(const System& system) {
  std::array<double, BatchTypes::size> result{};
  for_each_acting(system, [&](auto place, const auto& batch) { result[place] = batch.residual(system); });
  return result;
}

const Solver& find_solver(std::string_view name) {
  for (const Solver& solver : solvers)
    if (solver.name == name) return solver;
  throw InputError("no solver is named '" + std::string(name) + "'");
}

}  // namespace unibody
