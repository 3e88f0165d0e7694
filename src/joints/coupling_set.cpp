#include "joints/coupling_set.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

namespace unibody {

namespace {

const Coupling& at(std::span<const Coupling> couplings, std::int64_t number) {
  return couplings[static_cast<std::size_t>(number)];
}

}  // namespace

JointList couplings_here(std::span<const Coupling> couplings, const World& world) {
  JointList list;
  const auto is_home = [&](Id id) {
    const Slot slot = id < 0 ? -1 : world.find(id);
    return slot >= 0 && world.is_home(slot);
  };
  for (std::size_t k = 0; k < couplings.size(); ++k)
    if (std::ranges::any_of(couplings[k].ids, is_home)) list.push_back(static_cast<std::int64_t>(k));
  return list;
}

std::vector<Id> partners(std::span<const Coupling> couplings, const JointList& list, const World& world) {
  std::vector<Id> wanted;
  for (const std::int64_t number : list)
    for (const Id id : at(couplings, number).ids)
      if (id >= 0 && world.find(id) < 0) wanted.push_back(id);
  std::ranges::sort(wanted);
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted;
}

std::vector<CouplingSlots> coupling_slots(std::span<const Coupling> couplings, const JointList& list, const World& world,
                                          Slot nobody) {
  std::vector<CouplingSlots> all;
  all.reserve(list.size());
  for (const std::int64_t number : list) {
    CouplingSlots& own = all.emplace_back();
    own.counted = false;
    bool found = false;
    for (std::size_t e = 0; e < own.slots.size(); ++e) {
      const Id id = at(couplings, number).ids[e];
      const Slot slot = own.slots[e] = id < 0 ? nobody : world.find(id);
      if (id < 0 || found || world.is_static(slot)) continue;
      found = true, own.counted = world.is_home(slot);
    }
  }
  return all;
}

std::int32_t colour_couplings(std::span<Coupling> couplings, const std::function<bool(Id)>& is_static) {
  std::unordered_map<Id, std::set<std::int32_t>> taken;
  std::int32_t colours = 0;
  for (Coupling& coupling : couplings) {
    const auto is_taken = [&](std::int32_t colour) {
      return std::ranges::any_of(coupling.ids, [&](Id id) {
        const auto found = taken.find(id);
        return found != taken.end() && found->second.contains(colour);
      });
    };
    for (coupling.colour = 0; is_taken(coupling.colour);) ++coupling.colour;
    for (const Id id : coupling.ids)
      if (id >= 0 && !is_static(id)) taken[id].insert(coupling.colour);
    colours = std::max(colours, coupling.colour + 1);
  }
  return colours;
}

}  // namespace unibody
