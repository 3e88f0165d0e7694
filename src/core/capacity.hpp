// Growth of vectors that are kept from step to step.
#pragma once

#include <algorithm>
#include <cstddef>

namespace unibody {

// Room for n elements. Where there is too little, a sixteenth more than before: a vector that grows by itself may hold twice
// what it needs.
template <class Vector>
void make_room(Vector& v, std::size_t n) {
  if (v.capacity() < n) v.reserve(std::max(n, v.capacity() + v.capacity() / 16));
}

template <class Vector>
std::size_t bytes_of(const Vector& v) {
  return v.capacity() * sizeof(typename Vector::value_type);
}

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
