// The list of all constraint types between bodies' centres. Solver, halo, graph, reader, report and output find them here.
#pragma once

#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "constraints/area.hpp"
#include "constraints/dihedral.hpp"
#include "constraints/distance.hpp"
#include "constraints/inversion_guard.hpp"
#include "constraints/membrane.hpp"
#include "constraints/tetrahedron.hpp"
#include "constraints/tetrahedron_current_volume.hpp"

namespace unibody {

template <ConstraintType... C>
struct TypeList {
  static constexpr std::size_t size = sizeof...(C);
  template <template <class> class Of>
  using Tuple = std::tuple<Of<C>...>;
};

using ConstraintTypes =
    TypeList<Distance, BendingLink, Membrane, Dihedral, Area, Tetrahedron, TetrahedronCurrentVolume, InversionGuard>;

// The place of a type in the list.
template <class C>
inline constexpr std::size_t type_index = []<class... T>(TypeList<T...>) {
  std::size_t index = 0;
  const bool found = ((std::is_same_v<C, T> || (++index, false)) || ...);
  return found ? index : sizeof...(T);
}(ConstraintTypes{});

// Calls f(type index, element) for each element of a tuple made by ConstraintTypes::Tuple.
template <typename Set, typename F>
void for_each_type(Set& set, F&& f) {
  [&]<std::size_t... k>(std::index_sequence<k...>) { (f(std::integral_constant<std::size_t, k>{}, std::get<k>(set)), ...); }
  (std::make_index_sequence<ConstraintTypes::size>{});
}

// The constraints that touch some bodies, of each type in ascending order of ids.
template <class C>
using ConstraintList = std::vector<Constraint<C>>;
struct ConstraintSet : ConstraintTypes::Tuple<ConstraintList> {};

// Calls f(list) for the constraints of each type that is an element of a solid.
template <class Set, typename F>
void for_each_solid_type(Set& set, F&& f) {
  f(std::get<ConstraintList<Tetrahedron>>(set));
  f(std::get<ConstraintList<TetrahedronCurrentVolume>>(set));
}

// Whether any two bodies of a constraint are the ends of an edge of the mesh.
template <class C>
inline constexpr bool joins_edges =
    !std::is_same_v<C, BendingLink> && !std::is_same_v<C, Dihedral> && !std::is_same_v<C, InversionGuard>;

// The impulses (N s) of each constraint of a set in the last step.
template <class C>
using MultiplierList = std::vector<std::array<double, C::rows>>;
struct ConstraintMultipliers : ConstraintTypes::Tuple<MultiplierList> {};

// How many colours the constraints of each type have.
using ConstraintColours = std::array<std::int32_t, ConstraintTypes::size>;

inline std::size_t constraint_count(const ConstraintSet& set) {
  std::size_t n = 0;
  for_each_type(set, [&](auto, const auto& list) { n += list.size(); });
  return n;
}

}  // namespace unibody
