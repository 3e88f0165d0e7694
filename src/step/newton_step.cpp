#include "step/newton_step.hpp"

#include <algorithm>

#include "solve/reference.hpp"
#include "step/stages.hpp"

namespace unibody {

namespace {

// Whether a tetrahedron ends the step turned inside out: St. Venant-Kirchhoff has equilibria there, of no solid.
template <class C>
bool inverts(const World& world, const ConstraintList<C>& solids, std::span<const Vec3> velocity, double step) {
  return std::any_of(solids.begin(), solids.end(), [&](const Constraint<C>& c) {
    const auto place = [&](std::size_t e) -> Vec3 {
      const auto slot = static_cast<std::size_t>(world.find(c.ids[e]));
      return world.position[slot] + step * velocity[slot];
    };
    const Vec3 origin = place(0);
    return (place(1) - origin).cross(place(2) - origin).dot(place(3) - origin) < 0;
  });
}

}  // namespace

StepReport newton_step(RankState& state, System& system, const StepPlan& plan) {
  const World& world = state.world;
  const ReferenceStep step =
      reference_step(world, state.ties.constraints, std::span(system.bodies).first(world.size()), state.step());
  for (std::size_t i = 0; i < world.size(); ++i)
    for (int k = 0; k < 3; ++k) system.bodies[i].v[k] = step.velocity[i][k];
  for_each_constraint_batch(system.batches, [&]<class B>(auto type, B& batch) {
    state.history.of<B>() = std::get<decltype(type)::value>(step.multipliers);
    batch.set_multipliers(state.history.of<B>(), 1);
  });
  StepReport report;
  report.iterations = step.iterations;
  measure_solution(state, system, plan, report);
  report.residual = std::max(report.residual, state.step() * step.correction);
  report.converged = step.converged;
  for_each_solid_type(state.ties.constraints, [&](const auto& solids) {
    report.converged = report.converged && !inverts(world, solids, step.velocity, state.step());
  });
  return report;
}

}  // namespace unibody
