// Gaps evaluated anew before each iteration, rather than linear in the step: for verification, and for steps in which
// bodies turn far. Points are fixed to their bodies and the normal to the world; between two round bodies both follow the
// centres.

#include "constraints/contact_batch.hpp"
#include "constraints/lanes.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

struct Moved {
  Vec3 centre;
  Vec3 travel;  // of the centre
  Quat turn;    // from the start of the step

  Moved(const Vec3& place, const SolverBody& body, double step) {
    travel = step * Eigen::Map<const Vec3>(body.v);
    centre = place + travel;
    const Vec3 half = 0.5 * step * Eigen::Map<const Vec3>(body.w);
    turn = Quat(1, half.x(), half.y(), half.z()).normalized();
  }
};

}  // namespace

void ContactBatch::renew(const SolveState& state) {
  if (stage_.reevaluates) reevaluate(state.bodies);
  limit_bounces(state.bodies);
  renew_soft_points();
}

void ContactBatch::reevaluate(std::span<const SolverBody> bodies) {
  const World& world = *world_;
  const Stage& stage = stage_;
  for (Block& block : blocks)
    for (std::size_t l = 0; l < lanes; ++l) {
      if (block.manifold[l] < 0) continue;
      const Manifold& m = contacts_->manifolds[block.manifold[l]];
      if (m.time > 0) continue;  // what has passed through something has another gap than what is before it
      const Shape &shape_a = world.properties[m.slot_a].shape, &shape_b = world.properties[m.slot_b].shape;
      const Vec3 place_a = place_of(world, m, m.slot_a), place_b = place_of(world, m, m.slot_b);
      const Moved a(place_a, bodies[m.slot_a], stage.step), b(place_b, bodies[m.slot_b], stage.step);
      const bool both_round = is_round(shape_a) && is_round(shape_b);
      for (std::uint32_t p = 0; p < m.count; ++p) {
        const ContactPoint& contact = contacts_->points[m.first + p];
        Point& point = points[block.first_point + p];
        if (!contacts_->bounce.empty() && contacts_->bounce[m.first + p] > 0) continue;  // it has to leave, wherever it is
        double gap = 0;
        if (both_round) {
          const Vec3 apart = a.centre - b.centre;
          const double distance = apart.norm();
          gap = distance - shape_a.size.x() - shape_b.size.x();
          if (distance > 0) {
            const Vec3 n = apart / distance;
            set_lane(block.n, l, n), set_lane(block.s, l, contacts_->frame_at(m, n).s);
            const bool node_a = shape_a.kind == ShapeKind::particle, node_b = shape_b.kind == ShapeKind::particle;
            set_lane(point.arm_a, l, -(node_b ? distance : shape_a.size.x() + 0.5 * gap) * n);
            set_lane(point.arm_b, l, (node_a ? distance : shape_b.size.x() + 0.5 * gap) * n);
          }
        } else {
          const Vec3 half = 0.5 * contact.gap * m.normal;
          const Vec3 on_a = contact.position + half - place_a;
          const Vec3 on_b = contact.position - half - place_b;
          const Vec3 new_a = a.centre + (is_round(shape_a) ? on_a : a.turn * on_a);
          const Vec3 new_b = b.centre + (is_round(shape_b) ? on_b : b.turn * on_b);
          gap = m.normal.dot(new_a - new_b);
        }
        // The kernels add n.u: what is left over is the bias at which r_n = (gap + allowed penetration) / h.
        const Vec3 n = lane_of(block.n, l);
        const SolverBody &ua = bodies[m.slot_a], &ub = bodies[m.slot_b];
        const Vec3 u = Eigen::Map<const Vec3>(ua.v) + Eigen::Map<const Vec3>(ua.w).cross(lane_of(point.arm_a, l)) -
                       Eigen::Map<const Vec3>(ub.v) - Eigen::Map<const Vec3>(ub.w).cross(lane_of(point.arm_b, l));
        const double allowed = stage.bias(contact.gap) - contact.gap / stage.step;
        point.bias[l] = gap / stage.step + allowed - n.dot(u);
      }
    }
}

}  // namespace unibody
