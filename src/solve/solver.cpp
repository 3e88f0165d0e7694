#include "solve/solver.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/errors.hpp"

namespace unibody {

namespace {

// The leak is integral feedback on the position error and needs a stage that contracts well: with the Jacobi solvers towers
// tremble at any leak, with Gauss-Seidel piles come to rest.
double leak_of_gauss_seidel(int iterations) { return iterations >= 8 ? 0.3 : 0.15; }
double no_leak(int) { return 0; }

constexpr Solver solvers[] = {
    {"accelerated_jacobi", accelerated_jacobi, false, no_leak},
    {"jacobi", jacobi, false, no_leak},
    {"gauss_seidel", gauss_seidel, true, leak_of_gauss_seidel},
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

void System::apply_wrenches() {
  for (std::size_t i = 0; i < homes; ++i) {
    SolverBody& b = bodies[i];
    const Vec4d f = wrenches[i].force, t = wrenches[i].torque;
    for (int k = 0; k < 3; ++k) b.v[k] += b.inverse_mass * f[k];
    if (isotropic[i]) {
      for (int k = 0; k < 3; ++k) b.w[k] += b.inverse_inertia * t[k];
    } else {
      const InverseInertia& w = inertia[i];
      b.w[0] += w.xx * t[0] + w.xy * t[1] + w.xz * t[2];
      b.w[1] += w.xy * t[0] + w.yy * t[1] + w.yz * t[2];
      b.w[2] += w.xz * t[0] + w.yz * t[1] + w.zz * t[2];
    }
  }
  std::fill(wrenches.begin(), wrenches.end(), Wrench{});
}

}  // namespace unibody
