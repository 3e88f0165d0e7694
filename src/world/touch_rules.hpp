// Which bodies may touch each other, where the scene says so by its entries: a pure function of the bodies' ids.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/types.hpp"

namespace unibody {

class TouchRules {
 public:
  // The bodies from id `first` on, up to the next class: what they are, and what others must be to touch them; bits.
  struct Class {
    Id first = 0;
    std::uint64_t is = 1, touches = ~std::uint64_t{0};

    bool is_as(const Class& other) const { return is == other.is && touches == other.touches; }
  };

  // Classes come in ascending order of ids; the first starts at 0.
  void add(const Class& of) {
    if (classes_.empty() || !classes_.back().is_as(of)) classes_.push_back(of);
  }
  const std::vector<Class>& classes() const { return classes_; }
  bool any() const { return classes_.size() > 1 || (!classes_.empty() && !classes_.front().is_as(Class{})); }

  bool may_touch(Id a, Id b) const {
    const Class &of_a = class_of(a), &of_b = class_of(b);
    return (of_a.is & of_b.touches) != 0 && (of_b.is & of_a.touches) != 0;
  }

 private:
  const Class& class_of(Id id) const { return *std::prev(std::ranges::upper_bound(classes_, id, {}, &Class::first)); }

  std::vector<Class> classes_;
};

}  // namespace unibody
