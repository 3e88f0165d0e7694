// A memory of the contacts between bodies: within one search the contact of a pair is computed once, however often it is needed.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "collide/narrowphase.hpp"

namespace unibody {

class KnownContacts {
 public:
  // `whole`: bodies that stay where they are in memory as long as this lives.
  explicit KnownContacts(std::span<const Proxy> whole) : whole_(whole) {}

  // Calls f with the same manifolds as collide_parts() does, in the same order. The manifolds of a pair are kept if both bodies
  // are among `whole` and neither is a compound: the parts of a compound exist only while they are being looked at.
  template <class F>
  void each(const Proxy& a, const Proxy& b, const CollideSettings& settings, F&& f) {
    if (!is_kept(a) || !is_kept(b)) return collide_parts(a, b, settings, f);
    const Range range = found(a, b, settings);
    PairManifold m;
    for (std::size_t k = range.first; k < range.last; ++k) {
      restore(manifolds_[k], m);
      f(static_cast<const PairManifold&>(m));
    }
  }

 private:
  struct Kept {
    Vec3 normal;
    double time;  // s
    const Proxy *part_a, *part_b;
    const MeshSurface::Triangle* triangle;
    std::size_t first;  // of points_
    int count;
  };
  struct Range {  // of manifolds_
    static constexpr std::size_t unknown = ~std::size_t{0};
    std::size_t first = 0, last = unknown;
  };

  bool is_kept(const Proxy& p) const;
  Range found(const Proxy& a, const Proxy& b, const CollideSettings& settings);
  void restore(const Kept& kept, PairManifold& m) const;

  // The ranges by pairs, a pair being the places of the two among the whole bodies: a hash table of open addresses, which is a
  // power of two long and at most half full.
  class Ranges {
   public:
    Ranges() : entries_(1024) {}
    // The place of a pair's range, which is new where it has no end yet. Holds until the next call.
    Range& at(std::size_t pair);

   private:
    static constexpr std::size_t none = ~std::size_t{0};
    struct Entry {
      std::size_t pair = none;
      Range range{};
    };
    Entry& entry_of(std::size_t pair);
    void grow();

    std::vector<Entry> entries_;
    std::size_t count_ = 0;
  };

  std::span<const Proxy> whole_;
  Ranges ranges_;
  std::vector<Kept> manifolds_;
  std::vector<ContactPoint> points_;
  std::deque<MeshSurface::Triangle> triangles_;  // copies: of a mesh of two sides the one that faces the body is made for it
};

}  // namespace unibody
