#include "solve/recall.hpp"

#include <algorithm>
#include <limits>

#include "core/room.hpp"

namespace unibody {

namespace {

// A remembered point further off than this share of the smaller body's bounding radius is another point.
constexpr double reach = 0.1;

bool is_round(const Shape& shape) { return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::disc; }

// The body whose frame a manifold's points are remembered in: a, unless it is static and would not carry them along.
Slot carrier(const World& world, const Manifold& m) { return world.is_static(m.slot_a) ? m.slot_b : m.slot_a; }

void recall_pair(const World& world, const Contacts& contacts, const Manifold& m, std::span<const RememberedPoint> old,
                 double step, std::span<ContactBatch::Impulse> impulses) {
  const Shape &a = world.properties[m.slot_a].shape, &b = world.properties[m.slot_b].shape;
  const double size = reach * std::min(bounding_radius(a), bounding_radius(b));
  const bool one_point = is_round(a) || is_round(b);  // it rolls about its body, but it is the same contact
  const Slot body = carrier(world, m);
  const Mat3 to_body = world.orientation[body].conjugate().toRotationMatrix();
  const Vec3 s = first_tangent_of(m.normal), t = m.normal.cross(s);
  std::uint32_t used = 0;  // bit k: old point k is taken
  for (std::uint32_t p = 0; p < m.count; ++p) {
    const Vec3 place = to_body * (contacts.points[m.first + p].position - world.position[body]);
    double nearest = one_point ? std::numeric_limits<double>::infinity() : size * size;
    std::size_t best = old.size();
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double distance2 = (old[k].place - place).squaredNorm();
      if ((used >> k & 1) == 0 && distance2 < nearest) nearest = distance2, best = k;
    }
    if (best == old.size()) continue;
    used |= 1u << best;
    const RememberedPoint& from = old[best];
    impulses[m.first + p] = {from.normal * step, from.tangential.dot(s) * step, from.tangential.dot(t) * step};
  }
}

}  // namespace

void recall(const Multipliers& multipliers, const World& world, const Contacts& contacts, double step,
            std::span<ContactBatch::Impulse> impulses) {
  std::fill(impulses.begin(), impulses.end(), ContactBatch::Impulse{0, 0, 0});
  auto old = multipliers.manifolds.begin();
  for (const Manifold& m : contacts.manifolds) {
    const auto key = std::pair(m.id_a, m.id_b);
    while (old != multipliers.manifolds.end() && std::pair(old->id_a, old->id_b) < key) ++old;
    if (old == multipliers.manifolds.end()) break;
    if (std::pair(old->id_a, old->id_b) == key)
      recall_pair(world, contacts, m, {multipliers.points.data() + old->first, old->count}, step, impulses);
  }
}

void remember(Multipliers& multipliers, const World& world, const Contacts& contacts,
              std::span<const ContactBatch::Impulse> impulses, double step) {
  multipliers.manifolds.clear(), multipliers.points.clear();
  make_room(multipliers.manifolds, contacts.manifolds.size()), make_room(multipliers.points, contacts.points.size());
  for (const Manifold& m : contacts.manifolds) {
    const Slot body = carrier(world, m);
    const Mat3 to_body = world.orientation[body].conjugate().toRotationMatrix();
    const Vec3 s = first_tangent_of(m.normal), t = m.normal.cross(s);
    const auto first = static_cast<std::uint32_t>(multipliers.points.size());
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const ContactBatch::Impulse& impulse = impulses[p];
      if (impulse.n == 0 && impulse.s == 0 && impulse.t == 0) continue;
      multipliers.points.push_back({to_body * (contacts.points[p].position - world.position[body]), impulse.n / step,
                                    (s * impulse.s + t * impulse.t) / step, contacts.points[p].feature});
    }
    const auto count = static_cast<std::uint32_t>(multipliers.points.size()) - first;
    if (count > 0) multipliers.manifolds.push_back({m.id_a, m.id_b, first, count});
  }
}

}  // namespace unibody
