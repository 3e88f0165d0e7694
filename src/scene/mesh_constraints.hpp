// The constraints of a mesh from a file. All are made when the file is read, since their colours depend on the whole mesh; every
// rank has the same, and finds those of a node in a list.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "constraints/constraint_types.hpp"

namespace unibody {

// The places of the constraints that touch each node: those of node k stand at [start[k], start[k + 1]).
struct Incidence {
  std::vector<std::size_t> start, places;

  Incidence() = default;

  // `nodes_of(element)` are those of an element of the list.
  template <class List, typename NodesOf>
  Incidence(const List& list, Id nodes, NodesOf&& nodes_of) : start(static_cast<std::size_t>(nodes) + 1, 0) {
    for (const auto& element : list)
      for (const auto node : nodes_of(element)) ++start[static_cast<std::size_t>(node) + 1];
    for (std::size_t k = 1; k < start.size(); ++k) start[k] += start[k - 1];
    places.resize(start.back());
    std::vector<std::size_t> end(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < list.size(); ++i)
      for (const auto node : nodes_of(list[i])) places[end[static_cast<std::size_t>(node)]++] = i;
  }
  std::span<const std::size_t> at(Id node) const {
    const auto k = static_cast<std::size_t>(node);
    return {places.data() + start[k], start[k + 1] - start[k]};
  }
};

// Each constraint in turn takes the lowest colour that no earlier one at its nodes has.
template <class C>
void colour_greedily(ConstraintList<C>& list, const Incidence& incidence) {
  std::vector<std::size_t> taken_by;  // of each colour, the last constraint (from 1) that found it taken
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (const Id id : list[i].ids)
      for (const std::size_t other : incidence.at(id)) {
        if (other >= i) break;
        const auto colour = static_cast<std::size_t>(list[other].colour);
        if (taken_by.size() <= colour) taken_by.resize(colour + 1, 0);
        taken_by[colour] = i + 1;
      }
    const auto free = std::find_if(taken_by.begin(), taken_by.end(), [&](std::size_t by) { return by != i + 1; });
    list[i].colour = static_cast<std::int32_t>(free - taken_by.begin());
  }
}

// Constraints with nodes from 0 in place of ids, coloured.
class MeshConstraints {
 public:
  MeshConstraints() = default;
  MeshConstraints(ConstraintSet constraints, Id nodes) : set_(std::move(constraints)) {
    for_each_type(set_, [&](auto, auto& list) {
      incidence_.emplace_back(list, nodes, [](const auto& c) { return c.ids; });
      colour_greedily(list, incidence_.back());
    });
  }

  // Adds those that touch a node, with ids from `first` on.
  void touching(Id first, Id node, ConstraintSet& out) const {
    for_each_type(set_, [&](auto type, const auto& list) {
      for (const std::size_t i : incidence_[type.value].at(node)) {
        auto c = list[i];
        for (Id& id : c.ids) id += first;
        std::get<type.value>(out).push_back(c);
      }
    });
  }

 private:
  ConstraintSet set_;
  std::vector<Incidence> incidence_;  // of each type
};

}  // namespace unibody
