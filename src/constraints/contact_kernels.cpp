// The inner loops over contacts: everything that is hot in a rigid scene is in this file and contact_rows.hpp.

#include <algorithm>

#include "constraints/contact_rows.hpp"

namespace unibody {

using namespace contact_rows;

namespace {

// How many blocks ahead the bodies of a block are asked for: they lie anywhere in the memory, which takes about as long to answer
// as this many blocks take to compute.
constexpr std::size_t ahead = 4;

// Asks for what belongs to the bodies of the block that comes some blocks after block i.
template <class Record>
[[gnu::always_inline]] inline void ask_for(std::span<const Block> blocks, std::size_t i, std::span<Record> of_bodies) {
  const Block& block = blocks[std::min(i + ahead, blocks.size() - 1)];
  for (std::size_t l = 0; l < lanes; ++l) {
    __builtin_prefetch(&of_bodies[block.slot_a[l]], !std::is_const_v<Record>);
    __builtin_prefetch(&of_bodies[block.slot_b[l]], !std::is_const_v<Record>);
  }
}

// Adds the four lanes' impulses to the wrenches, lane after lane: for each body in ascending key order.
[[gnu::always_inline]] inline void add_wrenches(const Block& block, Vec3x4 force, Vec3x4 torque_a, Vec3x4 torque_b,
                                                std::span<Wrench> wrenches) {
  Vec4d none_f{}, none_a{}, none_b{};
  transpose(force.x, force.y, force.z, none_f);
  transpose(torque_a.x, torque_a.y, torque_a.z, none_a);
  transpose(torque_b.x, torque_b.y, torque_b.z, none_b);
  const Vec4d f[lanes] = {force.x, force.y, force.z, none_f};
  const Vec4d ta[lanes] = {torque_a.x, torque_a.y, torque_a.z, none_a}, tb[lanes] = {torque_b.x, torque_b.y, torque_b.z, none_b};
  for (std::size_t l = 0; l < lanes; ++l) {
    Wrench &a = wrenches[block.slot_a[l]], &b = wrenches[block.slot_b[l]];
    a.force += f[l], a.torque += ta[l];
    b.force -= f[l], b.torque -= tb[l];
  }
}

template <FrictionModel model, bool tangential>
SweepTerms<Vec4d> sweep_block(ContactBatch& batch, const Block& block, const Update<Vec4d>& update, SweepTerms<Vec4d> sums,
                              std::span<const SolverBody> bodies, std::span<Wrench> wrenches) {
  const std::size_t first = block.first_point, first_tangent = tangential ? static_cast<std::size_t>(block.first_tangent) : 0;
  const Side a = less_drift(gather(block.slot_a, bodies), batch.drift_at(block)), b = gather(block.slot_b, bodies);
  const Vec3x4 t = cross(block.n, block.s);
  const Vec4d zero = broadcast(0), ratio = model == FrictionModel::ellipse ? batch.ratio_at(block) : broadcast(1);
  Vec3x4 force{zero, zero, zero}, torque_a = force, torque_b = force;
  for (std::uint32_t k = 0; k < block.count; ++k) {
    const Point& p = batch.points[first + k];
    Normal& normal = batch.normals[first + k];
    NormalMomentum& along = batch.normal_momenta[first + k];
    const Tangents* tangent = tangential ? &batch.tangents[first_tangent + k] : nullptr;
    TangentMomentum* sideways = tangential ? &batch.tangent_momenta[first_tangent + k] : nullptr;
    const PointVelocity u = relative_velocity<tangential>(block, t, p, a, b);
    ConeForce from{along.y, zero, zero};
    if constexpr (tangential) from.s = sideways->y_s, from.t = sideways->y_t;
    const ConeForce next = project_step<model, tangential>(block, p, tangent, u, from, ratio);

    const auto advance = [&](Vec4d& lambda, Vec4d& y, Vec4d new_lambda, Vec4d r, Vec4d scale) {
      const Vec4d step = new_lambda - y, taken = scale * step;
      return update.advance(lambda, y, new_lambda, step, r, taken * step, abs(taken), sums);
    };
    const Vec4d dn = advance(normal.lambda, along.y, next.n, u.n + p.bias, batch.normal_scales[first + k]);
    Vec4d ds = zero, dt = zero;
    if constexpr (tangential) {
      TangentImpulse& impulse = batch.tangent_impulses[first_tangent + k];
      const Vec4d scale = batch.tangent_scales[first_tangent + k];
      ds = advance(impulse.lambda_s, sideways->y_s, next.s, u.s, scale);
      dt = advance(impulse.lambda_t, sideways->y_t, next.t, u.t, scale);
    }
    const Vec3x4 f = impulse_vector<tangential>(block, t, dn, ds, dt);
    force = force + f, torque_a = torque_a + cross(p.arm_a, f), torque_b = torque_b + cross(p.arm_b, f);
  }
  add_wrenches(block, force, torque_a, torque_b, wrenches);
  return sums;
}

// The natural residual's own step, 1/K of the point alone, so that it does not depend on the solver's scaling. softness: what the
// normal row has beside it (compliance.hpp): the residual is then the speed that the multiplier's error makes. `ratio` is the
// coefficient of friction along t divided by the one along s.
template <FrictionModel model, bool tangential>
Vec4d point_residual(const Block& block, const Vec3x4& t, Point p, const Normal& normal, const TangentImpulse* sideways,
                     const Side& a, const Side& b, const Inertia* inertia, Vec4d softness, Vec4d ratio) {
  const Mask4 in_use = p.inverse_scale > broadcast(0);
  const Mobility k = mobility<tangential>(block, t, p, a, b, inertia);
  const PointVelocity u = relative_velocity<tangential>(block, t, p, a, b);
  const Vec4d along = select(in_use, k.nn, broadcast(0)), lambda = normal.lambda;
  p.inverse_scale = select(in_use, inverse_or_zero(along + softness), broadcast(0));
  if constexpr (!tangential) {
    const ConeForce next = project_step<model, false>(block, p, nullptr, u, {lambda, lambda, lambda});
    return along * abs(next.n - lambda);
  } else {
    Vec4d across = select(in_use & (block.friction > broadcast(0)), k.tangential(), broadcast(0));
    if (uses_cone_projection(model)) across = max(along, across);
    const Tangents own{inverse_or_zero(across)};
    if (uses_cone_projection(model)) p.inverse_scale = inverse_or_zero(across + softness);
    const ConeForce next = project_step<model, true>(block, p, &own, u, {lambda, sideways->lambda_s, sideways->lambda_t}, ratio);
    const Vec4d ds = next.s - sideways->lambda_s, dt = next.t - sideways->lambda_t;
    return max(along * abs(next.n - lambda), across * sqrt(ds * ds + dt * dt));
  }
}

}  // namespace

double ContactBatch::relax(std::size_t group, bool backwards, std::span<SolverBody> bodies) {
  const std::uint32_t begin = group == 0 ? 0 : group_end_[group - 1], end = group_end_[group];
  return with_model(friction_, [&]<FrictionModel model>() {
    Vec4d change = broadcast(0);
    for (std::uint32_t i = begin; i < end; ++i) {
      const Block& block = blocks[i];
      ask_for<SolverBody>(blocks, i, bodies);
      const std::int32_t t = block.first_tangent;
      const Tangents* tangent = t < 0 ? nullptr : &tangents[t];
      TangentImpulse* sideways = t < 0 ? nullptr : &tangent_impulses[t];
      const Coupling* coupling = t < 0 ? nullptr : &couplings[t];
      const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
      const Vec4d ratio = model == FrictionModel::ellipse ? ratio_at(block) : broadcast(1);
      const auto relax_as = [&]<bool tangential, bool isotropic>() {
        return relax_block<model, tangential, isotropic>(block, &points[block.first_point], &normals[block.first_point], tangent,
                                                         sideways, coupling, inertia, drift_at(block), ratio, backwards, bodies);
      };
      if (tangent)
        change = max(change, inertia ? relax_as.template operator()<true, false>() : relax_as.template operator()<true, true>());
      else
        change =
            max(change, inertia ? relax_as.template operator()<false, false>() : relax_as.template operator()<false, true>());
    }
    return step_ * horizontal_max(change);
  });
}

void ContactBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const std::span<const SolverBody> bodies = state.bodies;
  const std::span<Wrench> wrenches = state.wrenches;
  const Update<Vec4d> update = update_of_four(extrapolation);
  with_model(friction_, [&]<FrictionModel model>() {
    SweepTotals totals(sums.unit);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Block& block = blocks[i];
      ask_for<const SolverBody>(blocks, i, bodies), ask_for<Wrench>(blocks, i, wrenches);
      const SweepTerms<Vec4d> terms = block.first_tangent < 0
                                          ? sweep_block<model, false>(*this, block, update, totals.start(), bodies, wrenches)
                                          : sweep_block<model, true>(*this, block, update, totals.start(), bodies, wrenches);
      Mask4 counts;
      for (std::size_t l = 0; l < lanes; ++l) counts[l] = block.manifold[l] >= 0 && counted_[block.manifold[l]] != 0 ? -1 : 0;
      totals.close(terms, counts);
    }
    totals.add_to(sums, step_);
  });
}

