// The end of a stage: no body sinks through what does not move.

#include <algorithm>

#include "collide/cores.hpp"
#include "constraints/contact_rows.hpp"
#include "world/world.hpp"

namespace unibody {

using namespace contact_rows;

namespace {

// One manifold of a block, its lane beside three empty ones, with the scales of its points alone.
struct LoneManifold {
  LoneManifold(const ContactBatch& batch, const Block& whole, std::size_t lane, const Inertia* inertia, bool cone,
               std::span<const SolverBody> bodies)
      : block(whole), drift(batch.drift_at(whole)), ratio(batch.ratio_at(whole)) {
    for (std::size_t l = 0; l < lanes; ++l)
      if (l != lane) block.slot_a[l] = block.slot_b[l] = static_cast<Slot>(bodies.size() - 1);  // nobody
    const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
    for (std::uint32_t k = 0; k < block.count; ++k) {
      points[k] = batch.points[block.first_point + k], normals[k] = batch.normals[block.first_point + k];
      const Mobility own = mobility<true>(block, cross(block.n, block.s), points[k], a, b, inertia);
      const Vec4d across = select(block.friction > broadcast(0), own.tangential(), broadcast(0));
      const Vec4d along = cone ? max(own.nn, across) : own.nn;
      set(points[k].inverse_scale, along);
      if (block.first_tangent < 0) continue;
      const std::size_t t = static_cast<std::size_t>(block.first_tangent) + k;
      tangents[k] = batch.tangents[t], tangent_impulses[k] = batch.tangent_impulses[t];
      set(tangents[k].inverse_scale, cone ? along : across);
    }
    for (std::size_t l = 0; l < lanes; ++l)
      if (l != lane) clear(l);
  }

  // The other lanes keep the normals and the inertia of bodies that are not theirs: a step there would turn the body that is
  // nobody, which joints to the world take to be at rest.
  void clear(std::size_t l) {
    for (std::uint32_t k = 0; k < block.count; ++k) {
      points[k].inverse_scale[l] = 0, normals[k].lambda[l] = 0;
      if (block.first_tangent < 0) continue;
      tangents[k].inverse_scale[l] = 0, tangent_impulses[k].lambda_s[l] = 0, tangent_impulses[k].lambda_t[l] = 0;
    }
  }

  // Rows that are not there stay so.
  static void set(Vec4d& inverse_scale, Vec4d scale) {
    inverse_scale = select(inverse_scale > broadcast(0), inverse_or_zero(scale), broadcast(0));
  }

  template <FrictionModel model>
  void relax(const Inertia* inertia, bool backwards, std::span<SolverBody> bodies) {
    const auto relax_as = [&]<bool tangential, bool isotropic>() {
      relax_block<model, tangential, isotropic>(block, points, normals, tangents, tangent_impulses, couplings, inertia, drift,
                                                ratio, backwards, bodies);
    };
    if (block.first_tangent >= 0)
      inertia ? relax_as.template operator()<true, false>() : relax_as.template operator()<true, true>();
    else
      inertia ? relax_as.template operator()<false, false>() : relax_as.template operator()<false, true>();
  }

  Block block;
  const Drift* drift;
  Vec4d ratio;  // of the coefficients of friction
  Point points[8];
  Normal normals[8];
  Tangents tangents[8];
  TangentImpulse tangent_impulses[8];
  Coupling couplings[8] = {};  // left out: the next pass sees them
};

}  // namespace

// Whether a body would end the step further in what does not move than its centre now is out of it, along the normal. (With half
// as much towers that 20 iterations hold fall: what lies on a body that is pushed out so is left behind.)
bool ContactBatch::sinks(const Block& block, std::size_t lane, bool is_a, std::span<const SolverBody> bodies) const {
  const Manifold& m = manifold(block, lane);
  const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
  for (std::uint32_t k = 0; k < m.count; ++k) {
    const Point& p = points[block.first_point + k];
    const Vec4d gap = broadcast(contacts_->points[m.first + k].gap);
    const Vec4d end = gap + broadcast(step_) * relative_velocity<false>(block, block.s, p, a, b).n;
    const Vec4d out = is_a ? -dot(block.n, p.arm_a) : dot(block.n, p.arm_b);
    if (end[lane] < 0 && -end[lane] > out[lane]) return true;
  }
  return false;
}

void ContactBatch::settle(std::size_t homes, std::size_t first_static, std::span<SolverBody> bodies) {
  constexpr int passes = 4;
  const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < homes; };
  for (std::size_t i = 0; i < blocks.size(); ++i)
    for (std::size_t l = 0; l < lanes; ++l) {
      const Slot a = blocks[i].slot_a[l], b = blocks[i].slot_b[l];
      if (is_home(a) == is_home(b) || static_cast<std::size_t>(is_home(a) ? b : a) < first_static) continue;
      if (!is_selected(static_cast<std::size_t>(blocks[i].manifold[l])) || !sinks(blocks[i], l, is_home(a), bodies)) continue;
      const Inertia* inertia = blocks[i].inertia < 0 ? nullptr : &inertias[blocks[i].inertia];
      LoneManifold lone(*this, blocks[i], l, inertia, uses_cone_projection(friction_), bodies);
      with_model(friction_, [&]<FrictionModel model>() {
        for (int pass = 0; pass < passes; ++pass) lone.template relax<model>(inertia, pass % 2 == 1, bodies);
      });
      for (std::uint32_t k = 0; k < blocks[i].count; ++k) {
        normals[blocks[i].first_point + k].lambda[l] = lone.normals[k].lambda[l];
        if (blocks[i].first_tangent < 0) continue;
        TangentImpulse& sideways = tangent_impulses[static_cast<std::size_t>(blocks[i].first_tangent) + k];
        sideways.lambda_s[l] = lone.tangent_impulses[k].lambda_s[l], sideways.lambda_t[l] = lone.tangent_impulses[k].lambda_t[l];
      }
    }
}

