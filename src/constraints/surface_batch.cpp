#include "constraints/surface_batch.hpp"

#include <algorithm>

#include "collide/collide.hpp"
#include "constraints/carried.hpp"
#include "constraints/friction.hpp"
#include "constraints/lanes.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

// The vectors that four records begin with, one a lane.
template <typename Where>
Vec3x4 gathered(const Slot (&slot)[lanes], Where&& where) {
  const auto row = [&](std::size_t l) { return Vec4d(*reinterpret_cast<const Vec4dView*>(where(slot[l]))); };
  Vec4d x = row(0), y = row(1), z = row(2), rest = row(3);
  transpose(x, y, z, rest);
  return {x, y, z};
}

}  // namespace

void SurfaceBatch::build(const BuildContext& context) {
  friction_ = in_directions(context.settings.friction, !context.world.friction_axes.empty()), scaling_ = context.settings.scaling,
  step_ = context.state.step;
  world_ = &context.world, bounce_starts_ = context.bounce_starts;
  const auto& contacts = context.contacts->surface;
  any_ = context.has_surfaces && context.any_over_ranks(!contacts.empty());
  any_bounce_ = std::ranges::any_of(contacts, [](const SurfaceContact& c) { return c.bounce > 0; });
  blocks_.assign((contacts.size() + lanes - 1) / lanes, Block{});
  if (!any_) return;
  std::pmr::vector<std::int32_t> own(context.memory);
  if (context.state.counts.empty()) {
    own.assign(context.state.bodies.size(), 0);
    count(context, own);
    context.exchange(own);
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) fill_lane(i, contacts[i], context);
  const std::span<const std::int32_t> counts = own.empty() ? context.state.counts : own;
  for (Block& block : blocks_) scale(block, context.state.bodies, counts);
}

// How the first side, the body that carries, moves relative to the second: along the surface, and along the normal (m/s).
SurfaceBatch::Drift SurfaceBatch::drift_of(const SurfaceContact& contact) const {
  const auto carrier = static_cast<std::size_t>(contact.slots[0]);
  const Vec3 turn = world_->angular_velocity_of(carrier);
  Vec3 own = Vec3::Zero();
  if (!world_->surface_motions.empty()) own = -own_surface_velocity(*world_, contact.slots[0], contact.arm, contact.normal);
  if (!(step_ * turn.norm() >= least_turn)) return {own, 0};
  Vec3 from = -world_->position[carrier], velocity = -world_->velocity[carrier];
  for (std::size_t k = 1; k < 4; ++k) {
    if (contact.slots[k] < 0) continue;
    const auto i = static_cast<std::size_t>(contact.slots[k]);
    from -= contact.weights[k] * world_->position[i], velocity -= contact.weights[k] * world_->velocity[i];
  }
  const bool rolls = !world_->is_static(contact.slots[0]) && is_round(world_->properties[carrier].shape);
  if (rolls) return {own, 0};
  const bool driven = world_->is_static(contact.slots[0]);
  const double closing = closing_along_normal(turn, from, velocity, turn, true, driven, -contact.normal, step_);
  return {own - drift_along_circle(turn, from, velocity, step_), closing};
}

