#include "solve/solver.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/errors.hpp"

namespace unibody {

namespace {

// The leak is integral feedback on the position error and needs a velocity stage that contracts well: where that has few
// iterations, or plain Jacobi's, towers tremble with any more. (scripts/bench split and towers.) Where they don't reach down a
// pile, the pile sways as a whole, and the leak would pump it: Gauss-Seidel's is cut off while it swells.
Split of_accelerated_jacobi(int iterations) { return {0.8, iterations >= 30 ? 0.6 : iterations >= 20 ? 0.15 : 0}; }
Split of_jacobi(int) { return {0.5, 0}; }
Split of_gauss_seidel(int iterations) { return {0.5, iterations >= 8 ? 0.3 : 0.15, 0.002}; }

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

const Solver& find_solver(std::string_view name) {
  for (const Solver& solver : solvers)
    if (solver.name == name) return solver;
  throw InputError("no solver is named '" + std::string(name) + "'");
}

// Inlined by force into the loop over all bodies below.
[[gnu::always_inline]] inline void System::turn(std::size_t i, Vec4d t) {
  SolverBody& b = bodies[i];
  if (isotropic[i]) {
    for (int k = 0; k < 3; ++k) b.w[k] += b.inverse_inertia * t[k];
  } else {
    const InverseInertia& w = inertia[i];
    b.w[0] += w.xx * t[0] + w.xy * t[1] + w.xz * t[2];
    b.w[1] += w.xy * t[0] + w.yy * t[1] + w.yz * t[2];
    b.w[2] += w.xz * t[0] + w.yz * t[1] + w.zz * t[2];
  }
}

void System::apply_wrenches() { rotates ? apply<true>() : apply<false>(); }

template <bool rotates>
void System::apply() {
  const Vec4d h{step, step, step, 0};
  const bool touched = !wrenches.empty(), tied = !impulses.empty();
  const bool moves_places = !moved_places.empty() && !start().is_linear();
  for (std::size_t i = 0; i < homes; ++i) {
    SolverBody& b = bodies[i];
    Vec4d impulse = tied ? impulses[i] : Vec4d{};
    if (touched) {
      Wrench& wrench = wrenches[i];
      impulse += wrench.force;
      if constexpr (rotates) turn(i, wrench.torque);
      wrench = Wrench{};
    }
    auto& velocity = *reinterpret_cast<Vec4dView*>(b.v);  // and 1/m, whose impulse is 0
    const Vec4d v = velocity + broadcast(b.inverse_mass) * impulse;
    velocity = v;
    if (tied) impulses[i] = Vec4d{};
    if (moves_places) moved_places[i] = places[i] + h * v;
  }
  const auto guests = static_cast<std::ptrdiff_t>(homes);
  if (touched) std::fill(wrenches.begin() + guests, wrenches.end(), Wrench{});
  if (tied) std::fill(impulses.begin() + guests, impulses.end(), Vec4d{});
}

void System::move_places(std::size_t first) {
  const double ahead = start().is_linear() ? 0 : step;
  const Vec4d h{ahead, ahead, ahead, 0};
  moved_places.resize(places.size());
  for (std::size_t i = first; i < places.size(); ++i)
    moved_places[i] = places[i] + h * *reinterpret_cast<const Vec4dView*>(bodies[i].v);
}

}  // namespace unibody
