#include "constraints/creep.hpp"

#include <algorithm>

#include "constraints/contact_rows.hpp"
#include "world/world.hpp"

namespace unibody {

using namespace contact_rows;

Vec3 ContactBatch::aim_of(std::size_t manifold) const {
  const Block& block = blocks[places_[manifold] / lanes];
  if (block.drift < 0) return Vec3::Zero();
  const std::size_t lane = places_[manifold] % lanes;
  const Vec3x4& drift = drifts[block.drift];
  return {drift.x[lane], drift.y[lane], drift.z[lane]};
}

void ContactBatch::recall_creeps(const Multipliers* history) {
  creeps_.clear(), creeps_noted_ = false;
  if (history == nullptr || history->creeps.empty()) return;
  creeps_.assign(contacts_->manifolds.size(), Vec3::Zero());
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

// The creep of a manifold is the mean of its points' slips, by their normal impulses: what turns about the normal is left out.
void ContactBatch::note_creep(std::span<const SolverBody> bodies) {
  if (tangents.empty()) return;
  if (creeps_.empty()) creeps_.assign(contacts_->manifolds.size(), Vec3::Zero());
  creeps_noted_ = true;
  for (const Block& block : blocks) {
    if (block.first_tangent < 0) continue;
    const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
    const Vec3x4 t = cross(block.n, block.s);
    Vec4d normal = broadcast(0), along_s = normal, along_t = normal, u_s = normal, u_t = normal;
    for (std::uint32_t k = 0; k < block.count; ++k) {
      const PointVelocity u = relative_velocity<true>(block, t, points[block.first_point + k], a, b);
      const Vec4d n = normals[block.first_point + k].lambda;
      const TangentImpulse& impulse = tangent_impulses[block.first_tangent + k];
      normal += n, along_s += impulse.lambda_s, along_t += impulse.lambda_t, u_s += n * u.s, u_t += n * u.t;
    }
    for (std::size_t l = 0; l < lanes; ++l) {
      if (block.manifold[l] < 0) continue;
      const auto i = static_cast<std::size_t>(block.manifold[l]);
      const Manifold& m = contacts_->manifolds[i];
      Vec3& creep = creeps_[i];
      const double limit = sticking * block.friction[l] * normal[l];
      if (!(constrained_.empty() || constrained_[i] != 0) || !(normal[l] > 0) ||
          along_s[l] * along_s[l] + along_t[l] * along_t[l] >= limit * limit) {
        creep.setZero();
        continue;
      }
      const Vec3 s(block.s.x[l], block.s.y[l], block.s.z[l]), other(t.x[l], t.y[l], t.z[l]);
      Vec3 moved = (s * u_s[l] + other * u_t[l]) / normal[l];
      if (is_carried(m)) moved -= drift_of(m);
      creep = creep - m.normal * m.normal.dot(creep) + step_ * moved;
      const double most = most_creep * std::min(bounding_radius(world_->properties[static_cast<std::size_t>(m.slot_a)].shape),
                                                bounding_radius(world_->properties[static_cast<std::size_t>(m.slot_b)].shape));
      if (creep.norm() > most) creep *= most / creep.norm();
    }
  }
}

}  // namespace unibody