void SurfaceBatch::fill_lane(std::size_t i, const SurfaceContact& contact, const BuildContext& context) {
  const auto& bodies = context.state.bodies;
  Block& block = blocks_[i / lanes];
  const std::size_t l = i % lanes;
  const auto nobody = static_cast<Slot>(bodies.size() - 1);
  if (l == 0)
    for (auto& ends : block.slot) std::fill(std::begin(ends), std::end(ends), nobody);
  for (std::size_t k = 0; k < 4; ++k) {
    block.slot[k][l] = contact.slots[k] < 0 ? nobody : contact.slots[k];
    block.weight[k][l] = contact.weights[k];
  }
  set_lane(block.arm, l, contact.arm);
  set_lane(block.n, l, contact.normal);
  const FrictionFrame frame = context.contacts->frame_of(contact);
  set_lane(block.s, l, frame.s);
  block.ratio[l] = frame.across;
  const Drift drift = drift_of(contact);
  set_lane(block.drift, l, drift.along);
  block.closing[l] = drift.closing;
  block.friction[l] = acts_in_solve(friction_) ? contact.friction : 0;
  block.gap[l] = contact.gap, block.beyond[l] = contact.beyond, block.bounce[l] = contact.bounce;
  const auto first = static_cast<std::size_t>(contact.slots[0]);
  const double all = bodies[first].inverse_inertia;
  const InverseInertia w = context.state.isotropic[first] ? InverseInertia{all, all, all, 0, 0, 0} : context.state.inertia[first];
  const double entries[6] = {w.xx, w.yy, w.zz, w.yz, w.xz, w.xy};
  for (std::size_t k = 0; k < 6; ++k) block.inertia[k][l] = entries[k];
  block.counted[l] = counts_here(context.world, contact) ? -1 : 0;
}

// Scales the rows as ContactBatch::scale_jacobi does: absolute row sums of the point's own block, masses split by the bodies'
// constraint counts.
void SurfaceBatch::scale(Block& block, std::span<const SolverBody> bodies, std::span<const std::int32_t> counts) const {
  Vec4d linear = broadcast(0), split_linear = broadcast(0), split_first{};
  for (std::size_t k = 0; k < 4; ++k) {
    Vec4d mass{}, split{};
    for (std::size_t l = 0; l < lanes; ++l) {
      mass[l] = bodies[block.slot[k][l]].inverse_mass;
      split[l] = std::max(1.0, scaling_ * counts[block.slot[k][l]]);
    }
    const Vec4d part = block.weight[k] * block.weight[k] * mass;
    linear += part, split_linear += part * split;
    if (k == 0) split_first = split;
  }
  const Vec3x4 axes[3] = {block.n, block.s, cross(block.n, block.s)};
  Vec4d own[3], sum[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3x4 torque = cross(block.arm, axes[i]), turned = multiply(block.inertia, torque);
    own[i] = linear + dot(torque, turned), sum[i] = split_linear + split_first * dot(torque, turned);
    for (std::size_t j = 0; j < 3; ++j)
      if (j != i) {
        const Vec4d coupling = abs(dot(cross(block.arm, axes[j]), turned));
        sum[i] += split_first * coupling;
        if (i > 0 && j > 0) own[i] += coupling;
      }
  }
  const Mask4 rough = block.friction > broadcast(0);
  // Without friction there are no tangents to couple with; the normal row stands alone.
  const Vec4d alone =
      split_linear + split_first * dot(cross(block.arm, block.n), multiply(block.inertia, cross(block.arm, block.n)));
  Vec4d normal = select(rough, sum[0], alone), tangential = select(rough, max(sum[1], sum[2]), broadcast(0));
  if (uses_cone_projection(friction_)) normal = max(normal, tangential), tangential = select(rough, normal, broadcast(0));
  block.normal = {normal, inverse_or_zero(normal), own[0]};
  block.tangential = {tangential, inverse_or_zero(tangential), select(rough, max(own[1], own[2]), broadcast(0))};
}

Vec4d SurfaceBatch::bias_without_bounce(const Block& block) const {
  const Vec4d bias = stage_.bias(block.gap);
  if (stage_.kind != Stage::Kind::position) return bias;
  return select(block.beyond > broadcast(0), min(bias, -block.beyond / broadcast(stage_.step)), bias - block.closing);
}

void SurfaceBatch::start_stage(const Stage& stage) {
  stage_ = stage;
  if (stage.surface_recovery_time >= 0) stage_.recovery_time = stage.surface_recovery_time;
  for (Block& block : blocks_) {
    block.bias = bias_without_bounce(block);
    if (!any_bounce_) continue;
    for (std::size_t l = 0; l < lanes; ++l)
      if (block.bounce[l] > 0) block.bias[l] = std::min(block.bias[l], bias_of_bounce(block, l, block.bounce[l]));
  }
}

