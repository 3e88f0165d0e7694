// A memory of the contacts between bodies: within one search the contact of a pair is computed once, however often it is needed.
#pragma once

#include <deque>
#include <span>
#include <unordered_map>
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
    std::size_t first, last;
  };

  bool is_kept(const Proxy& p) const;
  Range found(const Proxy& a, const Proxy& b, const CollideSettings& settings);
  void restore(const Kept& kept, PairManifold& m) const;

  std::span<const Proxy> whole_;
  std::unordered_map<std::size_t, Range> ranges_;  // by the places of the two among the whole bodies
  std::vector<Kept> manifolds_;
  std::vector<ContactPoint> points_;
  std::deque<MeshSurface::Triangle> triangles_;  // copies: of a mesh of two sides the one that faces the body is made for it
};

}  // namespace unibody
