#include "step/islands.hpp"

#include <algorithm>

namespace unibody {

namespace {

// Carries the marks over the contacts of this rank, forwards and backwards through them, until none is new. Returns whether a
// home got one.
bool spread(const Contacts& contacts, const System& system, std::vector<std::int32_t>& marks) {
  const auto moves = [&](Slot s) { return system.bodies[static_cast<std::size_t>(s)].inverse_mass > 0; };
  const auto marked_homes = [&] {
    return std::count(marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(system.homes), 1);
  };
  const auto before = marked_homes();
  bool changed = true;
  const auto carry = [&](const Manifold& m) {
    std::int32_t &a = marks[static_cast<std::size_t>(m.slot_a)], &b = marks[static_cast<std::size_t>(m.slot_b)];
    if (a == b || !moves(m.slot_a) || !moves(m.slot_b)) return;
    a = b = 1, changed = true;
  };
  while (changed) {
    changed = false;
    std::for_each(contacts.manifolds.begin(), contacts.manifolds.end(), carry);
    if (changed) std::for_each(contacts.manifolds.rbegin(), contacts.manifolds.rend(), carry);
  }
  return marked_homes() > before;
}

}  // namespace

// Each rank has all contacts of its homes. Where a mark has passed on to a guest, its home learns it from the same contact, once
// the mark of the other body has come there.
std::vector<std::int32_t> constrained_islands(const RankState& state, const System& system) {
  const World& world = state.world;
  std::vector<std::int32_t> marks(world.size() + 1, 0);
  for (std::size_t i = 0; i < world.first_static(); ++i) marks[i] = state.is_tied(world.id[i]);
  for (const SurfaceContact& contact : state.contacts.surface)
    for (const Slot s : contact.slots)
      if (s >= 0 && static_cast<std::size_t>(s) < world.first_static()) marks[static_cast<std::size_t>(s)] = 1;
  bool changed = true;
  for (bool first = true; first || state.any_over_ranks(changed); first = false) {
    state.exchange.refresh(std::span(marks));
    changed = spread(state.contacts, system, marks);
  }
  return marks;
}

}  // namespace unibody