namespace {

// Whether the body's centre, at the velocities to come, goes into the static body.
bool goes_into(const World& world, const Manifold& m, Slot body, const Vec3& velocity, Slot other, const Vec3& velocity_of_other,
               double step, const Vec3& displaced) {
  CollideSettings settings;
  settings.step = step;
  Proxy a = make_proxy(world, static_cast<std::size_t>(body), settings);
  Proxy b = make_proxy(world, static_cast<std::size_t>(other), settings);
  a.position += place_of(world, m, body) - world.position[static_cast<std::size_t>(body)] + displaced;
  b.position += place_of(world, m, other) - world.position[static_cast<std::size_t>(other)];
  a.velocity = velocity, a.speed = velocity.norm();
  b.velocity = velocity_of_other, b.speed = velocity_of_other.norm();
  return centre_meets(a, b, step);
}

}  // namespace

// Heights (m) are the centre's above the static body's surface, along the manifold's normal. A centre that is behind it already
// goes no further in.
bool ContactBatch::hold_centre(const Manifold& m, bool is_a, bool stop, std::span<SolverBody> bodies) const {
  const Slot own_slot = is_a ? m.slot_a : m.slot_b, other_slot = is_a ? m.slot_b : m.slot_a;
  const auto own = static_cast<std::size_t>(own_slot), other = static_cast<std::size_t>(other_slot);
  if (bodies[own].inverse_mass <= 0) return false;
  const World& world = *world_;
  const Vec3 out = is_a ? m.normal : Vec3(-m.normal);
  const ContactPoint& point = contacts_->points[m.first];
  const double closed = m.time * std::max(0.0, -out.dot(world.velocity[own] - world.velocity[other]));
  const Vec3 to_centre = place_then(world, m, own_slot) - point.position;
  const double height = out.dot(to_centre) + 0.5 * (point.gap - m.displaced - closed) + closed + m.displaced;

  Eigen::Map<Vec3> velocity(bodies[own].v);
  const Vec3 arm = arm_of(world, m, point, other_slot);
  const Vec3 surface = Eigen::Map<const Vec3>(bodies[other].v) + Eigen::Map<const Vec3>(bodies[other].w).cross(arm);
  const double parting = out.dot(velocity - surface);
  if (height + step_ * parting >= std::min(height, 0.0)) return false;
  const bool is_plane = world.properties[other].shape.kind == ShapeKind::plane;
  if (!is_plane && !goes_into(world, m, own_slot, velocity, other_slot, surface, step_, m.displaced * out)) return false;
  if (stop) return velocity = surface, true;
  const double kept = std::min(height, 0.25 * smallest_size(world.properties[own].shape));
  velocity += ((kept - height) / step_ - parting) * out;
  return true;
}

void ContactBatch::hold_centres(std::size_t homes, std::size_t first_static, std::span<SolverBody> bodies) const {
  constexpr int most_rounds = 32;  // in a narrow wedge each side sends the centre to the other: then it is stopped
  const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < homes; };
  bool held = true;
  for (int round = 0; held && round < most_rounds; ++round) {
    held = false;
    for (const Block& block : blocks)
      for (std::size_t l = 0; l < lanes; ++l) {
        const Slot a = block.slot_a[l], b = block.slot_b[l];
        if (block.manifold[l] < 0 || is_home(a) == is_home(b)) continue;
        if (static_cast<std::size_t>(is_home(a) ? b : a) < first_static) continue;
        if (!is_selected(static_cast<std::size_t>(block.manifold[l]))) continue;
        const Manifold& m = contacts_->manifolds[static_cast<std::size_t>(block.manifold[l])];
        held = hold_centre(m, is_home(a), round == most_rounds - 1, bodies) || held;
      }
  }
}

void ContactBatch::end_stage(SolveState& state) {
  if (!is_gauss_seidel_) settle(state.homes, state.first_static, state.bodies);
  hold_centres(state.homes, state.first_static, state.bodies);
}

}  // namespace unibody
