// ContactBatch: the rows of contacts that give way. The softness of such a row is added to its scale once a step. What the
// softness and the row's present multiplier make together is added to the row's bias before each iteration. The kernels therefore
// do not know of it, and scenes without such contacts pay nothing.

#include "constraints/compliance.hpp"
#include "constraints/contact_for_each.hpp"
#include "constraints/contact_rows.hpp"
#include "world/world.hpp"

namespace unibody {

using namespace contact_rows;

namespace {

constexpr double never = 1e9;  // m/s, bias of a row that is to do nothing

}  // namespace

// What will touch late in the step (Manifold::time) is met as if it were rigid: it comes so fast that no step resolves it.
void ContactBatch::soften(const BuildContext& context) {
  soft_points_.clear();
  const MaterialPairs* pairs = context.pairs;
  if (!pairs || !(pairs->any(PairValue::stiffness) || pairs->any(PairValue::elastic_modulus))) return;
  const std::span<const SolverBody> bodies = context.state.bodies;
  for_each_row([&](std::size_t number, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    const Manifold& m = contacts_->manifolds[number];
    const ContactLaw law = contact_law(*pairs, world_->properties[m.slot_a], world_->properties[m.slot_b]);
    if (!law.complies() || m.time > 0) return;
    SoftPoint soft{static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(l), static_cast<std::uint32_t>(contact), 0, never};
    Point& point = points[p];
    if (!m.is_inner_ring) {  // whose points are none of their own
      const Block& block = blocks[places_[number] / lanes];
      const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
      const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
      const Vec4d mobilities = mobility<false>(block, block.s, point, a, b, inertia).nn;
      const SoftRow row = soft_row(law, contacts_->points[contact].gap, mobilities[l], step_);
      soft.softness = row.softness, soft.bias = row.bias - closing_of(m);  // the gap is that at the end of the step
    }
    const double scale = 1 / point.inverse_scale[l] + soft.softness;
    point.inverse_scale[l] = 1 / scale;
    if (!is_gauss_seidel_) normal_scales[p][l] = scale;
    if (uses_cone_projection(friction_) && t != no_tangent && m.friction > 0) {
      tangents[t].inverse_scale[l] = 1 / scale;
      if (!is_gauss_seidel_) tangent_scales[t][l] = scale;
    }
    soft_points_.push_back(soft);
  });
}

void ContactBatch::renew_soft_points() {
  for (const SoftPoint& soft : soft_points_) {
    const double now = is_gauss_seidel_ ? normals[soft.point].lambda[soft.lane] : normal_momenta[soft.point].y[soft.lane];
    const double before = kept_ == Kept::apart ? kept_impulses_[soft.contact].n : 0;
    points[soft.point].bias[soft.lane] = soft.bias + soft.softness * (now + before);
  }
}

}  // namespace unibody
