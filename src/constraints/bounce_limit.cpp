// Bounces that give no energy. With friction, Newton's hypothesis can: where an impulse along the normal makes a body slide that
// did not, friction works against what the impact itself has made, and the normal gives its speed back all the same (Kane and
// Levinson, Dynamics: Theory and Applications, 1985). In a step the impulses lambda of a contact do the work
// lambda.(u + u')/2, with u and u' the velocities at which the bodies part before and after it, exactly. So two bodies bounce by
// that share of Newton's speeds, at most all, at which their impulses do no work. It follows the multipliers from iteration to
// iteration.

#include <algorithm>

#include "constraints/contact_batch.hpp"
#include "constraints/lanes.hpp"
#include "constraints/surface_batch.hpp"
#include "world/surface_velocity.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

struct Velocities {
  Vec3 before, after;  // m/s, before bounces and as the solver has them, with the spin to which energy belongs
};

Velocities velocities_at(std::span<const BounceStart> starts, std::span<const SolverBody> bodies, Slot s, const Vec3& arm) {
  const auto slot = static_cast<std::size_t>(s);
  const BounceStart& start = starts[slot];
  return {start.velocity + start.spin.cross(arm),
          Eigen::Map<const Vec3>(bodies[slot].v) + (Eigen::Map<const Vec3>(bodies[slot].w) + start.left_out).cross(arm)};
}

// Between surfaces that move along themselves work counts from how these move. m/s, of b's against a's
Vec3 own_velocity(const World& world, const ContactBatch::Block& block, std::size_t lane, const Vec3& arm_a, const Vec3& arm_b,
                  const Vec3& n) {
  return surface_velocity_between(world, block.slot_a[lane], arm_a, block.slot_b[lane], arm_b, n);
}

// Twice the work (J) of impulses, in parts.
struct Work {
  double bounces = 0;  // of the normal ones times the speeds at which Newton's hypothesis has the bodies part
  double others = 0;   // of all but those, as if nothing bounced
  double all = 0;      // as the velocities are

  // bounce: m/s, 0: the point does not.
  void add(const Vec3& impulse, const Vec3& n, double along_n, const Velocities& parting, double bounce) {
    const double work = impulse.dot(parting.before + parting.after);
    all += work, bounces += along_n * bounce;
    others += bounce > 0 ? work - along_n * n.dot(parting.after) : work;
  }
  double share() const { return bounces > 0 ? std::clamp(-others / bounces, 0.0, 1.0) : 1; }
};

}  // namespace

double ContactBatch::bias_of_bounce(const Manifold& m, std::size_t point, double speed) const {
  const ContactPoint& p = contacts_->points[point];
  const auto unseen = [&](Slot s) {
    return m.normal.dot(bounce_starts_[static_cast<std::size_t>(s)].left_out.cross(arm_of(*world_, m, p, s)));
  };
  return std::min(stage_.bias(p.gap), unseen(m.slot_a) - unseen(m.slot_b) - speed);
}

void ContactBatch::start_bounces() {
  bouncing_.clear();
  for (std::uint32_t i = 0; i < blocks.size(); ++i)
    for (std::uint32_t l = 0; l < lanes; ++l) {
      if (blocks[i].manifold[l] < 0) continue;
      const Manifold& m = manifold(blocks[i], l);
      bool bounces = false;
      for (std::uint32_t p = 0; p < m.count; ++p) {
        const double speed = contacts_->bounce[m.first + p];
        if (!(speed > 0)) continue;
        points[blocks[i].first_point + p].bias[l] = bias_of_bounce(m, m.first + p, speed);
        bounces = true;
      }
      if (bounces) bouncing_.push_back({i, l});
    }
  if (kept_ == Kept::nothing) left_shares_.assign(bouncing_.size(), 1);  // else the first stage's, of the same points
}

double ContactBatch::work_of_bounces(const Lane& at) const {
  double work = 0;
  const Vec3 n = lane_of(blocks[at.block].n, at.lane);
  for_each_point(at, [&](std::size_t, std::size_t contact, const Vec3&, const Vec3&, const Vec3& impulse) {
    work += n.dot(impulse) * contacts_->bounce[contact];
  });
  return work;
}

