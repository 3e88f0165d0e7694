#include "constraints/rolling_batch.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/friction.hpp"
#include "constraints/recall.hpp"
#include "world/surface_velocity.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

Vec3 spin_of(const SolverBody& b) { return {b.w[0], b.w[1], b.w[2]}; }

// The sum over a manifold's points, in their order.
double normal_impulse(const ContactBatch& batch, std::size_t block_number, std::size_t lane) {
  const ContactBatch::Block& block = batch.blocks[block_number];
  double sum = 0;
  const std::uint32_t count = batch.manifold(block, lane).count;
  for (std::uint32_t p = 0; p < count; ++p) sum += batch.normals[block.first_point + p].lambda[lane];
  return std::max(0.0, sum);
}

}  // namespace

bool RollingBatch::may_act(const BuildContext& context) {
  const MaterialPairs* pairs = context.pairs;
  return pairs && acts_in_solve(context.settings.friction) && (pairs->any(PairValue::rolling) || pairs->any(PairValue::spinning));
}

double RollingBatch::resistance(const BuildContext& context, PairValue value, const Manifold& m) {
  const auto material = [&](Slot s) { return context.world.properties[static_cast<std::size_t>(s)].material; };
  return context.pairs->of(value, material(m.slot_a), material(m.slot_b));
}

void RollingBatch::build(const BuildContext& context) {
  struct Resistance {
    std::uint32_t manifold;
    double rolling, spinning;  // m
  };
  contacts_ = context.contact_batch, step_ = context.state.step, kept_ = Kept::nothing;
  rows_.clear(), group_end_.clear();
  std::vector<Resistance> list;
  for_each_resisting(context, [&](std::uint32_t manifold, const Manifold&, double rolling, double spinning) {
    list.push_back({manifold, rolling, spinning});
  });
  group_end_.assign(contacts_->colours(), 0);
  if (list.empty()) return;
  rows_.reserve(list.size());
  const World& world = context.world;
  const auto& bodies = context.state.bodies;
  const auto& counts = context.state.counts;
  const auto add = [&](const Resistance& resistance, std::size_t block, std::size_t lane) {
    const Manifold& m = context.contacts->manifolds[resistance.manifold];
    Row row{};
    row.block = static_cast<std::uint32_t>(block), row.lane = static_cast<std::uint32_t>(lane);
    row.manifold = resistance.manifold;
    row.counted = contacts_->is_counted(resistance.manifold);
    row.id_a = m.id_a, row.id_b = m.id_b;
    const auto& all = context.contacts->manifolds;
    row.first =
        resistance.manifold == 0 || all[resistance.manifold - 1].id_a != m.id_a || all[resistance.manifold - 1].id_b != m.id_b;
    row.remembered = is_remembered(world, *context.contacts, m);
    row.a = m.slot_a, row.b = m.slot_b, row.rolling = resistance.rolling, row.spinning = resistance.spinning;
    row.aim = own_motion(world, m.slot_b).w - own_motion(world, m.slot_a).w;
    row.axes = {m.normal, first_tangent_of(m.normal), m.normal.cross(first_tangent_of(m.normal))};
    const auto a = static_cast<std::size_t>(m.slot_a), b = static_cast<std::size_t>(m.slot_b);
    row.turn_a = inverse_inertia_of(bodies, context.state.inertia, context.state.isotropic, a);
    row.turn_b = inverse_inertia_of(bodies, context.state.inertia, context.state.isotropic, b);
    for (const Slot s : {m.slot_a, m.slot_b})
      if (bodies[static_cast<std::size_t>(s)].inverse_mass > 0)
        row.lever = std::max(row.lever, arm_of(world, m, context.contacts->points[m.first], s).norm());
    const auto share = [&](std::size_t s) { return counts.empty() ? 1 : std::max(1.0, context.settings.scaling * counts[s]); };
    row.own_scale = scale_of(row, 1, 1), row.scale = scale_of(row, share(a), share(b));
    rows_.push_back(row);
  };
  std::size_t block = 0;
  for (std::size_t g = 0; g < contacts_->colours(); ++g) {
    for (; block < contacts_->group_end(g); ++block)
      for (std::size_t l = 0; l < lanes; ++l) {
        const std::int32_t manifold = contacts_->blocks[block].manifold[l];
        if (manifold < 0) continue;
        const auto found = std::lower_bound(list.begin(), list.end(), static_cast<std::uint32_t>(manifold),
                                            [](const Resistance& c, std::uint32_t m) { return c.manifold < m; });
        if (found != list.end() && found->manifold == static_cast<std::uint32_t>(manifold)) add(*found, block, l);
      }
    group_end_[g] = rows_.size();
  }
}