template <class F>
void ContactBatch::for_each_block_residual(std::span<const SolverBody> bodies, F&& f) const {
  std::vector<Vec4d> softness(soft_points_.empty() ? 0 : points.size(), broadcast(0));
  for (const SoftPoint& soft : soft_points_) softness[soft.point][soft.lane] = soft.softness;
  with_model(friction_, [&]<FrictionModel model>() {
    for (std::size_t number = 0; number < blocks.size(); ++number) {
      const Block& block = blocks[number];
      ask_for<const SolverBody>(blocks, number, bodies);
      const Side a = less_drift(gather(block.slot_a, bodies), drift_at(block)), b = gather(block.slot_b, bodies);
      const Vec3x4 t = cross(block.n, block.s);
      const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
      const Vec4d ratio = model == FrictionModel::ellipse ? ratio_at(block) : broadcast(1);
      Vec4d worst = broadcast(0);
      for (std::uint32_t k = 0; k < block.count; ++k) {
        const Point& p = points[block.first_point + k];
        const Normal& normal = normals[block.first_point + k];
        const TangentImpulse* sideways = block.first_tangent < 0 ? nullptr : &tangent_impulses[block.first_tangent + k];
        const Vec4d soft = softness.empty() ? broadcast(0) : softness[block.first_point + k];
        worst = max(worst, sideways ? point_residual<model, true>(block, t, p, normal, sideways, a, b, inertia, soft, ratio)
                                    : point_residual<model, false>(block, t, p, normal, nullptr, a, b, inertia, soft, ratio));
      }
      f(block, worst);
    }
  });
}