bool ContactBatch::add_gains(std::span<const SolverBody> bodies, std::span<Gain> gains) const {
  bool any = false;
  const auto add = [&](const Lane& at, double work, double bounces) {
    const Block& block = blocks[at.block];
    for (const Slot s : {block.slot_a[at.lane], block.slot_b[at.lane]})
      if (bodies[static_cast<std::size_t>(s)].inverse_mass > 0)
        gains[static_cast<std::size_t>(s)].work += work, gains[static_cast<std::size_t>(s)].bounces += bounces;
  };
  for (const Lane& at : bouncing_) add(at, 0, work_of_bounces(at));
  auto bouncing = bouncing_.begin();
  for (std::uint32_t i = 0; i < blocks.size(); ++i)
    for (std::uint32_t l = 0; l < lanes; ++l) {
      const Block& block = blocks[i];
      if (bouncing != bouncing_.end() && bouncing->block == i && bouncing->lane == l) {
        ++bouncing;
        continue;
      }
      if (block.manifold[l] < 0 || !is_selected(static_cast<std::size_t>(block.manifold[l]))) continue;
      const Vec3 n = lane_of(block.n, l);
      double work = 0;
      for_each_point({i, l}, [&](std::size_t, std::size_t, const Vec3& arm_a, const Vec3& arm_b, const Vec3& impulse) {
        const Velocities a = velocities_at(bounce_starts_, bodies, block.slot_a[l], arm_a);
        const Velocities b = velocities_at(bounce_starts_, bodies, block.slot_b[l], arm_b);
        const double before = n.dot(a.before - b.before), after = n.dot(a.after - b.after);
        if (before > 0) work += n.dot(impulse) * std::max(0.0, before + std::min(0.0, after));
      });
      if (work > 0) add({i, l}, work, 0), any = true;
    }
  return any;
}

void ContactBatch::charge_bounces(std::span<const Gain> gains) {
  for (std::size_t k = 0; k < bouncing_.size(); ++k) {
    const Lane& at = bouncing_[k];
    const Block& block = blocks[at.block];
    double paid = 0;
    for (const Slot s : {block.slot_a[at.lane], block.slot_b[at.lane]}) {
      const Gain& gain = gains[static_cast<std::size_t>(s)];
      if (gain.work > 0) paid += gain.bounces > 0 ? gain.work / gain.bounces : 1;
    }
    left_shares_[k] *= std::max(0.0, 1 - paid);
  }
}

// Calls f(row, number in Contacts::points, arm_a, arm_b, impulse) for each contact point in one lane of a block.
template <class F>
void ContactBatch::for_each_point(const Lane& at, F&& f) const {
  const Block& block = blocks[at.block];
  const Manifold& m = manifold(block, at.lane);
  const Vec3 n = lane_of(block.n, at.lane), s = lane_of(block.s, at.lane), t = n.cross(s);
  for (std::uint32_t p = 0; p < m.count; ++p) {
    const std::size_t normal = block.first_point + p, contact = m.first + p;
    Impulse impulse = row(at.lane, normal, block.first_tangent < 0 ? no_tangent : block.first_tangent + p);
    if (kept_ == Kept::apart) {
      const Impulse& before = kept_impulses_[contact];
      impulse.n += before.n, impulse.s += before.s, impulse.t += before.t;
    }
    f(normal, contact, lane_of(points[normal].arm_a, at.lane), lane_of(points[normal].arm_b, at.lane),
      Vec3(impulse.n * n + impulse.s * s + impulse.t * t));
  }
}

void ContactBatch::limit_bounces(std::span<const SolverBody> bodies) {
  const World& world = *world_;
  for (std::size_t k = 0; k < bouncing_.size(); ++k) {
    const Lane& at = bouncing_[k];
    const Block& block = blocks[at.block];
    const Vec3 n = lane_of(block.n, at.lane);
    Work work;
    for_each_point(at, [&](std::size_t, std::size_t contact, const Vec3& arm_a, const Vec3& arm_b, const Vec3& impulse) {
      const Velocities a = velocities_at(bounce_starts_, bodies, block.slot_a[at.lane], arm_a);
      const Velocities b = velocities_at(bounce_starts_, bodies, block.slot_b[at.lane], arm_b);
      const Vec3 own = own_velocity(world, block, at.lane, arm_a, arm_b, n);
      work.add(impulse, n, n.dot(impulse), {a.before - b.before - own, a.after - b.after - own}, contacts_->bounce[contact]);
    });
    const double share = left_shares_[k] * work.share();
    const Manifold& m = manifold(block, at.lane);
    for (std::uint32_t p = 0; p < m.count; ++p)
      if (const double speed = contacts_->bounce[m.first + p]; speed > 0)
        points[block.first_point + p].bias[at.lane] = bias_of_bounce(m, m.first + p, share * speed);
  }
}

