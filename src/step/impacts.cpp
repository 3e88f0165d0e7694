#include "step/impacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "collide/carrier.hpp"
#include "collide/collide.hpp"
#include "collide/turned_arm.hpp"
#include "constraints/friction.hpp"
#include "step/blow.hpp"
#include "step/contact_forces.hpp"
#include "step/first_touch.hpp"
#include "step/seeming_starts.hpp"
#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

constexpr int most_rounds = 400;

// What a contact's manifold needs for its impact.
struct Pair {
  std::uint32_t manifold;
  Slot a, b;
  double restitution;
  bool fast;            // any impact counts
  double time = never;  // s, of the next one
};

class Impacts {
 public:
  Impacts(RankState& state, System& system)
      : state_(state), world_(state.world), system_(system), contacts_(state.contacts), step_(state.step()) {}

  std::int64_t run() {
    list_pairs();
    if (!state_.any_over_ranks(!pairs_.empty())) return 0;
    leave_chains_to_the_solve();
    starts_.emplace(state_, system_), clock_.assign(world_.size() + 1, 0);
    index_bodies();
    for (Pair& pair : pairs_) pair.time = time_of(pair);
    std::int64_t count = 0;
    for (int round = 0; round < most_rounds; ++round) {
      if (!state_.any_over_ranks(std::ranges::any_of(pairs_, [](const Pair& p) { return p.time < never; }))) break;
      find_first();
      count += apply();
      tell_guests();
    }
    correct_contacts();
    return count;
  }

 private:
  bool is_free(Slot slot) const {
    const auto i = static_cast<std::size_t>(slot);
    return world_.is_static(slot) || (world_.properties[i].is_dynamic() && !state_.is_tied(world_.id[i]));
  }

  // As the solve's contacts see them: every one with a home body is here.
  void list_pairs() {
    const auto& e = state_.search.settings.restitution;
    for (std::uint32_t k = 0; k < contacts_.manifolds.size(); ++k) {
      const Manifold& m = contacts_.manifolds[k];
      if (e.empty() && !(m.time > 0)) continue;
      const BodyProperties &a = world_.properties[static_cast<std::size_t>(m.slot_a)],
                           &b = world_.properties[static_cast<std::size_t>(m.slot_b)];
      // What is not round and is swept turns too far in the step for the places of its contacts: the solve has it.
      if (m.time > 0 && !is_round(a.shape) && !is_round(b.shape)) continue;
      const double restitution = restitution_of(m);
      if (!(restitution > 0 || m.time > 0) || !is_free(m.slot_a) || !is_free(m.slot_b)) continue;
      pairs_.push_back({k, m.slot_a, m.slot_b, restitution, m.time > 0});
    }
  }

  // Where one impact leads to another and none bounces, all go on together, which the solve's rows say at once: what does not
  // bounce off a body that has other such bodies near it, or may be struck, is left to them.
  void leave_chains_to_the_solve() {
    std::vector<std::int32_t> in_chain(world_.size() + 1, 0);
    const auto dynamic = [&](Slot s) { return world_.properties[static_cast<std::size_t>(s)].is_dynamic(); };
    for (const Manifold& m : contacts_.manifolds) {
      if (m.time > 0 || restitution_of(m) > 0 || !dynamic(m.slot_a) || !dynamic(m.slot_b)) continue;
      in_chain[static_cast<std::size_t>(m.slot_a)] = in_chain[static_cast<std::size_t>(m.slot_b)] = 1;
    }
    state_.exchange.refresh(std::span(in_chain));
    std::erase_if(pairs_, [&](const Pair& pair) {
      const auto leads_on = [&](Slot s) { return in_chain[static_cast<std::size_t>(s)] > 0 || may_be_struck(s); };
      return pair.restitution == 0 && (leads_on(pair.a) || leads_on(pair.b));
    });
  }

  double restitution_of(const Manifold& m) const {
    const auto material = [&](Slot s) { return world_.properties[static_cast<std::size_t>(s)].material; };
    return state_.search.settings.restitution_of(material(m.slot_a), material(m.slot_b));
  }

