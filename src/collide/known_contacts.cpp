#include "collide/known_contacts.hpp"

#include <algorithm>
#include <functional>

namespace unibody {

bool KnownContacts::is_kept(const Proxy& p) const {
  if (p.kind == ShapeKind::compound) return false;
  const std::less<const Proxy*> before;
  return !before(&p, whole_.data()) && before(&p, whole_.data() + whole_.size());
}

KnownContacts::Ranges::Entry& KnownContacts::Ranges::entry_of(std::size_t pair) {
  const std::size_t mask = entries_.size() - 1;
  std::size_t k = pair * 0x9e3779b97f4a7c15 >> 20 & mask;  // the middle bits of the product depend on all of the pair
  while (entries_[k].pair != pair && entries_[k].pair != none) k = (k + 1) & mask;
  return entries_[k];
}

KnownContacts::Range& KnownContacts::Ranges::at(std::size_t pair) {
  if (2 * (count_ + 1) > entries_.size()) grow();
  Entry& entry = entry_of(pair);
  if (entry.pair == none) entry.pair = pair, ++count_;
  return entry.range;
}

void KnownContacts::Ranges::grow() {
  std::vector<Entry> before(2 * entries_.size());
  before.swap(entries_);
  for (const Entry& entry : before)
    if (entry.pair != none) entry_of(entry.pair) = entry;
}

KnownContacts::Range KnownContacts::found(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  const auto place_of = [&](const Proxy& p) { return static_cast<std::size_t>(&p - whole_.data()); };
  Range& range = ranges_.at(place_of(a) * whole_.size() + place_of(b));
  if (range.last != Range::unknown) return range;
  range.first = manifolds_.size();
  collide_parts(a, b, settings, [&](const PairManifold& m) {
    const MeshSurface::Triangle* triangle = m.triangle ? &triangles_.emplace_back(*m.triangle) : nullptr;
    manifolds_.push_back({m.normal, m.time, m.part_a, m.part_b, triangle, points_.size(), m.count});
    points_.insert(points_.end(), m.points, m.points + m.count);
  });
  range.last = manifolds_.size();
  return range;
}

void KnownContacts::restore(const Kept& kept, PairManifold& m) const {
  m.normal = kept.normal, m.time = kept.time, m.count = kept.count;
  m.part_a = kept.part_a, m.part_b = kept.part_b, m.triangle = kept.triangle;
  std::copy_n(points_.begin() + static_cast<std::ptrdiff_t>(kept.first), kept.count, m.points);
}

}  // namespace unibody
