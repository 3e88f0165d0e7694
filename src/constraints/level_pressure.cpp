#include "constraints/level_pressure.hpp"

#include <algorithm>

#include "collide/merge_supports.hpp"
#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

// N, of all points that are remembered of a pair.
double remembered_force(const Multipliers& history, const Manifold& m) {
  const auto key = [](const RememberedManifold& r) { return std::pair(r.id_a, r.id_b); };
  const auto found = std::ranges::lower_bound(history.manifolds, std::pair(m.id_a, m.id_b), {}, key);
  if (found == history.manifolds.end() || key(*found) != std::pair(m.id_a, m.id_b)) return 0;
  double sum = 0;
  for (const RememberedPoint& p : history.points_of(static_cast<std::size_t>(found - history.manifolds.begin()))) sum += p.normal;
  return sum;
}

struct Points {
  std::span<const ContactPoint> contacts;
  std::span<ContactBatch::Impulse> impulses;
};

// m/s, at which the bodies slide on each other at a place, along the tangents s and t = n x s.
Vector2d sliding_at(const World& world, const Manifold& m, const Vec3& s, const Vec3& place) {
  const Vec3 arm_a = place - place_of(world, m, m.slot_a), arm_b = place - place_of(world, m, m.slot_b);
  const auto velocity_of = [&](Slot slot, const Vec3& arm) {
    const auto i = static_cast<std::size_t>(slot);
    return Vec3(world.velocity[i] + world.angular_velocity_of(i).cross(arm));
  };
  const Vec3 own = surface_velocity_between(world, m.slot_a, arm_a, m.slot_b, arm_b, m.normal);
  const Vec3 velocity = velocity_of(m.slot_a, arm_a) - velocity_of(m.slot_b, arm_b) - own;
  return {s.dot(velocity), m.normal.cross(s).dot(velocity)};
}

// m/s, up to which friction under this load (N s) stops what slides at the rim within the step.
double stopped_speed(const World& world, const Manifold& m, double load) {
  const auto inverse_mass = [&](Slot slot) {
    const BodyProperties& p = world.properties[static_cast<std::size_t>(slot)];
    return p.is_dynamic() ? 1 / p.mass : 0;
  };
  constexpr double at_rim = 3;  // the inverse mass at the rim, over the body's: 1 + R^2 / (R^2 / 2) of a disc
  return at_rim * m.friction * load * (inverse_mass(m.slot_a) + inverse_mass(m.slot_b));
}

// The ring takes the load over from its rims, of which there are as many as parts or triangles. `total`: N s, of all.
void level(const World& world, const std::vector<Points>& all, const Manifold& m, const FrictionFrame& frame, double total) {
  const Points& ring = all.back();
  const double stopped = stopped_speed(world, m, total);
  const Vec3 s = frame.s, t = m.normal.cross(s);
  const auto place = [&](const ContactPoint& p) { return Vector2d(s.dot(p.position), t.dot(p.position)); };
  const auto n = static_cast<double>(ring.contacts.size());
  Vector2d middle = Vector2d::Zero(), moment = Vector2d::Zero();
  for (const ContactPoint& p : ring.contacts) middle += place(p) / n;
  double sum = 0;
  for (const Points& points : all)
    for (std::size_t k = 0; k < points.contacts.size(); ++k) {
      sum += points.impulses[k].n;
      moment += points.impulses[k].n * (place(points.contacts[k]) - middle);
    }
  Matrix2d squares = Matrix2d::Zero();
  for (const ContactPoint& p : ring.contacts) squares += (place(p) - middle) * (place(p) - middle).transpose();
  // Nothing to share out; or all points on a line, but for round-off, which would be taken for a slope.
  constexpr double least_width = 1e-6;  // of the ring's points across their line, squared, over along it
  if (!(sum > 0) || !(squares.determinant() > least_width * squares.trace() * squares.trace())) return;
  const Vector2d slope = squares.inverse() * moment;
  const auto pressure = [&](const ContactPoint& p) { return sum / n + slope.dot(place(p) - middle); };
  if (std::ranges::any_of(ring.contacts, [&](const ContactPoint& p) { return pressure(p) < 0; })) return;

  for (const Points& rim : std::span(all).first(all.size() - 1)) std::ranges::fill(rim.impulses, ContactBatch::Impulse{0, 0, 0});
  const double factor = total / sum;
  for (std::size_t k = 0; k < ring.contacts.size(); ++k) {
    Vector2d sliding = sliding_at(world, m, s, ring.contacts[k].position);
    sliding.y() *= frame.across;
    const double load = factor * pressure(ring.contacts[k]);
    const double speed = std::max(sliding.norm(), stopped);
    const Vector2d friction = speed > 0 ? Vector2d(-m.friction * load / speed * sliding) : Vector2d(Vector2d::Zero());
    ring.impulses[k] = {load, friction.x(), frame.across * friction.y()};
  }
}

bool same_pair(const Manifold& a, const Manifold& b) { return a.id_a == b.id_a && a.id_b == b.id_b; }

// Calls f(manifold) for each rim of the ring k.
template <class F>
void for_each_rim(const std::vector<Manifold>& manifolds, std::size_t k, F&& f) {
  std::size_t first = k;
  while (first > 0 && same_pair(manifolds[first - 1], manifolds[k])) --first;
  for (std::size_t i = first; i < k; ++i)
    if (!manifolds[i].is_inner_ring && manifolds[i].normal.dot(manifolds[k].normal) > same_normal) f(manifolds[i]);
}

}  // namespace

void level_pressure(const Multipliers& history, const World& world, const Contacts& contacts, double scale,
                    std::span<ContactBatch::Impulse> impulses) {
  const auto points_of = [&](const Manifold& m) {
    return Points{std::span(contacts.points).subspan(m.first, m.count), impulses.subspan(m.first, m.count)};
  };
  const auto load_of = [&](const Manifold& m) {
    double load = 0;
    for (const ContactBatch::Impulse& impulse : impulses.subspan(m.first, m.count)) load += impulse.n;
    return load;
  };
  const auto& manifolds = contacts.manifolds;
  std::vector<Points> all;
  for (std::size_t k = 0; k < manifolds.size(); ++k) {
    const Manifold& ring = manifolds[k];
    if (!ring.is_inner_ring) continue;
    all.clear();
    double load = load_of(ring), of_pair = 0;  // N s
    for_each_rim(manifolds, k, [&](const Manifold& rim) { all.push_back(points_of(rim)), load += load_of(rim); });
    all.push_back(points_of(ring));
    for (std::size_t i = k; i > 0 && same_pair(manifolds[i - 1], ring); --i) of_pair += load_of(manifolds[i - 1]);
    for (std::size_t i = k; i < manifolds.size() && same_pair(manifolds[i], ring); ++i) of_pair += load_of(manifolds[i]);
    if (load > 0) level(world, all, ring, contacts.frame_of(ring), load / of_pair * scale * remembered_force(history, ring));
  }
}

}  // namespace unibody
