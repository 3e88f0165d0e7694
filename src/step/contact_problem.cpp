#include "step/contact_problem.hpp"

#include <algorithm>

#include "step/plan.hpp"
#include "step/rank_state.hpp"
#include "step/step_error.hpp"

namespace unibody {

namespace {

std::array<double, 3> list(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
std::array<double, 6> velocities(const SolverBody& b) { return {b.v[0], b.v[1], b.v[2], b.w[0], b.w[1], b.w[2]}; }

ContactProblem::Body record(const World& world, const SolvedStep& solved, const System& system, std::size_t i) {
  const SolverBody& body = solved.predicted[i];
  ContactProblem::Body b{world.id[i], body.inverse_mass, {}, velocities(body), velocities(solved.solved[i])};
  if (system.isotropic[i]) {
    b.inverse_inertia[0] = b.inverse_inertia[4] = b.inverse_inertia[8] = body.inverse_inertia;
  } else {
    const InverseInertia& w = system.inertia[i];
    b.inverse_inertia = {w.xx, w.xy, w.xz, w.xy, w.yy, w.yz, w.xz, w.yz, w.zz};
  }
  return b;
}

}  // namespace

ContactProblem contact_problem_of(const RankState& state, const System& system, const StepPlan& plan, const SolvedStep& solved) {
  const World& world = state.world;
  const Contacts& contacts = state.contacts;
  ContactProblem problem;
  const Stage stage = plan.stage(Stage::Kind::position, state.scene.solver, state.step());
  std::vector<std::uint8_t> touches(world.size(), 0);
  for (const Manifold& m : contacts.manifolds) {
    touches[static_cast<std::size_t>(m.slot_a)] = touches[static_cast<std::size_t>(m.slot_b)] = 1;
    if (!counts_here(world, m)) continue;
    const Vec3 s = first_tangent_of(m.normal), t = m.normal.cross(s);
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const ContactPoint& point = contacts.points[p];
      ContactProblem::Contact c{m.id_a, m.id_b, point.feature, list(m.normal), {}, {}, {}, {}, m.friction};
      if (state.scene.solver.friction == FrictionModel::none) c.friction = 0;
      Vec3 moved = Vec3::Zero();  // by bodies that the scene moves
      for (const Slot slot : {m.slot_a, m.slot_b}) {
        const auto i = static_cast<std::size_t>(slot);
        const SolverBody& body = solved.predicted[i];
        const Vec3 arm = arm_of(world, m, point, slot);
        (slot == m.slot_a ? c.arm_a : c.arm_b) = list(arm);
        if (body.inverse_mass > 0) continue;
        const Vec3 velocity = Eigen::Map<const Vec3>(body.v) + Eigen::Map<const Vec3>(body.w).cross(arm);
        moved += slot == m.slot_a ? velocity : Vec3(-velocity);
      }
      moved -= system.contacts().aim_of(static_cast<std::size_t>(&m - contacts.manifolds.data()), p - m.first);
      const double bounce = contacts.bounce.empty() ? 0 : contacts.bounce[p];
      const double bias = bounce > 0 ? system.contacts().bias_of_bounce(m, p, bounce) : stage.bias(point.gap);
      c.offset = {m.normal.dot(moved) + bias, s.dot(moved), t.dot(moved)};
      c.impulse = {solved.impulses[p].n, solved.impulses[p].s, solved.impulses[p].t};
      problem.contacts.push_back(c);
    }
  }
  for (std::size_t i = 0; i < world.homes; ++i)
    if (touches[i] && solved.predicted[i].inverse_mass > 0) problem.bodies.push_back(record(world, solved, system, i));
  problem.gather(state.comm());
  return problem;
}

}  // namespace unibody
