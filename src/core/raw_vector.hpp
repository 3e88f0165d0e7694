// A vector whose resize() leaves new elements as the memory is: for arrays that are written in full, but not in order, where
// zeroes first would be one more pass through the memory.
#pragma once

#include <memory>
#include <memory_resource>
#include <type_traits>
#include <utility>
#include <vector>

namespace unibody {

template <class T>
class RawAllocator : public std::pmr::polymorphic_allocator<T> {
 public:
  template <class U>
  struct rebind {
    using other = RawAllocator<U>;
  };

  RawAllocator(std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : std::pmr::polymorphic_allocator<T>(memory) {}
  template <class U>
  RawAllocator(const RawAllocator<U>& other) : RawAllocator(other.resource()) {}
  RawAllocator select_on_container_copy_construction() const { return {}; }

  void construct(T*) noexcept { static_assert(std::is_trivially_copyable_v<T>); }
  template <class... Arguments>
  void construct(T* place, Arguments&&... arguments) {
    std::construct_at(place, std::forward<Arguments>(arguments)...);
  }
};

template <class T>
using RawVector = std::vector<T, RawAllocator<T>>;

}  // namespace unibody
