#include "step/struck.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collide/narrowphase.hpp"
#include "core/checked.hpp"
#include "core/largest.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr double most_gain = 4;  // times the fastest body's speed: more is no motion, but a solve that has not converged
constexpr double share = 0.1;    // of half the smallest size: what a body may go further than its contacts were sought for

double speed_of_surface(const SolverBody& body, const Proxy& proxy, bool turns) {
  const double linear = Eigen::Map<const Vec3>(body.v).norm();
  return turns ? linear + proxy.radius * Eigen::Map<const Vec3>(body.w).norm() : linear;
}

// How far a body's centre goes in the step (m).
Vec3 way_of(const RankState& state, const System& system, std::size_t i) {
  const Vec3 way = state.step() * Eigen::Map<const Vec3>(system.bodies[i].v);
  return state.impacts.displaced.empty() ? way : Vec3(way + state.impacts.displaced[i]);
}

// The home bodies that get further than their contacts were sought for.
std::vector<Struck> faster_than_sought(const RankState& state, const System& system) {
  std::vector<Struck> found;
  const double step = state.step();
  for (std::size_t i = 0; i < state.world.homes; ++i) {
    const BodyProperties& body = state.world.properties[i];
    if (!body.is_dynamic() || body.shape.kind == ShapeKind::particle) continue;
    const bool turns = !is_round(body.shape);
    if (!turns && Eigen::Map<const Vec3>(system.bodies[i].v).norm() <= state.world.velocity[i].norm()) continue;
    const Proxy proxy = make_proxy(state.world, i, state.search.settings);
    const double speed = speed_of_surface(system.bodies[i], proxy, turns);
    const double sought = step * proxy.speed + proxy.turn_reach() + proxy.fall + state.search.settings.margin / 2;
    if (step * speed > sought + share * proxy.half_size)
      found.push_back({state.world.period.wrapped(proxy.position), way_of(state, system, i), proxy.radius + step * speed, speed,
                       proxy.half_size, proxy.id, proxy.group});
  }
  return found;
}

// m/s, of the fastest point of any body at the start of the step.
double fastest_before(const RankState& state) {
  double fastest = 0;
  for (std::size_t i = 0; i < state.world.size(); ++i) {
    if (state.world.properties[i].motion == Motion::fixed) continue;
    const double spin = bounding_radius(state.world.properties[i].shape) * state.world.angular_velocity_of(i).norm();
    fastest = std::max(fastest, state.world.velocity[i].norm() + spin + state.step() * state.traits.gravity);
  }
  return largest_of_ranks(state.comm(), fastest);
}

std::vector<Struck> of_all_ranks(const std::vector<Struck>& here, MPI_Comm comm) {
  std::vector<Struck> all = all_of_ranks<Struck>(comm, here);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].number = static_cast<std::int32_t>(i);
  return all;
}

// In a periodic scene with their images in the cells around theirs.
std::vector<Struck> with_images(const std::vector<Struck>& all, const Period& period) {
  std::vector<Struck> images = all;
  for (int k = 0; k < 3; ++k) {
    const std::size_t count = images.size();
    for (std::size_t i = 0; i < count && period.along(k); ++i)
      for (const double way : {-period.length[k], period.length[k]}) {
        images.push_back(images[i]);
        images.back().centre[k] += way;
      }
  }
  return images;
}

// The least distance (m) between centres that go straight ways within the same time.
double least_distance(const Vec3& apart, const Vec3& way) {
  const double length = way.squaredNorm();
  const double t = length > 0 ? std::clamp(-apart.dot(way) / length, 0.0, 1.0) : 0;
  return (apart + t * way).norm();
}

// Looks for home bodies and for what does not move in the ways of others that they have no contact with.
class RunOver {
 public:
  RunOver(const RankState& state, const System& system, const std::vector<Struck>& all)
      : state_(state), system_(system), run_over_(all.size(), 0) {
    ways_.add(with_images(all, state.world.period));
  }

