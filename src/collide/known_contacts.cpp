#include "collide/known_contacts.hpp"

#include <algorithm>
#include <functional>

namespace unibody {

bool KnownContacts::is_kept(const Proxy& p) const {
  if (p.kind == ShapeKind::compound) return false;
  const std::less<const Proxy*> before;
  return !before(&p, whole_.data()) && before(&p, whole_.data() + whole_.size());
}

KnownContacts::Range KnownContacts::found(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  const auto place_of = [&](const Proxy& p) { return static_cast<std::size_t>(&p - whole_.data()); };
  const auto [at, is_new] = ranges_.try_emplace(place_of(a) * whole_.size() + place_of(b), Range{manifolds_.size(), 0});
  if (!is_new) return at->second;
  collide_parts(a, b, settings, [&](const PairManifold& m) {
    const MeshSurface::Triangle* triangle = m.triangle ? &triangles_.emplace_back(*m.triangle) : nullptr;
    manifolds_.push_back({m.normal, m.time, m.part_a, m.part_b, triangle, points_.size(), m.count});
    points_.insert(points_.end(), m.points, m.points + m.count);
  });
  at->second.last = manifolds_.size();
  return at->second;
}

void KnownContacts::restore(const Kept& kept, PairManifold& m) const {
  m.normal = kept.normal, m.time = kept.time, m.count = kept.count;
  m.part_a = kept.part_a, m.part_b = kept.part_b, m.triangle = kept.triangle;
  std::copy_n(points_.begin() + static_cast<std::ptrdiff_t>(kept.first), kept.count, m.points);
}

}  // namespace unibody
