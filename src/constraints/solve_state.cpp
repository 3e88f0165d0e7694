#include "constraints/solve_state.hpp"

#include <algorithm>

namespace unibody {

// Inlined by force into the loop over all bodies below.
[[gnu::always_inline]] inline void SolveState::turn(std::size_t i, Vec4d t) {
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

void SolveState::apply_wrenches() { rotates ? apply<true>() : apply<false>(); }

template <bool rotates>
void SolveState::apply() {
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

void SolveState::move_places(std::size_t first) {
  const double ahead = start().is_linear() ? 0 : step;
  const Vec4d h{ahead, ahead, ahead, 0};
  moved_places.resize(places.size());
  for (std::size_t i = first; i < places.size(); ++i)
    moved_places[i] = places[i] + h * *reinterpret_cast<const Vec4dView*>(bodies[i].v);
}

}  // namespace unibody
