#include "constraints/recall.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "collide/cores.hpp"
#include "constraints/carried.hpp"
#include "core/capacity.hpp"

namespace unibody {

namespace {

// A remembered point further off than this share of the smaller body's bounding radius is another point.
constexpr double reach = 0.1;

// The body whose frame a manifold's points are remembered in: a, unless it is static and would not carry them along.
Slot carrier(const World& world, const Manifold& m) { return world.is_static(m.slot_a) ? m.slot_b : m.slot_a; }

// There is one point at most, which rolls about its body and is the same contact wherever it is.
bool has_one_point(const World& world, const Manifold& m) {
  const Shape &a = world.properties[m.slot_a].shape, &b = world.properties[m.slot_b].shape;
  return (is_round(a) || is_round(b)) && !is_composite(a.kind) && !is_composite(b.kind);
}

// Whether the manifold is a core's (collide/cores.hpp). Beside the one point of a round body a core is met in the step of an
// impact only, and is not remembered.
bool is_core(const Contacts& contacts, const Manifold& m) {
  return m.count > 0 && contacts.points[m.first].feature == core_feature;
}

// The places of a manifold's points in the frame of the body that carries them.
class Places {
 public:
  Places(const World& world, const Manifold& m) : world_(world), manifold_(m), carrier_(carrier(world, m)) {
    to_body_ = world.orientation_of(static_cast<std::size_t>(carrier_)).conjugate().toRotationMatrix();
  }
  Vec3 of(const ContactPoint& p) const { return to_body_ * arm_of(world_, manifold_, p, carrier_); }

 private:
  const World& world_;
  const Manifold& manifold_;
  Slot carrier_;
  Mat3 to_body_;
};

// Finds, for each of the manifold's points, the nearest old one within reach that is not taken yet; -1: none.
void match(const World& world, const Contacts& contacts, const Manifold& m, std::span<const Vec3> old, std::vector<bool>& used,
           std::span<int> matches) {
  const Shape &a = world.properties[m.slot_a].shape, &b = world.properties[m.slot_b].shape;
  const double size = reach * std::min(bounding_radius(a), bounding_radius(b));
  const Places places(world, m);
  for (std::uint32_t p = 0; p < m.count; ++p) {
    const Vec3 place = places.of(contacts.points[m.first + p]);
    double nearest = size * size;
    matches[p] = -1;
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double distance2 = (old[k] - place).squaredNorm();
      if (!used[k] && distance2 < nearest) nearest = distance2, matches[p] = static_cast<int>(k);
    }
    if (matches[p] >= 0) used[static_cast<std::size_t>(matches[p])] = true;
  }
}

}  // namespace

void recall(const Multipliers& multipliers, const World& world, const Contacts& contacts, double step,
            std::span<ContactBatch::Impulse> impulses, double share) {
  const double scale = share * step;
  std::fill(impulses.begin(), impulses.end(), ContactBatch::Impulse{0, 0, 0});
  const auto& old = multipliers.manifolds;
  std::size_t k = 0;
  std::vector<bool> used;  // of the pair's old points
  std::pair<Id, Id> last{-1, -1};
  for (const Manifold& m : contacts.manifolds) {
    const auto key = std::pair(m.id_a, m.id_b);
    while (k < old.size() && std::pair(old[k].id_a, old[k].id_b) < key) ++k;
    if (k == old.size()) break;
    if (std::pair(old[k].id_a, old[k].id_b) != key) continue;
    std::array<int, 8> matches{};
    const bool first = key != last;  // of the pair's manifolds
    if (first) used.assign(multipliers.places_of(k).size(), false), last = key;
    if (!has_one_point(world, m))
      match(world, contacts, m, multipliers.places_of(k), used, matches);
    else if (is_core(contacts, m))
      matches.fill(-1);
    const Vec3 s = contacts.frame_of(m).s, t = m.normal.cross(s);
    const Vec3 turn = step * (common_turn(world, m.slot_a, m.slot_b).turn + own_turn(world, m.slot_a, m.slot_b, m.normal));
    const bool carried = turn.norm() >= least_turn && turn.norm() < most_turn;
    const Mat3 turned = carried ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() : Mat3::Identity();
    for (std::uint32_t p = 0; p < m.count; ++p) {
      if (matches[p] < 0) continue;
      const RememberedPoint& from = multipliers.points[old[k].first_point + static_cast<std::size_t>(matches[p])];
      const Vec3 tangential = carried ? Vec3(turned * from.tangential) : from.tangential;
      impulses[m.first + p] = {from.normal * scale, tangential.dot(s) * scale, tangential.dot(t) * scale};
    }
  }
}

void start_remembering(Multipliers& multipliers, const Contacts& contacts) {
  multipliers.creeps.clear();
  const std::size_t places_before = multipliers.places.size();
  renew_room(multipliers.manifolds, contacts.manifolds.size()), renew_room(multipliers.points, contacts.points.size());
  renew_room(multipliers.places, places_before + places_before / 32);
}

bool is_remembered(const World& world, const Contacts& contacts, const Manifold& m) {
  return !(has_one_point(world, m) && is_core(contacts, m));
}

void remember_manifold(Multipliers& multipliers, const World& world, const Contacts& contacts, const Manifold& m,
                       std::span<const ContactBatch::Impulse> of_manifold, double step) {
  const auto is_zero = [](const ContactBatch::Impulse& i) { return i.n == 0 && i.s == 0 && i.t == 0; };
  if (std::all_of(of_manifold.begin(), of_manifold.end(), is_zero)) return;
  if (!is_remembered(world, contacts, m)) return;
  const auto& known = multipliers.manifolds;  // of two bodies of many parts all manifolds are remembered as one
  if (known.empty() || known.back().id_a != m.id_a || known.back().id_b != m.id_b) multipliers.begin_manifold(m.id_a, m.id_b);
  const Vec3 s = contacts.frame_of(m).s, t = m.normal.cross(s);
  for (const ContactBatch::Impulse& i : of_manifold)
    if (!is_zero(i)) multipliers.points.push_back({i.n / step, (s * i.s + t * i.t) / step});
  if (has_one_point(world, m)) return;
  const Places places(world, m);
  make_room(multipliers.places, multipliers.places.size() + m.count);
  for (std::uint32_t p = 0; p < m.count; ++p)
    if (!is_zero(of_manifold[p])) multipliers.places.push_back(places.of(contacts.points[m.first + p]));
}

void remember(Multipliers& multipliers, const World& world, const Contacts& contacts,
              std::span<const ContactBatch::Impulse> impulses, double step) {
  start_remembering(multipliers, contacts);
  for (const Manifold& m : contacts.manifolds)
    remember_manifold(multipliers, world, contacts, m, impulses.subspan(m.first, m.count), step);
}

}  // namespace unibody