double ContactBatch::residual(std::span<const SolverBody> bodies) const {
  if (!any_selected_) return 0;
  Vec4d worst = broadcast(0);
  for_each_block_residual(bodies, [&](const Block&, Vec4d residual) { worst = max(worst, residual); });
  return step_ * horizontal_max(worst);
}

void ContactBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  if (!any_selected_) return;
  for_each_block_residual(state.bodies, [&](const Block& block, Vec4d residual) {
    for (std::size_t l = 0; l < lanes; ++l)
      if (block.manifold[l] >= 0) visit(step_ * residual[l], std::array{block.slot_a[l], block.slot_b[l]});
  });
}

void ContactBatch::even_out(std::span<const SolverBody> bodies, double tolerance, double share) {
  if (uneven_shares_.empty()) uneven_shares_.assign(contacts_->manifolds.size(), 1);
  for_each_block_residual(bodies, [&](const Block& block, Vec4d residual) {
    for (std::size_t l = 0; l < lanes; ++l)
      if (block.manifold[l] >= 0 && step_ * residual[l] > tolerance)
        uneven_shares_[static_cast<std::size_t>(block.manifold[l])] = share;
  });
}

void ContactBatch::limit_leak(std::span<const SolverBody> bodies, double most_weights, double weight) {
  if (leak_shares_.empty()) leak_shares_.assign(contacts_->points.size(), 1);
  for (const Block& block : blocks) {
    const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
    const Vec4d of_a_weight = broadcast(1 / weight) * max(a.mass, b.mass);  // 1/(N s)
    for (std::size_t l = 0; l < lanes; ++l) {
      if (block.manifold[l] < 0 || !is_selected(static_cast<std::size_t>(block.manifold[l]))) continue;
      const Manifold& m = manifold(block, l);
      double borne = 0;  // N s
      for (std::uint32_t k = 0; k < m.count; ++k) borne += kept_impulses_[m.first + k].n;
      const double part = most_weights / std::max(most_weights, borne * of_a_weight[l]);
      for (std::uint32_t k = 0; k < m.count; ++k)
        leak_shares_[m.first + k] =
            relative_velocity<false>(block, block.s, points[block.first_point + k], a, b).n[l] > 0 ? 0 : part * part * part;
    }
  }
}

