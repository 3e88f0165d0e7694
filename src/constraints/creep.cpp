#include "constraints/creep.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <ranges>

#include "constraints/carried.hpp"
#include "constraints/contact_rows.hpp"
#include "world/world.hpp"

namespace unibody {

using namespace contact_rows;

namespace {

Vec3 in_lane(const Vec3x4& v, std::size_t lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }

// How the bodies of a block's manifolds move along their faces, and what presses and holds them in the whole step, its two stages
// together. Sums over a manifold's points.
struct Rubbing {
  Side a, b;
  Vec3x4 t;  // the second direction in the face
  // Impulses (N s) along the normal and along the two directions in the face; friction is the sum over the points of the sizes of
  // their impulses in the face. What is along t is over the ratio of the coefficients of friction there and along s.
  Vec4d normal = broadcast(0), along_s = broadcast(0), along_t = broadcast(0), friction = broadcast(0);
  // Sums over the points of their normal impulse times their velocity in the face (N m), and times their arm about the first
  // body (N s m).
  Vec4d u_s = broadcast(0), u_t = broadcast(0);
  Vec3x4 middle{broadcast(0), broadcast(0), broadcast(0)};
};

// The impulses of one point of a block's manifolds.
struct PointImpulses {
  Vec4d n, s, t;
};

// before: of the stage before this one, of all points of `contacts`; empty: the batch has them of the whole step.
PointImpulses impulses_of(const ContactBatch& batch, const ContactBatch::Block& block, std::uint32_t k, const Contacts& contacts,
                          std::span<const ContactBatch::Impulse> before) {
  const auto& tangent = batch.tangent_impulses[block.first_tangent + k];
  PointImpulses all{batch.normals[block.first_point + k].lambda, tangent.lambda_s, tangent.lambda_t};
  for (std::size_t l = 0; l < lanes && !before.empty(); ++l) {
    if (block.manifold[l] < 0) continue;
    const Manifold& m = contacts.manifolds[static_cast<std::size_t>(block.manifold[l])];
    if (k >= m.count) continue;  // a block has as many points as its largest manifold
    const ContactBatch::Impulse& more = before[m.first + k];
    all.n[l] += more.n, all.s[l] += more.s, all.t[l] += more.t;
  }
  return all;
}

Rubbing rubbing_of(const ContactBatch& batch, const ContactBatch::Block& block, const Contacts& contacts,
                   std::span<const ContactBatch::Impulse> before, std::span<const SolverBody> bodies) {
  Rubbing sum{gather(block.slot_a, bodies), gather(block.slot_b, bodies), cross(block.n, block.s)};
  for (std::uint32_t k = 0; k < block.count; ++k) {
    const auto& point = batch.points[block.first_point + k];
    const PointVelocity u = relative_velocity<true>(block, sum.t, point, sum.a, sum.b);
    const auto [n, s, t] = impulses_of(batch, block, k, contacts, before);
    const Vec4d along_t = block.ratio < 0 ? t : Vec4d(t / batch.ratio_at(block));
    sum.normal += n, sum.along_s += s, sum.along_t += along_t;
    sum.friction += sqrt(s * s + along_t * along_t);
    sum.u_s += n * u.s, sum.u_t += n * u.t, sum.middle = sum.middle + point.arm_a * n;
  }
  return sum;
}

}  // namespace

Vec3 ContactBatch::aim_of(std::size_t manifold, std::size_t point) const {
  const Block& block = blocks[places_[manifold] / lanes];
  if (block.drift < 0) return Vec3::Zero();
  const std::size_t lane = places_[manifold] % lanes;
  const Drift& drift = drifts[block.drift];
  return in_lane(drift.v, lane) + in_lane(drift.w, lane).cross(in_lane(points[block.first_point + point].arm_a, lane));
}

void ContactBatch::recall_creeps(const Multipliers* history) {
  creeps_.clear(), creeps_noted_ = false;
  if (history == nullptr || history->creeps.empty()) return;
  creeps_.assign(contacts_->manifolds.size(), Creep{});
  const auto& old = history->manifolds;
  std::size_t k = 0;
  for (std::size_t i = 0; i < creeps_.size(); ++i) {
    const Manifold& m = contacts_->manifolds[i];
    const auto key = std::pair(m.id_a, m.id_b);
    while (k < old.size() && std::pair(old[k].id_a, old[k].id_b) < key) ++k;
    if (k == old.size()) break;
    if (std::pair(old[k].id_a, old[k].id_b) == key) creeps_[i] = history->creeps[k];
  }
}

double ContactBatch::smaller_radius(const Manifold& m) const {
  return std::min(bounding_radius(world_->properties[static_cast<std::size_t>(m.slot_a)].shape),
                  bounding_radius(world_->properties[static_cast<std::size_t>(m.slot_b)].shape));
}

Vec3 ContactBatch::creeps_about(const Manifold& m) const {
  const auto radius = [&](Slot slot) { return bounding_radius(world_->properties[static_cast<std::size_t>(slot)].shape); };
  return place_of(*world_, m, radius(m.slot_b) < radius(m.slot_a) ? m.slot_b : m.slot_a);
}

// The slip of a manifold is that of the pair's faces where creeps_about() is above them, which stays the same place of a body:
// the mean of the points' slips, by their normal impulses, and what the turn about the normal adds from their middle to there.
void ContactBatch::note_creep(std::span<const SolverBody> bodies, std::uint32_t least_points) {
  if (tangents.empty()) return;
  const std::size_t manifolds = contacts_->manifolds.size();
  const auto may_begin = [&](std::size_t i) {
    const bool in_pile = !constrained_.empty() && constrained_[i] == 0;
    return contacts_->manifolds[i].count >= (in_pile ? least_points_in_piles : least_points);
  };
  if (creeps_.empty()) {
    if (std::ranges::none_of(std::views::iota(std::size_t{0}, manifolds), may_begin)) return;
    creeps_.assign(manifolds, Creep{});
  }
  creeps_noted_ = true;
  const auto has_memory = [&](std::int32_t i) {
    if (i < 0) return false;
    const auto manifold = static_cast<std::size_t>(i);
    return may_begin(manifold) || !creeps_[manifold].is_zero();
  };
  const auto note = [&](const Block& block, const Rubbing& rubbing, std::size_t l) {
    const auto i = static_cast<std::size_t>(block.manifold[l]);
    const Manifold& m = contacts_->manifolds[i];
    Creep& creep = creeps_[i];
    const double normal = rubbing.normal[l], along_s = rubbing.along_s[l], along_t = rubbing.along_t[l];
    const double limit = sticking * block.friction[l] * normal;
    if (!(normal > 0) || along_s * along_s + along_t * along_t >= limit * limit) {
      const double kept = normal > 0 ? creep_kept : 0;
      creep.slip *= kept, creep.turn *= kept;
      return;
    }
    Vec3 turned = m.normal * m.normal.dot(in_lane(rubbing.a.w, l) - in_lane(rubbing.b.w, l));
    const Vec3 above = creeps_about(m) - place_of(*world_, m, m.slot_a),
               from_middle = above - in_lane(rubbing.middle, l) / normal;
    Vec3 moved =
        (in_lane(block.s, l) * rubbing.u_s[l] + in_lane(rubbing.t, l) * rubbing.u_t[l]) / normal + turned.cross(from_middle);
    if (is_carried(m)) {
      const OwnMotion drift = drift_of(m);
      moved -= drift.v;
      // What has slipped turns along. (With other turns it does by being kept across the normal.)
      double turn = step_ * m.normal.dot(common_turn(*world_, m.slot_a, m.slot_b).turn);
      if (!world_->surface_motions.empty()) {
        moved -= drift.w.cross(above);
        turned -= drift.w, turn += step_ * m.normal.dot(own_turn(*world_, m.slot_a, m.slot_b, m.normal));
      }
      creep.slip = Eigen::AngleAxisd(turn, m.normal) * creep.slip;
    }
    creep.slip += step_ * moved - m.normal * m.normal.dot(creep.slip);
    creep.turn = m.normal * (m.normal.dot(creep.turn) + step_ * m.normal.dot(turned));
    const double most = most_creep * smaller_radius(m);
    if (creep.slip.norm() > most) creep.slip *= most / creep.slip.norm();
    if (rubbing.friction[l] >= limit) creep.turn.setZero();
    if (creep.turn.norm() > most_creep) creep.turn *= most_creep / creep.turn.norm();
  };
  const std::span<const Impulse> before =
      kept_ == Kept::apart ? std::span<const Impulse>(kept_impulses_) : std::span<const Impulse>();
  for (const Block& block : blocks) {
    if (block.first_tangent < 0 || std::ranges::none_of(block.manifold, has_memory)) continue;
    const Rubbing rubbing = rubbing_of(*this, block, *contacts_, before, bodies);
    for (std::size_t l = 0; l < lanes; ++l)
      if (has_memory(block.manifold[l])) note(block, rubbing, l);
  }
}

}  // namespace unibody