  bool may_be_struck(Slot slot) const {
    const auto& struck = state_.search.settings.struck;
    const auto i = static_cast<std::size_t>(slot);
    return !struck.empty() && moves(slot) &&
           struck.speed_at(world_.period.wrapped(world_.position[i]), bounding_radius(world_.properties[i].shape)) > 0;
  }

  void index_bodies() {
    first_pair_.assign(world_.size() + 1, 0);
    for (const Pair& pair : pairs_)
      for (const Slot s : {pair.a, pair.b}) ++first_pair_[static_cast<std::size_t>(s)];
    std::size_t sum = 0;
    for (std::size_t& first : first_pair_) sum += first, first = sum - first;
    pairs_of_.resize(sum);
    std::vector<std::size_t> next(first_pair_);
    for (std::uint32_t k = 0; k < pairs_.size(); ++k)
      for (const Slot s : {pairs_[k].a, pairs_[k].b}) pairs_of_[next[static_cast<std::size_t>(s)]++] = k;
  }

  bool moves(Slot s) const { return system_.bodies[static_cast<std::size_t>(s)].inverse_mass > 0; }
  Vec3 acceleration(Slot s) const { return starts_->acceleration(s); }
  Vec3 velocity(Slot s) const { return starts_->velocity(s); }
  Vec3 place(Slot s, double t) const { return starts_->place(s, t); }
  // The place of the pair's second body, where the first one meets it.
  Vec3 place_of_b(const Pair& p, double t) const {
    return place(p.b, t) + world_.period.shift(contacts_.manifolds[p.manifold].image);
  }
  double radius(Slot s) const { return world_.properties[static_cast<std::size_t>(s)].shape.size.x(); }
  bool round(Slot s) const { return is_round(world_.properties[static_cast<std::size_t>(s)].shape); }
  bool both_round(const Pair& pair) const { return round(pair.a) && round(pair.b); }

  // A point of contact, with what it needs of its bodies.
  struct Point {
    Vec3 arm_a, arm_b;  // m, from the centres
    double gap;         // m, at the start of the step as it seems to be now
  };
  // From the centre of one of the manifold's bodies to its own side of a contact point, at a time. m
  Vec3 own_arm(const Manifold& m, const ContactPoint& p, Slot s, double t) const {
    const Vec3 outwards = s == m.slot_a ? Vec3(-m.normal) : m.normal;
    return turned_arm(world_, s, p.position - 0.5 * p.gap * outwards - place_of(world_, m, s), outwards, starts_->turn(s, t));
  }
  std::array<Point, PairManifold::kept> points_of(const Pair& pair) const {
    const Manifold& m = contacts_.manifolds[pair.manifold];
    const auto i = static_cast<std::size_t>(pair.a), j = static_cast<std::size_t>(pair.b);
    std::array<Point, PairManifold::kept> points;
    for (std::uint32_t k = 0; k < m.count; ++k) {
      const ContactPoint& p = contacts_.points[m.first + k];
      Point& point = points[k];
      point.arm_a = arm_of(world_, m, p, pair.a), point.arm_b = arm_of(world_, m, p, pair.b);
      point.gap = p.gap + m.normal.dot(state_.impacts.displaced[i] + state_.impacts.turned[i].cross(point.arm_a) -
                                       state_.impacts.displaced[j] - state_.impacts.turned[j].cross(point.arm_b));
    }
    return points;
  }
  // One of the manifold's points when the bodies touch there. Both have it in one place, so that angular momentum is kept.
  Point touching_point(const Pair& pair, std::uint32_t k, double t) const {
    const Manifold& m = contacts_.manifolds[pair.manifold];
    const ContactPoint& p = contacts_.points[m.first + k];
    const Vec3 at_a = place(pair.a, t), at_b = place_of_b(pair, t);
    const double share = share_of_first(world_, m, p);
    const Vec3 place = share * (at_a + own_arm(m, p, pair.a, t)) + (1 - share) * (at_b + own_arm(m, p, pair.b, t));
    return {place - at_a, place - at_b, 0};
  }
  // How a pair moves at a time.
  struct PairMotion {
    double time;          // s
    Vec3 spin_a, spin_b;  // rad/s
  };
  PairMotion motion_at(const Pair& pair, double t) const { return {t, starts_->spin(pair.a, t), starts_->spin(pair.b, t)}; }
  Vec3 velocity_at(const Pair& pair, const Point& point, const PairMotion& motion) const {
    return velocity(pair.a) + motion.spin_a.cross(point.arm_a) - velocity(pair.b) - motion.spin_b.cross(point.arm_b) +
           (motion.time - 0.5 * step_) * (acceleration(pair.a) - acceleration(pair.b));
  }
  bool counts(const Pair& pair, double closing) const {
    double g = state_.traits.gravity;  // or what else two bodies that lie on each other close by
    if (state_.traits.adheres) g = std::max(g, (acceleration(pair.a) - acceleration(pair.b)).norm());
    return closing > (pair.fast ? 1e-9 : std::max(1e-12, 2 * step_ * g));
  }