std::array<double, 2> RollingBatch::scale_of(const Row& row, double share_a, double share_b) {
  const Mat3 W = share_a * row.turn_a + share_b * row.turn_b;
  const auto entry = [&](std::size_t i, std::size_t j) { return std::abs(row.axes[i].dot(W * row.axes[j])); };
  const double coupling = row.spinning > 0 && row.rolling > 0 ? 1 : 0, across = entry(1, 2);
  return {entry(0, 0) + coupling * (entry(0, 1) + entry(0, 2)),
          std::max(entry(1, 1) + across + coupling * entry(0, 1), entry(2, 2) + across + coupling * entry(0, 2))};
}

RollingBatch::Torque RollingBatch::rates(const Row& row, std::span<const SolverBody> bodies) {
  const Vec3 w = spin_of(bodies[static_cast<std::size_t>(row.a)]) - spin_of(bodies[static_cast<std::size_t>(row.b)]) - row.aim;
  return {row.axes[0].dot(w), row.axes[1].dot(w), row.axes[2].dot(w)};
}

RollingBatch::Torque RollingBatch::project_step(const Row& row, const std::array<double, 2>& scale, const Torque& from,
                                                const Torque& rates) const {
  const double N = normal_impulse(*contacts_, row.block, row.lane);
  Torque next{};
  if (row.spinning > 0 && scale[0] > 0) {
    const double most = row.spinning * N;
    next[0] = std::clamp(from[0] - rates[0] / scale[0], -most, most);
  }
  if (row.rolling > 0 && scale[1] > 0) {
    const double s = from[1] - rates[1] / scale[1], t = from[2] - rates[2] / scale[1], most = row.rolling * N;
    const double length2 = s * s + t * t, shrink = length2 > most * most ? most / std::sqrt(length2) : 1;
    next[1] = shrink * s, next[2] = shrink * t;
  }
  return next;
}

Vec3 RollingBatch::torque_of(const Row& row, const Torque& lambda) {
  return lambda[0] * row.axes[0] + lambda[1] * row.axes[1] + lambda[2] * row.axes[2];
}

void RollingBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const Update<double> update = update_of(extrapolation);
  for (Row& row : rows_) {
    if (!contacts_->is_selected(row.manifold)) continue;
    const Torque r = rates(row, state.bodies), next = project_step(row, row.scale, row.y, r);
    Torque moved;
    SweepTerms<double> terms;
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = next[k] - row.y[k], taken = row.scale[k == 0 ? 0 : 1] * step;
      moved[k] =
          update.advance(row.lambda[k], row.y[k], next[k], step, r[k], taken * step, step_ * row.lever * std::abs(taken), terms);
    }
    add_terms(sums, terms, row.counted);
    const Vec3 torque = torque_of(row, moved);
    const Vec4d four{torque.x(), torque.y(), torque.z(), 0};
    state.wrenches[static_cast<std::size_t>(row.a)].torque += four;
    state.wrenches[static_cast<std::size_t>(row.b)].torque -= four;
  }
}

double RollingBatch::relax(std::size_t colour, bool, SolveState& state) {
  if (rows_.empty()) return 0;
  double change = 0;
  for (std::size_t i = colour == 0 ? 0 : group_end_[colour - 1]; i < group_end_[colour]; ++i) {
    Row& row = rows_[i];
    if (!contacts_->is_selected(row.manifold)) continue;
    const Torque next = project_step(row, row.scale, row.lambda, rates(row, state.bodies));
    Torque moved;
    for (std::size_t k = 0; k < 3; ++k) {
      moved[k] = next[k] - row.lambda[k], row.lambda[k] = next[k];
      change = std::max(change, step_ * row.lever * row.scale[k == 0 ? 0 : 1] * std::abs(moved[k]));
    }
    const Vec3 torque = torque_of(row, moved), of_a = row.turn_a * torque, of_b = row.turn_b * torque;
    SolverBody &a = state.bodies[static_cast<std::size_t>(row.a)], &b = state.bodies[static_cast<std::size_t>(row.b)];
    for (int k = 0; k < 3; ++k) a.w[k] += of_a[k], b.w[k] -= of_b[k];
  }
  return change;
}