// A manifold's impulses, times 1 - x, do twice the work (1 - x)(w - x q), with w that of all and q = lambda.D^T W D lambda.
void ContactBatch::give_back_gains(SolveState& state) {
  const World& world = *world_;
  const std::span<const SolverBody> bodies = state.bodies;
  const std::span<Wrench> wrenches = state.wrenches;
  const auto store = [](const Vec3& v) { return Vec4d{v.x(), v.y(), v.z(), 0}; };
  for (const Lane& at : bouncing_) {
    const Block& block = blocks[at.block];
    if (!is_selected(static_cast<std::size_t>(block.manifold[at.lane]))) continue;
    const Slot slot_a = block.slot_a[at.lane], slot_b = block.slot_b[at.lane];
    Work work;
    Vec3 force = Vec3::Zero(), torque_a = force, torque_b = force;
    for_each_point(at, [&](std::size_t, std::size_t, const Vec3& arm_a, const Vec3& arm_b, const Vec3& impulse) {
      const Velocities a = velocities_at(bounce_starts_, bodies, slot_a, arm_a),
                       b = velocities_at(bounce_starts_, bodies, slot_b, arm_b);
      const Vec3 own = own_velocity(world, block, at.lane, arm_a, arm_b, lane_of(block.n, at.lane));
      work.add(impulse, Vec3::Zero(), 0, {a.before - b.before - own, a.after - b.after - own}, 0);
      force += impulse, torque_a += arm_a.cross(impulse), torque_b += arm_b.cross(impulse);
    });
    if (!(work.all > 0)) continue;
    // A block has matrices of inertia if any of its bodies needs one, which depends on the rank. So a body whose inertia is
    // isotropic must get the same bits with a matrix and without.
    const auto turned = [&](Slot slot, const Vec4d(Inertia::*side)[6], const Vec3& torque) -> double {
      if (block.inertia < 0) return torque.dot(bodies[slot].inverse_inertia * torque);
      const Vec4d* w = inertias[block.inertia].*side;
      const auto entry = [&](std::size_t k) { return w[k][at.lane]; };
      const double x = torque.x(), y = torque.y(), z = torque.z();
      return torque.dot(Vec3(entry(0) * x + entry(5) * y + entry(4) * z, entry(5) * x + entry(1) * y + entry(3) * z,
                             entry(4) * x + entry(3) * y + entry(2) * z));
    };
    const double q = (bodies[slot_a].inverse_mass + bodies[slot_b].inverse_mass) * force.squaredNorm() +
                     turned(slot_a, &Inertia::a, torque_a) + turned(slot_b, &Inertia::b, torque_b);
    const double x = work.all < q ? work.all / q : 1;
    for (std::uint32_t p = 0; p < block.count; ++p) {
      normals[block.first_point + p].lambda[at.lane] *= 1 - x;
      if (block.first_tangent < 0) continue;
      TangentImpulse& sideways = tangent_impulses[block.first_tangent + p];
      sideways.lambda_s[at.lane] *= 1 - x, sideways.lambda_t[at.lane] *= 1 - x;
    }
    const Manifold& m = manifold(block, at.lane);
    for (std::uint32_t p = m.first; p < m.first + m.count && kept_ == Kept::apart; ++p)
      kept_impulses_[p] = {(1 - x) * kept_impulses_[p].n, (1 - x) * kept_impulses_[p].s, (1 - x) * kept_impulses_[p].t};
    wrenches[slot_a].force -= store(x * force), wrenches[slot_a].torque -= store(x * torque_a);
    wrenches[slot_b].force += store(x * force), wrenches[slot_b].torque += store(x * torque_b);
  }
  start_momenta();
}

double SurfaceBatch::bias_of_bounce(const Block& block, std::size_t lane, double speed) const {
  const Vec3& left_out = bounce_starts_[static_cast<std::size_t>(block.slot[0][lane])].left_out;
  return block.weight[0][lane] * lane_of(block.n, lane).dot(left_out.cross(lane_of(block.arm, lane))) - speed;
}

void SurfaceBatch::renew(const SolveState& state) {
  if (!any_bounce_) return;
  const World& world = *world_;
  const std::span<const SolverBody> bodies = state.bodies;
  for (Block& block : blocks_) {
    const Vec4d without = bias_without_bounce(block);
    for (std::size_t l = 0; l < lanes; ++l) {
      if (!(block.bounce[l] > 0)) continue;
      const Vec3 n = lane_of(block.n, l), s = lane_of(block.s, l), arm = lane_of(block.arm, l);
      Velocities parting{Vec3::Zero(), Vec3::Zero()};
      for (std::size_t k = 0; k < 4; ++k) {
        if (block.weight[k][l] == 0) continue;
        const Velocities end = velocities_at(bounce_starts_, bodies, block.slot[k][l], k == 0 ? arm : Vec3(Vec3::Zero()));
        parting.before += block.weight[k][l] * end.before, parting.after += block.weight[k][l] * end.after;
      }
      if (!world.surface_motions.empty()) {
        const Slot body = block.slot[0][l];
        const Vec3 own = own_surface_velocity(world, body, arm, n);
        parting.before += own, parting.after += own;
      }
      const double along_n = (block.lambda.n + block.kept.n)[l];
      Work work;
      work.add(along_n * n + (block.lambda.s + block.kept.s)[l] * s + (block.lambda.t + block.kept.t)[l] * n.cross(s), n, along_n,
               parting, block.bounce[l]);
      block.bias[l] = std::min(without[l], bias_of_bounce(block, l, work.share() * block.bounce[l]));
    }
  }
}

}  // namespace unibody
