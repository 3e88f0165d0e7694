// ContactBatch: where the multipliers start, what is kept of them between the stages, and what is remembered at the end.

#include <algorithm>
#include <array>

#include "collide/surfaces.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/contact_for_each.hpp"
#include "constraints/level_pressure.hpp"
#include "constraints/recall.hpp"
#include "world/world.hpp"

namespace unibody {

void ContactBatch::set_impulses(std::span<const Impulse> impulses) {
  for_each_row([&](std::size_t, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    const Impulse impulse = impulses.empty() ? Impulse{0, 0, 0} : impulses[contact];
    normals[p].lambda[l] = impulse.n;
    if (t != no_tangent) tangent_impulses[t].lambda_s[l] = impulse.s, tangent_impulses[t].lambda_t[l] = impulse.t;
  });
  start_momenta();
}

void ContactBatch::start_momenta() {
  for (std::size_t p = 0; p < normal_momenta.size(); ++p) normal_momenta[p].y = normals[p].lambda;
  for (std::size_t t = 0; t < tangent_momenta.size(); ++t)
    tangent_momenta[t].y_s = tangent_impulses[t].lambda_s, tangent_momenta[t].y_t = tangent_impulses[t].lambda_t;
}

// Where tetrahedra start cold, what touches them must as well: an impact on stiff material, far from converged, goes through few
// nodes; a share of its force with nothing against it would throw them further than an edge is long.
void ContactBatch::forget_solids(const Surfaces& surfaces, std::span<Impulse> start) const {
  const auto is_solid = [&](Slot s) { return surfaces.is_node(s) && surfaces.is_closed(surfaces.surface_of(s)); };
  for (const Manifold& m : contacts_->manifolds)
    if (is_solid(m.slot_a) || is_solid(m.slot_b)) std::fill_n(start.begin() + m.first, m.count, Impulse{0, 0, 0});
}

void ContactBatch::start_from(const Multipliers& history, const WarmStart& warm) {
  if (!warm.has_contacts()) return set_impulses({});
  std::pmr::vector<Impulse> start(contacts_->points.size(), places_.get_allocator());
  const double all = constrained_.empty() ? warm.contacts_share : 1;
  recall(history, *world_, *contacts_, step_, start, all);
  level_pressure(history, *world_, *contacts_, all * step_, start);
  for (std::size_t i = 0; i < constrained_.size(); ++i)
    for (std::uint32_t p = 0; p < contacts_->manifolds[i].count; ++p) {
      Impulse& impulse = start[contacts_->manifolds[i].first + p];
      const double share = start_share(warm, i);
      impulse = {share * impulse.n, share * impulse.s, share * impulse.t};
    }
  if (warm.cold_solids != nullptr) forget_solids(*warm.cold_solids, start);
  set_impulses(start);
}

ContactBatch::Impulse ContactBatch::row(std::size_t l, std::size_t p, std::size_t t) const {
  if (t == no_tangent) return {normals[p].lambda[l], 0, 0};
  return {normals[p].lambda[l], tangent_impulses[t].lambda_s[l], tangent_impulses[t].lambda_t[l]};
}

void ContactBatch::get_impulses(std::span<Impulse> impulses) const {
  for_each_row(
      [&](std::size_t, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) { impulses[contact] = row(l, p, t); });
}

void ContactBatch::keep_impulses(bool together) {
  if (kept_ == Kept::nothing) kept_impulses_.assign(contacts_->points.size(), {0, 0, 0});
  kept_ = together ? Kept::together : Kept::apart;
  for_each_row([&](std::size_t m, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    if (!is_selected(m)) return;
    kept_impulses_[contact] = row(l, p, t);
    if (together) return;
    normals[p].lambda[l] = 0;
    if (t != no_tangent) tangent_impulses[t].lambda_s[l] = tangent_impulses[t].lambda_t[l] = 0;
  });
  start_momenta();
}

void ContactBatch::join_stages() {
  const std::vector<Impulse> total = total_impulses();
  kept_ = Kept::together;
  set_impulses(total);
}

std::vector<ContactBatch::Impulse> ContactBatch::total_impulses() const {
  std::vector<Impulse> total(contacts_->points.size());
  get_impulses(total);
  for (std::size_t k = 0; k < total.size() && kept_ == Kept::apart; ++k) {
    const Impulse& before = kept_impulses_[k];
    total[k].n += before.n, total[k].s += before.s, total[k].t += before.t;
  }
  return total;
}

// Particles touch at a point each, their centre, so that there is no torque to be told.
void ContactBatch::add_applied(const SolveState&, std::span<Vec4d> impulses) const {
  for_each_row([&](std::size_t i, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    const Manifold& m = contacts_->manifolds[i];
    if (!is_particle(*world_, m.slot_a) && !is_particle(*world_, m.slot_b)) return;
    const bool moves = !normal_momenta.empty();
    const Impulse before = kept_ == Kept::apart ? kept_impulses_[contact] : Impulse{0, 0, 0};
    Impulse now = moves ? Impulse{normal_momenta[p].y[l], 0, 0} : row(l, p, t);
    if (moves && t != no_tangent) now.s = tangent_momenta[t].y_s[l], now.t = tangent_momenta[t].y_t[l];
    const Vec3 s = contacts_->frame_of(m).s;
    const Vec3 all = (before.n + now.n) * m.normal + (before.s + now.s) * s + (before.t + now.t) * m.normal.cross(s);
    impulses[static_cast<std::size_t>(m.slot_a)] += Vec4d{all.x(), all.y(), all.z(), 0};
    impulses[static_cast<std::size_t>(m.slot_b)] -= Vec4d{all.x(), all.y(), all.z(), 0};
  });
}

void ContactBatch::normal_impulses(std::span<double> normal) const {
  for_each_row([&](std::size_t, std::size_t l, std::size_t p, std::size_t, std::size_t contact) {
    normal[contact] = normals[p].lambda[l] + (kept_ == Kept::apart ? kept_impulses_[contact].n : 0);
  });
}

std::int64_t ContactBatch::sliding() const {
  std::int64_t count = 0;
  for_each_row([&](std::size_t m, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    if (t == no_tangent || !counted_[m]) return;
    const Impulse before = kept_ == Kept::apart ? kept_impulses_[contact] : Impulse{0, 0, 0}, now = row(l, p, t);
    const double limit = 0.999 * contacts_->manifolds[m].friction * (before.n + now.n), s = before.s + now.s,
                 f = (before.t + now.t) / contacts_->frame_of(contacts_->manifolds[m]).across;
    count += limit > 0 && s * s + f * f >= limit * limit;
  });
  return count;
}

namespace {

// Keeps the share of what each normal impulse differs from their mean by.
void take_towards_mean(std::span<ContactBatch::Impulse> impulses, double share) {
  double mean = 0;
  for (const ContactBatch::Impulse& impulse : impulses) mean += impulse.n / static_cast<double>(impulses.size());
  for (ContactBatch::Impulse& impulse : impulses) impulse.n = mean + share * (impulse.n - mean);
}

}  // namespace

// Of a pair with several manifolds the mean of those that have a creep. sum, count: of the pair so far.
void ContactBatch::remember_creep(Multipliers& history, std::size_t manifold, Creep& sum, int& count) const {
  const Manifold& m = contacts_->manifolds[manifold];
  const bool same =
      manifold > 0 && contacts_->manifolds[manifold - 1].id_a == m.id_a && contacts_->manifolds[manifold - 1].id_b == m.id_b;
  if (!same) sum = {}, count = 0;
  if (!creeps_noted_ || creeps_[manifold].is_zero() || history.manifolds.empty()) return;
  const RememberedManifold& last = history.manifolds.back();
  if (last.id_a != m.id_a || last.id_b != m.id_b) return;
  sum.slip += creeps_[manifold].slip, sum.turn += creeps_[manifold].turn, ++count;
  history.set_last_creep({sum.slip / count, sum.turn / count});
}

void ContactBatch::remember(Multipliers& history, double leak) const {
  start_remembering(history, *contacts_);
  Creep creep;
  int manifolds = 0;
  std::array<Impulse, most_points> of_manifold;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Manifold& m = contacts_->manifolds[i];
    const Rows& rows = rows_[places_[i] / lanes];
    for (std::uint32_t p = 0; p < m.count; ++p) {
      const std::size_t tangent = rows.first_tangent < 0 ? no_tangent : static_cast<std::size_t>(rows.first_tangent) + p;
      Impulse& impulse = of_manifold[p] = row(places_[i] % lanes, rows.first_point + p, tangent);
      if (kept_ == Kept::nothing) continue;
      const Impulse old = kept_impulses_[m.first + p], now = impulse;
      const double share = leak_of(leak, i) * (leak_shares_.empty() ? 1 : leak_shares_[m.first + p]);
      const auto mix = [&](double x, double y) { return x + share * (kept_ == Kept::apart ? y : y - x); };
      impulse = {mix(old.n, now.n), mix(old.s, now.s), mix(old.t, now.t)};
    }
    const std::span<Impulse> all = std::span(of_manifold).first(m.count);
    if (!uneven_shares_.empty() && uneven_shares_[i] < 1) take_towards_mean(all, uneven_shares_[i]);
    remember_manifold(history, *world_, *contacts_, m, all, step_);
    remember_creep(history, i, creep, manifolds);
  }
  if (!history.creeps.empty()) history.creeps.resize(history.manifolds.size());
}

}  // namespace unibody
