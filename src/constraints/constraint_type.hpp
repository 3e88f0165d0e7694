// What a constraint type is: geometry alone. A new one is a struct like those beside this file and a name in
// constraint_types.hpp; what is numerical (scaling, update, momentum, sums) stands once, in ConstraintBatch.
//
// A type says how many bodies it ties together (stencil), how many equations c_k(x) = 0 it has (rows) and which numbers describe
// it at rest (parameters), and it evaluates values and gradients of four constraints at once. Rows are scaled so that a value is
// a length in metres and a multiplier a force in newtons; a row's compliance, in m/N, is then diagonal for every type: rows
// are chosen along the eigenvectors of the material law. A type of one row may say that it is `unilateral`: c >= 0, complementary
// to a multiplier >= 0, and stiff.
#pragma once

#include <array>
#include <concepts>
#include <string_view>

#include "core/simd.hpp"
#include "core/types.hpp"

namespace unibody {

// Values (m) and gradients (1) of four constraints of `rows` equations each over `stencil` bodies.
template <std::size_t stencil, std::size_t rows>
struct Rows {
  std::array<Vec4d, rows> value;
  std::array<std::array<Vec3x4, stencil>, rows> gradient;
};

// The last parameter is the length (m) that makes the rows distances: an element's size; of a link, how long it is at rest.
template <class C>
concept ConstraintType = requires(const std::array<Vec4d, C::parameter_names.size()>& parameters,
                                  const std::array<Vec3x4, C::stencil>& x, Rows<C::stencil, C::rows>& rows) {
  { C::name } -> std::convertible_to<std::string_view>;
  { C::parameter_names[0] } -> std::convertible_to<std::string_view>;
  {C::evaluate(parameters, x, rows)};
};

// The gradients of a solid's strains grow with the strain, and in big unconverged steps old multipliers along grown gradients
// stretch further what they should draw together. Unless told otherwise such a type starts from nothing.
template <class C>
inline constexpr bool starts_cold = requires {
  requires C::starts_cold;
};

// An element of a solid: it resists what moves its nodes in all directions, so that the total form converges where it is soft,
// though it takes over at once all that turns. What is pulled in a plane or along a line turns freely: see turned_share().
template <class C>
inline constexpr bool fills_space = requires {
  requires C::fills_space;
};

template <class C>
inline constexpr bool is_unilateral = requires {
  requires C::unilateral && C::rows == 1;
};

// Gradients of length 1: a row's block is then the sum of the bodies' weights.
template <class C>
inline constexpr bool has_unit_gradients = requires {
  requires C::unit_gradients && C::rows == 1;
};

// Two bodies at a distance l: what moves them across it turns the gradients, as if lambda / l were a stiffness (the geometric
// stiffness).
template <class C>
inline constexpr bool is_link = has_unit_gradients<C>&& C::stencil == 2;

// One constraint as the scene makes it: between bodies given by their ids.
template <class C>
struct Constraint {
  using type = C;
  std::array<Id, C::stencil> ids;  // in the type's own order
  std::array<double, C::parameter_names.size()> parameters;
  std::array<double, C::rows> compliance{};  // m/N; 0: stiff
  double damping = 0;                        // s, rho: the row sees c + rho dc/dt
  std::int32_t colour = 0;  // two of a type and colour share no body: the scene's, so that every rank has the same
};

// The order of constraints of a type: that of their bodies' ids.
template <class C>
bool operator<(const Constraint<C>& a, const Constraint<C>& b) {
  return a.ids < b.ids;
}

}  // namespace unibody