  // The time of the pair's next impact that counts (s), or `never` where the step has none.
  double time_of(const Pair& pair) const {
    const double from = std::max(clock_[static_cast<std::size_t>(pair.a)], clock_[static_cast<std::size_t>(pair.b)]);
    const Vec3 faster = acceleration(pair.a) - acceleration(pair.b);
    if (both_round(pair)) {
      const double time = first_touch_of_spheres(place(pair.a, 0) - place_of_b(pair, 0), velocity(pair.a) - velocity(pair.b),
                                                 faster, step_, radius(pair.a) + radius(pair.b), from, step_);
      if (time == never) return never;
      const Touch touch = touch_of(pair, time);
      return counts(pair, -touch.normal.dot(velocity_at(pair, touch.points[0], motion_at(pair, time)))) ? time : never;
    }
    const Manifold& m = contacts_.manifolds[pair.manifold];
    const auto points = points_of(pair);
    const PairMotion half_way = motion_at(pair, 0.5 * step_);
    double first = never;
    for (std::uint32_t k = 0; k < m.count; ++k) {
      const double speed = m.normal.dot(velocity_at(pair, points[k], half_way));
      const double time = first_touch_of_plane(points[k].gap, speed, m.normal.dot(faster), step_, from, step_);
      if (time < first && counts(pair, -m.normal.dot(velocity_at(pair, touching_point(pair, k, time), motion_at(pair, time)))))
        first = time;
    }
    return first;
  }

  // Where two bodies touch at a time.
  struct Touch {
    Vec3 normal;  // from b to a
    std::array<Point, PairManifold::kept> points;
    std::uint32_t count = 0;
  };
  Touch touch_of(const Pair& pair, double t) const {
    Touch touch;
    const Manifold& m = contacts_.manifolds[pair.manifold];
    touch.normal = m.normal;
    const Vec3 at_a = place(pair.a, t), at_b = place_of_b(pair, t);
    if (both_round(pair) && (at_a - at_b).norm() > 0) touch.normal = (at_a - at_b).normalized();
    if (round(pair.a) || round(pair.b)) {
      const Vec3 point = round(pair.a) ? Vec3(at_a - radius(pair.a) * touch.normal) : Vec3(at_b + radius(pair.b) * touch.normal);
      touch.points[touch.count++] = {point - at_a, point - at_b, 0};
      return touch;
    }
    const PairMotion half_way = motion_at(pair, 0.5 * step_);
    const auto points = points_of(pair);
    const double size = std::min(smallest_size(world_.properties[static_cast<std::size_t>(pair.a)].shape),
                                 smallest_size(world_.properties[static_cast<std::size_t>(pair.b)].shape));
    const double faster = m.normal.dot(acceleration(pair.a) - acceleration(pair.b));
    for (std::uint32_t k = 0; k < m.count; ++k) {
      const double speed = m.normal.dot(velocity_at(pair, points[k], half_way));
      if (points[k].gap + t * speed + 0.5 * t * (t - step_) * faster > 1e-6 * size) continue;
      touch.points[touch.count++] = touching_point(pair, k, t);
    }
    return touch;
  }

