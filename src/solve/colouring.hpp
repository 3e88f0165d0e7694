// Colours for Gauss-Seidel: two manifolds of one colour share no moving body, so that a colour may be swept in any order, four at
// a time, on any rank.
//
// The rule is Jones and Plassmann's (1993): manifolds are taken in the order of a hash of their key, each taking the smallest
// colour that no earlier one at its bodies has. It depends on the keys alone, so every rank finds the same colours. A manifold
// across a cut waits until it is first in line at both its bodies; each side then tells the other the colours taken at its own.
#pragma once

#include <memory_resource>
#include <vector>

#include "partition/exchange.hpp"

namespace unibody {

struct Colouring {
  std::pmr::vector<std::int32_t> colour;  // of each manifold
  std::size_t colours = 0;                // on this rank
};

// Collective among neighbours.
Colouring colour_manifolds(const World& world, const Contacts& contacts, const Exchange& exchange,
                           std::pmr::memory_resource* memory = std::pmr::get_default_resource());

}  // namespace unibody
