// Growth of vectors that are filled anew in each step.
#pragma once

#include "core/room.hpp"

namespace unibody {

// Empties v, with room for n elements. Where there is too little, what it held is given back first, so that old and new memory
// are never there at once.
template <class Vector>
void renew_room(Vector& v, std::size_t n) {
  v.clear();
  const std::size_t before = v.capacity();
  if (before >= n) return;
  Vector().swap(v);
  make_room(v, std::max(n, before + before / 16));
}

}  // namespace unibody