  // Finds the first impact of each body, by its time, then by the pair's ids. An impact that is the first of both of its bodies
  // comes next.
  void find_first() {
    const std::size_t n = world_.size() + 1;
    first_time_.assign(n, never), first_other_.assign(n, -1);
    const auto id = [&](Slot s) { return static_cast<double>(world_.id[static_cast<std::size_t>(s)]); };
    const auto key = [&](std::size_t body, double other) {
      const double own = id(static_cast<Slot>(body));
      return std::pair(std::min(own, other), std::max(own, other));
    };
    for (const Pair& pair : pairs_) {
      if (pair.time == never) continue;
      for (const auto& [own, other] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)}) {
        const auto i = static_cast<std::size_t>(own);
        const double with = id(other);
        if (pair.time < first_time_[i] || (pair.time == first_time_[i] && key(i, with) < key(i, first_other_[i])))
          first_time_[i] = pair.time, first_other_[i] = with;
      }
    }
    state_.exchange.refresh(std::span(first_time_)), state_.exchange.refresh(std::span(first_other_));
  }

  bool comes_next(const Pair& pair) const {
    const auto agrees = [&](Slot own, Slot other) {
      const auto i = static_cast<std::size_t>(own);
      return !moves(own) ||
             (first_time_[i] == pair.time && first_other_[i] == static_cast<double>(world_.id[static_cast<std::size_t>(other)]));
    };
    return pair.time < never && agrees(pair.a, pair.b) && agrees(pair.b, pair.a);
  }

  // Each body is in one impact of a round at most. Returns how many this rank counts.
  std::int64_t apply() {
    std::int64_t count = 0;
    changed_.clear();
    std::vector<std::uint8_t> hit(world_.size() + 1, 0);
    for (Pair& pair : pairs_) {
      if (!comes_next(pair)) continue;
      if ((moves(pair.a) && hit[static_cast<std::size_t>(pair.a)]) || (moves(pair.b) && hit[static_cast<std::size_t>(pair.b)]))
        continue;  // another part of the same two
      strike(pair);
      for (const Slot s : {pair.a, pair.b})
        if (moves(s)) hit[static_cast<std::size_t>(s)] = 1, changed_.push_back(s);
      count += counts_here(world_, contacts_.manifolds[pair.manifold]);
    }
    return count;
  }

  void strike(const Pair& pair) {
    const Touch touch = touch_of(pair, pair.time);
    const Manifold& m = contacts_.manifolds[pair.manifold];
    const FrictionFrame frame = contacts_.frame_at(m, touch.normal);
    const Mat3 axes = frame.axes_about(touch.normal);
    const auto i = static_cast<std::size_t>(pair.a), j = static_cast<std::size_t>(pair.b);
    const Mat3 turn_a = starts_->inverse_inertia(pair.a, pair.time), turn_b = starts_->inverse_inertia(pair.b, pair.time);
    const double linear = system_.bodies[i].inverse_mass + system_.bodies[j].inverse_mass;
    const PairMotion now = motion_at(pair, pair.time);
    Blow blow;
    blow.count = touch.count;
    for (std::uint32_t k = 0; k < touch.count; ++k) {
      const Point& point = touch.points[k];
      const Vec3 own = surface_velocity_between(world_, pair.a, point.arm_a, pair.b, point.arm_b, touch.normal);
      blow.before[k] = axes.transpose() * (velocity_at(pair, point, now) - own), blow.impulse[k].setZero();
      for (std::uint32_t l = 0; l < touch.count; ++l)
        for (int x = 0; x < 3; ++x) {
          const Vec3 f = axes.col(x);
          blow.K[k][l].col(x) =
              axes.transpose() * (linear * f + (turn_a * touch.points[l].arm_a.cross(f)).cross(touch.points[k].arm_a) +
                                  (turn_b * touch.points[l].arm_b.cross(f)).cross(touch.points[k].arm_b));
        }
    }
    blow.solve(pair.restitution, {acts_in_solve(state_.scene.solver.friction) ? m.friction : 0, frame.across});
    Vec3 force = Vec3::Zero(), torque_a = force, torque_b = force;
    for (std::uint32_t k = 0; k < touch.count; ++k) {
      const Vec3 f = axes * blow.impulse[k];
      force += f, torque_a += touch.points[k].arm_a.cross(f), torque_b += touch.points[k].arm_b.cross(f);
      record(pair, touch, k, f);
    }
    starts_->push(pair.a, force, torque_a, pair.time), clock_[i] = moves(pair.a) ? pair.time : clock_[i];
    starts_->push(pair.b, -force, -torque_b, pair.time), clock_[j] = moves(pair.b) ? pair.time : clock_[j];
  }

  // For those who measure forces: what moves has its arm from where it is at the start of the step.
  void record(const Pair& pair, const Touch& touch, std::uint32_t k, const Vec3& impulse) {
    const Manifold& m = contacts_.manifolds[pair.manifold];
    if (!counts_here(world_, m)) return;
    const Point& arms = touch.points[k];
    const Vec3 point = moves(pair.a) ? place_of(world_, m, pair.a) + arms.arm_a : place_of(world_, m, pair.b) + arms.arm_b;
    add_impulse(world_, m, point, touch.normal, impulse, state_.impacts.impulses);
  }

  // Guests take what their homes have met with bodies that are not here. Every rank comes to these exchanges, also one whose only
  // neighbours share a cloth with it and no contact.
  void tell_guests() {
    state_.exchange.refresh(std::span(clock_));
    starts_->tell_guests(changed_);
    for (const Slot s : changed_)
      for (std::size_t k = first_pair_[static_cast<std::size_t>(s)]; k < first_pair_[static_cast<std::size_t>(s) + 1]; ++k)
        pairs_[pairs_of_[k]].time = time_of(pairs_[pairs_of_[k]]);
  }

  // The solve sees each gap as it is from where the bodies seem to have started the step. The row of two bodies that pass by each
  // other would stop them, so its gap is opened. Two bodies that overlap, or that have an impact left, keep their row.
  void correct_contacts() {
    if (state_.impacts.gaps_found.empty())
      for (const ContactPoint& p : contacts_.points) state_.impacts.gaps_found.push_back(p.gap);
    for (Manifold& m : contacts_.manifolds) {
      const auto i = static_cast<std::size_t>(m.slot_a), j = static_cast<std::size_t>(m.slot_b);
      if (state_.impacts.displaced[i].isZero(0) && state_.impacts.displaced[j].isZero(0)) continue;
      m.displaced = m.normal.dot(state_.impacts.displaced[i] - state_.impacts.displaced[j]);
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
        ContactPoint& point = contacts_.points[p];
        const Vec3 of_a = state_.impacts.turned[i].cross(arm_of(world_, m, point, m.slot_a));
        const Vec3 of_b = state_.impacts.turned[j].cross(arm_of(world_, m, point, m.slot_b));
        point.gap += m.displaced + m.normal.dot(of_a - of_b);
      }
    }
    state_.impacts.settled.assign(contacts_.manifolds.size(), 0);
    for (const Pair& pair : pairs_) {
      const Manifold& m = contacts_.manifolds[pair.manifold];
      state_.impacts.settled[pair.manifold] = 1;
      const double closing = -m.normal.dot(velocity(pair.a) - velocity(pair.b));
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
        const bool slow = contacts_.bounce.empty() || !(contacts_.bounce[p] > 0);
        if (!contacts_.bounce.empty()) contacts_.bounce[p] = 0;
        const bool overlaps = both_round(pair) && state_.impacts.gaps_found[p] < -1e-6 * (radius(pair.a) + radius(pair.b));
        const bool is_settled = pair.time == never && !overlaps;
        if (is_settled && both_round(pair) && (pair.fast || !slow || closing > 2 * step_ * state_.traits.gravity))
          contacts_.points[p].gap = std::max(contacts_.points[p].gap, step_ * closing);
      }
    }
  }

  RankState& state_;
  World& world_;
  System& system_;
  Contacts& contacts_;
  double step_;
  std::vector<Pair> pairs_;
  std::vector<std::size_t> first_pair_;  // of each body, into pairs_of_
  std::vector<std::uint32_t> pairs_of_;
  std::optional<SeemingStarts> starts_;
  std::vector<double> clock_;                     // s, of each body's last impact
  std::vector<double> first_time_, first_other_;  // s; id
  std::vector<Slot> changed_;                     // in the last round
};

}  // namespace

std::int64_t resolve_impacts(RankState& state, System& system) { return Impacts(state, system).run(); }

}  // namespace unibody
