#include "collide/face_patch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "collide/cores.hpp"
#include "collide/merge_supports.hpp"

namespace unibody {

namespace {

constexpr double least_turn = 1e-4;  // rad a step
constexpr double least_slip = 0.1;   // of what a body falls in a step, at the rim
constexpr double most_slant = 0.02;  // tangent of the angle between faces that lie on each other

// The mean distance of a regular polygon's area from its middle, over that of its corners. More than four corners are of
// something round.
double mean_distance(int corners) {
  if (corners > 4) return 2.0 / 3;
  return corners == 4 ? 0.5411 : 0.4600;
}

// The points of a manifold that lie in the faces. A thin box's manifold with a plane may hold corners of its far side as well,
// which do not.
struct FacePoints {
  std::array<const ContactPoint*, PairManifold::kept> points;
  int count = 0;
  Vec3 middle = Vec3::Zero();
  double gap = 0, reach = 0;  // m

  explicit FacePoints(const PairManifold& m) {
    double least = HUGE_VAL, size = 0;
    for (int k = 0; k < m.count; ++k) {
      least = std::min(least, m.points[k].gap);
      size = std::max(size, (m.points[k].position - m.points[0].position).norm());
    }
    for (int k = 0; k < m.count; ++k)
      if (m.points[k].gap <= least + most_slant * size) points[static_cast<std::size_t>(count++)] = &m.points[k];
    for (int k = 0; k < count; ++k) middle += at(k).position / count, gap += at(k).gap / count;
    for (int k = 0; k < count; ++k) reach = std::max(reach, (at(k).position - middle).norm());
  }
  const ContactPoint& at(int k) const { return *points[static_cast<std::size_t>(k)]; }
};

}  // namespace

bool needs_inner_ring(const PairManifold& rim, const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  if (rim.count < 3 || a.dynamic == b.dynamic) return false;
  const double turn = settings.step * std::abs(rim.normal.dot(a.spin - b.spin));
  if (!(turn > least_turn)) return false;
  const FacePoints face(rim);
  return face.count >= 3 && turn * face.reach > least_slip * std::max(a.fall, b.fall);
}

PairManifold inner_ring(const PairManifold& rim) {
  const FacePoints face(rim);
  PairManifold ring = rim;
  ring.is_inner_ring = true, ring.count = 0;
  const double size = mean_distance(face.count);
  for (int k = 0; k < face.count; ++k) {
    const ContactPoint& p = face.at(k);
    ring.add(face.middle + size * (p.position - face.middle), face.gap + size * (p.gap - face.gap), p.feature);
  }
  return ring;
}

FaceRings::FaceRings(const Proxy& a, const Proxy& b, const CollideSettings& settings)
    : a_(a), b_(b), settings_(settings), turns_(settings.step * (a.spin - b.spin).norm() > least_turn) {}

void FaceRings::add(const PairManifold& m) {
  if (turns_ && m.points[0].feature != core_feature) found_.push_back(m);
}

void FaceRings::for_each(const std::function<void(const PairManifold&)>& f) const {
  std::vector<ContactPoint> points;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const auto joins = [&](std::size_t k) { return k == i || share_normal(found_[i], found_[k]); };
    std::size_t first = 0;
    while (!joins(first)) ++first;
    if (first < i) continue;  // it has joined that one
    points.clear();
    for (std::size_t k = i; k < found_.size(); ++k)
      if (joins(k)) points.insert(points.end(), found_[k].points, found_[k].points + found_[k].count);
    const bool alone = points.size() == static_cast<std::size_t>(found_[i].count);
    const PairManifold rim = alone ? found_[i] : support_of(points, found_[i].normal, {settings_.margin});
    if (needs_inner_ring(rim, a_, b_, settings_)) f(inner_ring(rim));
  }
}

void leave_out_rings_in_piles(const World& world, Contacts& contacts) {
  const auto is_ring = [](const Manifold& m) { return m.is_inner_ring; };
  if (std::ranges::none_of(contacts.manifolds, is_ring)) return;
  std::vector<std::int32_t> partners(world.size(), 0);
  for (std::size_t i = 0; i < contacts.manifolds.size(); ++i) {
    const Manifold& m = contacts.manifolds[i];
    if (i > 0 && contacts.manifolds[i - 1].id_a == m.id_a && contacts.manifolds[i - 1].id_b == m.id_b) continue;
    ++partners[static_cast<std::size_t>(m.slot_a)], ++partners[static_cast<std::size_t>(m.slot_b)];
  }
  for (const SurfaceContact& c : contacts.surface)
    for (std::size_t k = 0; k < c.slots.size(); ++k)
      if (c.ids[k] >= 0) ++partners[static_cast<std::size_t>(c.slots[k])];
  leave_out(contacts, [&](const Manifold& m) {
    const bool a_moves = world.properties[static_cast<std::size_t>(m.slot_a)].is_dynamic();
    return m.is_inner_ring && partners[static_cast<std::size_t>(a_moves ? m.slot_a : m.slot_b)] > 1;
  });
}

}  // namespace unibody