void SurfaceBatch::keep_impulses(bool together) {
  for (Block& block : blocks_) {
    if (!together) block.kept = block.lambda, block.lambda = Impulse{};
    block.y = block.lambda;
  }
}

void SurfaceBatch::join_stages() {
  for (Block& block : blocks_) {
    block.lambda.n += block.kept.n, block.lambda.s += block.kept.s, block.lambda.t += block.kept.t;
    block.y = block.lambda, block.kept = Impulse{};
  }
}

SurfaceBatch::Velocity SurfaceBatch::parting(const Block& block, const Vec3x4& t, std::span<const SolverBody> bodies) {
  const Vec4d zero = broadcast(0);
  Vec3x4 u{zero, zero, zero};
  for (std::size_t k = 0; k < 4; ++k) u = u + gathered(block.slot[k], [&](Slot b) { return bodies[b].v; }) * block.weight[k];
  u = u + cross(gathered(block.slot[0], [&](Slot b) { return bodies[b].w; }), block.arm);
  const Vec3x4 sliding = u - block.drift;
  return {dot(block.n, u), dot(block.s, sliding), dot(t, sliding)};
}

template <FrictionModel model>
SurfaceBatch::Impulse SurfaceBatch::stepped(const Block& block, const Velocity& u, const Impulse& from, Vec4d inverse_n,
                                            Vec4d inverse_t) {
  Vec4d r = u.n + block.bias;
  if constexpr (model == FrictionModel::saxce) r += block.friction * sqrt(u.s * u.s + u.t * u.t);
  const ConeForce next =
      project<model>({from.n - inverse_n * r, from.s - inverse_t * u.s, from.t - inverse_t * u.t}, block.friction, block.ratio);
  return {next.n, next.s, next.t};
}

template <FrictionModel model>
void SurfaceBatch::sweep_as(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const Update<Vec4d> update = update_of_four(extrapolation);
  const std::span<Wrench> wrenches = state.wrenches;
  SweepTotals totals(sums.unit);
  for (Block& block : blocks_) {
    const Vec3x4 t = cross(block.n, block.s);
    const Velocity u = parting(block, t, state.bodies);
    const Impulse next = stepped<model>(block, u, block.y, block.normal.inverse, block.tangential.inverse);
    SweepTerms<Vec4d> terms = totals.start();
    const auto advance = [&](Vec4d& lambda, Vec4d& y, Vec4d to, Vec4d r, Vec4d scale) {
      const Vec4d step = to - y, taken = scale * step;
      return update.advance(lambda, y, to, step, r, taken * step, abs(taken), terms);
    };
    const Vec4d n = advance(block.lambda.n, block.y.n, next.n, u.n + block.bias, block.normal.scale);
    const Vec4d s = advance(block.lambda.s, block.y.s, next.s, u.s, block.tangential.scale);
    const Vec4d f = advance(block.lambda.t, block.y.t, next.t, u.t, block.tangential.scale);
    totals.close(terms, block.counted);

    const Vec3x4 force = (block.n * n + block.s * s) + t * f, torque = cross(block.arm, force);
    for (std::size_t l = 0; l < lanes; ++l) {
      const Vec4d all{force.x[l], force.y[l], force.z[l], 0};
      for (std::size_t k = 0; k < 4; ++k) wrenches[block.slot[k][l]].force += broadcast(block.weight[k][l]) * all;
      wrenches[block.slot[0][l]].torque += Vec4d{torque.x[l], torque.y[l], torque.z[l], 0};
    }
  }
  totals.add_to(sums, step_);
}

void SurfaceBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  with_model(friction_, [&]<FrictionModel model>() { sweep_as<model>(state, extrapolation, sums); });
}