ContactBatch::Opening ContactBatch::opening(std::span<const SolverBody> bodies) const {
  Opening sums;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = blocks[i];
    ask_for<const SolverBody>(blocks, i, bodies);
    const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
    Vec4d work = broadcast(0), absolute = work, impulse = work;
    for (std::uint32_t k = block.first_point; k < block.first_point + block.count; ++k) {
      const Vec4d g = normals[k].lambda, u = relative_velocity<false>(block, block.s, points[k], a, b).n;
      work += g * u, absolute += g * abs(u), impulse += g;
    }
    // Sums of manifolds: which of them share a block depends on the number of ranks.
    for (std::size_t l = 0; l < lanes; ++l)
      if (block.manifold[l] >= 0 && counted_[block.manifold[l]] != 0 && impulse[l] > 0 &&
          is_selected(static_cast<std::size_t>(block.manifold[l])))
        sums[0] += work[l], sums[1] += absolute[l], sums[2] += impulse[l];
  }
  return sums;
}

void ContactBatch::unload(double share) {
  for (std::size_t i = 0; i < contacts_->manifolds.size(); ++i) {
    if (!is_selected(i)) continue;
    const Manifold& m = contacts_->manifolds[i];
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p)
      kept_impulses_[p] = {share * kept_impulses_[p].n, share * kept_impulses_[p].s, share * kept_impulses_[p].t};
  }
}

void ContactBatch::add_impulses(std::span<Wrench> wrenches) const {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = blocks[i];
    ask_for<Wrench>(blocks, i, wrenches);
    const Vec3x4 t = cross(block.n, block.s);
    const Vec4d zero = broadcast(0);
    Vec3x4 force{zero, zero, zero}, torque_a = force, torque_b = force;
    for (std::uint32_t k = 0; k < block.count; ++k) {
      const Point& p = points[block.first_point + k];
      const Vec4d lambda = normals[block.first_point + k].lambda;
      Vec3x4 f = block.n * lambda;
      if (block.first_tangent >= 0) {
        const TangentImpulse& sideways = tangent_impulses[block.first_tangent + k];
        f = impulse_vector<true>(block, t, lambda, sideways.lambda_s, sideways.lambda_t);
      }
      force = force + f, torque_a = torque_a + cross(p.arm_a, f), torque_b = torque_b + cross(p.arm_b, f);
    }
    add_wrenches(block, force, torque_a, torque_b, wrenches);
  }
}

}  // namespace unibody