void RollingBatch::keep_impulses(bool together) {
  kept_ = together ? Kept::together : Kept::apart;
  for (Row& row : rows_) {
    if (!contacts_->is_selected(row.manifold)) continue;
    row.kept = row.lambda;
    if (!together) row.lambda = Torque{};
    row.y = row.lambda;
  }
}

void RollingBatch::start_from(const History& history, const WarmStart& warm) {
  if (!warm.has_contacts()) return;
  for (Row& row : rows_) {
    const std::array key{row.id_a, row.id_b};
    const auto at = std::ranges::lower_bound(history, key, {}, &PairRecord<3>::key);
    if (!row.first || at == history.end() || at->key != key) continue;
    const Vec3 torque = contacts_->start_share(warm, row.manifold) * step_ * Vec3(at->value.data());
    for (std::size_t k = 0; k < 3; ++k) {
      const bool acts = k == 0 ? row.spinning > 0 && row.scale[0] > 0 : row.rolling > 0 && row.scale[1] > 0;
      row.lambda[k] = row.y[k] = acts ? row.axes[k].dot(torque) : 0;
    }
  }
}

void RollingBatch::add_impulses(SolveState& state, const WarmStart& warm, double) const {
  if (!warm.has_contacts()) return;
  for (const Row& row : rows_) {
    const Vec3 torque = torque_of(row, row.lambda);
    const Vec4d four{torque.x(), torque.y(), torque.z(), 0};
    state.wrenches[static_cast<std::size_t>(row.a)].torque += four;
    state.wrenches[static_cast<std::size_t>(row.b)].torque -= four;
  }
}

void RollingBatch::remember(History& history, double leak) const {
  history.clear();
  for (const Row& row : rows_) {
    if (!row.remembered) continue;
    Torque kept;
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = row.kept[k], y = row.lambda[k];
      kept[k] = kept_ == Kept::nothing ? y : x + contacts_->leak_of(leak, row.manifold) * (kept_ == Kept::apart ? y : y - x);
    }
    const Vec3 torque = torque_of(row, kept) / step_;
    history.push_back({{row.id_a, row.id_b}, {torque.x(), torque.y(), torque.z()}});
  }
  std::ranges::stable_sort(history, {}, &PairRecord<3>::key);
  std::size_t pairs = 0;  // of a pair with several manifolds the sum
  for (std::size_t i = 0; i < history.size(); ++i)
    if (pairs > 0 && history[pairs - 1].key == history[i].key)
      for (std::size_t k = 0; k < 3; ++k) history[pairs - 1].value[k] += history[i].value[k];
    else
      history[pairs++] = history[i];
  history.resize(pairs);
}

void RollingBatch::join_stages() {
  for (Row& row : rows_) {
    for (std::size_t k = 0; k < 3 && kept_ == Kept::apart; ++k) row.lambda[k] += row.kept[k];
    row.y = row.lambda, row.kept = Torque{};
  }
}

double RollingBatch::residual_of(const Row& row, std::span<const SolverBody> bodies) const {
  if (!contacts_->is_selected(row.manifold)) return 0;
  const Torque next = project_step(row, row.own_scale, row.lambda, rates(row, bodies));
  double worst = 0;
  for (std::size_t k = 0; k < 3; ++k)
    worst = std::max(worst, row.lever * row.own_scale[k == 0 ? 0 : 1] * std::abs(next[k] - row.lambda[k]));
  return worst;
}

double RollingBatch::residual(const SolveState& state) const {
  double worst = 0;
  for (const Row& row : rows_) worst = std::max(worst, residual_of(row, state.bodies));
  return step_ * worst;
}

void RollingBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  for (const Row& row : rows_) visit(step_ * residual_of(row, state.bodies), std::array{row.a, row.b});
}

}  // namespace unibody