// All at once, by masses split among them; from the multipliers themselves, which the momentum of Gauss-Seidel has moved.
double SurfaceBatch::relax(std::size_t, bool, SolveState& state) {
  SweepSums sums;
  for (Block& block : blocks_) block.y = block.lambda;
  sweep(state, {}, sums);
  state.apply_wrenches();
  return sums.change;
}

template <class F>
void SurfaceBatch::for_each_block_residual(std::span<const SolverBody> bodies, F&& f) const {
  with_model(friction_, [&]<FrictionModel model>() {
    for (const Block& block : blocks_) {
      Vec4d of_n = block.normal.mobility, of_t = block.tangential.mobility;
      if (uses_cone_projection(model)) of_n = of_t = max(of_n, of_t);
      const Velocity u = parting(block, cross(block.n, block.s), bodies);
      const Impulse next = stepped<model>(block, u, block.lambda, inverse_or_zero(of_n), inverse_or_zero(of_t));
      const Vec4d ds = next.s - block.lambda.s, dt = next.t - block.lambda.t;
      f(block, Vec4d(max(of_n * abs(next.n - block.lambda.n), of_t * sqrt(ds * ds + dt * dt))));
    }
  });
}

double SurfaceBatch::residual(const SolveState& state) const {
  Vec4d worst = broadcast(0);
  for_each_block_residual(state.bodies, [&](const Block&, Vec4d residual) { worst = max(worst, residual); });
  return step_ * horizontal_max(worst);
}

// A lane without a contact has a residual of 0, and is passed over.
void SurfaceBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  for_each_block_residual(state.bodies, [&](const Block& block, Vec4d residual) {
    for (std::size_t l = 0; l < lanes; ++l)
      if (residual[l] > 0)
        visit(step_ * residual[l], std::array{block.slot[0][l], block.slot[1][l], block.slot[2][l], block.slot[3][l]});
  });
}

void SurfaceBatch::normal_impulses(std::span<double> normal) const {
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const Block& block = blocks_[i / lanes];
    normal[i] = (block.kept.n + block.lambda.n)[i % lanes];
  }
}

void SurfaceBatch::add_applied(const SolveState&, std::span<Vec4d> impulses) const {
  for (const Block& block : blocks_) {
    const Vec3x4 all = block.n * (block.kept.n + block.y.n) + block.s * (block.kept.s + block.y.s) +
                       cross(block.n, block.s) * (block.kept.t + block.y.t);
    for (std::size_t l = 0; l < lanes; ++l)
      for (std::size_t k = 0; k < 4; ++k)
        impulses[static_cast<std::size_t>(block.slot[k][l])] +=
            broadcast(block.weight[k][l]) * Vec4d{all.x[l], all.y[l], all.z[l], 0};
  }
}

void SurfaceBatch::total_impulses(std::span<Vec3> impulses) const {
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    const Block& block = blocks_[i / lanes];
    const std::size_t l = i % lanes;
    const Vec3x4 all = block.n * (block.kept.n + block.lambda.n) + block.s * (block.kept.s + block.lambda.s) +
                       cross(block.n, block.s) * (block.kept.t + block.lambda.t);
    impulses[i] = {all.x[l], all.y[l], all.z[l]};
  }
}

std::int64_t SurfaceBatch::sliding() const {
  std::int64_t count = 0;
  for (const Block& block : blocks_) {
    const Vec4d n = block.kept.n + block.lambda.n, s = block.kept.s + block.lambda.s,
                t = (block.kept.t + block.lambda.t) / block.ratio;
    const Vec4d limit = broadcast(0.999) * block.friction * n;
    const Mask4 at_limit = (limit > broadcast(0)) & (s * s + t * t >= limit * limit) & block.counted;
    for (std::size_t l = 0; l < lanes; ++l) count -= at_limit[l];
  }
  return count;
}

}  // namespace unibody