  // Finds, for each body of the list, whether it runs over something, on any rank. Collective.
  std::vector<std::uint8_t> find() {
    for (std::size_t i = 0; i < state_.world.size(); ++i)
      if (i < state_.world.homes || state_.world.is_static(static_cast<Slot>(i))) look(i);
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, run_over_.data(), mpi_count(run_over_.size()), MPI_UINT8_T, MPI_MAX, state_.comm()));
    return run_over_;
  }

 private:
  void look(std::size_t i) {
    const World& world = state_.world;
    const Shape& shape = world.properties[i].shape;
    if (shape.kind == ShapeKind::particle) return;
    const bool fixed = world.is_static(static_cast<Slot>(i));
    const Vec3 way = fixed ? Vec3(state_.step() * world.velocity[i]) : way_of(state_, system_, i);
    Proxy proxy = make_proxy(world, i, state_.search.settings);
    if (shape.kind != ShapeKind::plane) proxy.position = world.period.wrapped(proxy.position);
    const double radius = shape.kind == ShapeKind::plane ? HUGE_VAL : proxy.radius + way.norm();
    ways_.for_each_near(proxy.position, radius, [&](const Struck& s) {
      if (s.id == world.id[i] || (s.group >= 0 && s.group == proxy.group)) return;
      if (!state_.search.settings.may_touch(s.id, world.id[i])) return;
      const double inner = s.half_size + proxy.half_size - share * std::min(s.half_size, proxy.half_size);
      const bool meet = fixed ? is_inside(s, proxy, way)
                              : least_distance(s.centre - proxy.position, s.way - way) < inner && !is_known(s.id, world.id[i]);
      if (meet) run_over_[static_cast<std::size_t>(s.number)] = 1;
    });
  }

  // Whether the ball in a body ends its way inside of something that does not give way.
  bool is_inside(const Struck& s, Proxy other, const Vec3& way) const {
    CollideSettings at_the_end = state_.search.settings;
    at_the_end.step = at_the_end.margin = 0, at_the_end.struck.clear();
    Proxy ball{};
    ball.position = s.centre + s.way, ball.velocity = Vec3::Zero(), ball.rotation = Mat3::Identity();
    ball.half = Vec3::Constant(s.half_size), ball.radius = ball.half_size = s.half_size;
    ball.kind = ShapeKind::sphere, ball.dynamic = true, ball.group = -1, ball.id = s.id;
    other.position += way, other.velocity.setZero(), other.speed = other.spin_reach = other.bounce_reach = 0;
    bool inside = false;
    const auto judge = [&](const PairManifold& m) {
      for (int k = 0; k < m.count; ++k) inside = inside || m.points[k].gap < -share * s.half_size;
    };
    other.id < ball.id ? collide_parts(other, ball, at_the_end, judge) : collide_parts(ball, other, at_the_end, judge);
    return inside;
  }

  // Whether nothing has to be found for two bodies: they have a contact in this step already, or are not to touch.
  bool is_known(Id one, Id two) const {
    const std::pair<Id, Id> key = std::minmax(one, two);
    const auto& manifolds = state_.contacts.manifolds;
    const auto key_of = [](const Manifold& m) { return std::pair(m.id_a, m.id_b); };
    const auto found = std::ranges::lower_bound(manifolds, key, {}, key_of);
    if (found != manifolds.end() && key_of(*found) == key) return true;
    return std::ranges::any_of(state_.ties.joints, [&](auto j) {
      const Joint& joint = state_.scene.joints[static_cast<std::size_t>(j)];
      return !state_.ties.joint_input.is_broken(j) && std::pair<Id, Id>(std::minmax(joint.ids[0], joint.ids[1])) == key;
    });
  }

  const RankState& state_;
  const System& system_;
  StruckBodies ways_;
  std::vector<std::uint8_t> run_over_;
};

}  // namespace

bool find_struck(RankState& state, const System& system) {
  if (state.is_alone()) return false;
  const std::vector<Struck> here = faster_than_sought(state, system);
  if (!state.any_over_ranks(!here.empty())) return false;
  const std::vector<Struck> all = of_all_ranks(here, state.comm());
  const std::vector<std::uint8_t> run_over = RunOver(state, system, all).find();
  const double most = most_gain * fastest_before(state);
  std::vector<Struck> struck;
  for (Struck s : all) {
    if (!run_over[static_cast<std::size_t>(s.number)]) continue;
    s.reach += state.step() * (std::min(s.speed, most) - s.speed), s.speed = std::min(s.speed, most);
    struck.push_back(s);
  }
  state.search.settings.struck.add(with_images(struck, state.world.period));
  return !struck.empty();
}

}  // namespace unibody
