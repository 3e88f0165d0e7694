#include "step/side_guard.hpp"

#include <algorithm>
#include <cmath>

#include "collide/broadphase.hpp"
#include "collide/passage.hpp"
#include "collide/periodic_pairs.hpp"
#include "core/checked.hpp"
#include "joints/joint_set.hpp"
#include "step/attach.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

// Shares of half a body's size: what moves less against a mesh, or against a solid, is where its contacts left it; and how near
// to a surface a centre that is held may come.
constexpr double least_before_mesh = 0.01, least_before_solid = 0.5, kept = 0.1;

bool is_compound(const Shape& shape) { return shape.kind == ShapeKind::compound; }
bool is_mesh(const Shape& shape) { return shape.kind == ShapeKind::mesh; }

// A node of a soft solid that nothing can touch.
bool is_inside_a_solid(const RankState& state, std::size_t body) {
  return state.has_surfaces() && state.search.surfaces.is_interior(static_cast<Slot>(body));
}

// Particles are nodes, which the guard of surfaces knows.
bool is_obstacle(const Shape& shape) {
  if (shape.kind == ShapeKind::particle) return false;
  return is_mesh(shape) || is_compound(shape) || type_of(shape.kind).convex;
}

// m, of the smallest part.
double half_size_of(const Shape& shape) {
  if (!is_compound(shape)) return 0.5 * smallest_size(shape);
  double smallest = HUGE_VAL;
  for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
    smallest = std::min(smallest, 0.5 * smallest_size(part.shape));
  return smallest;
}

// Which bodies have no contacts with each other wherever they are.
class Strangers {
 public:
  explicit Strangers(const RankState& state)
      : state_(state),
        holder_(holders(state.scene, state.world, state.time())),
        jointed_(state.traits.has_joints ? jointed_pairs(state.ties.joint_input) : std::vector<std::pair<Id, Id>>()) {}

  bool are(std::size_t body, std::size_t other) const {
    const World& world = state_.world;
    const std::int32_t group = world.properties[body].group;
    if (group >= 0 && group == world.properties[other].group) return true;
    const Id a = world.id[body], b = world.id[other];
    if (!holder_.empty() && holder_[body] == b) return true;
    return !state_.search.settings.may_touch(a, b) || std::ranges::binary_search(jointed_, std::pair<Id, Id>(std::minmax(a, b)));
  }

 private:
  const RankState& state_;
  std::vector<Id> holder_;
  std::vector<std::pair<Id, Id>> jointed_;
};

// Where a point that would go from `from` to `to` ends in front of an obstacle; m, in the obstacle's frame.
Vec3 held_place(const Shape& obstacle, const Vec3& from, const Vec3& to, double half_size) {
  const double moved = (to - from).norm();
  if (is_mesh(obstacle)) {
    if (!(moved > least_before_mesh * half_size)) return to;
    const MeshSurface& mesh = shape_library().meshes[obstacle.data];
    return held_back(from, to, kept * half_size, [&](const Vec3& a, const Vec3& b) { return passage_through(mesh, a, b); });
  }
  if (!(moved > least_before_solid * half_size)) return to;
  if (!is_compound(obstacle)) {
    const ConvexBody solid = convex_body(obstacle, Mat3::Identity(), Vec3::Zero());
    return held_back(from, to, kept * half_size, [&](const Vec3& a, const Vec3& b) { return passage_into(solid, a, b); });
  }
  const auto first_of_parts = [&](const Vec3& a, const Vec3& b) {
    Passage first;
    for (const Compound::Part& part : shape_library().compounds[obstacle.data].parts) {
      const ConvexBody solid = convex_body(part.shape, part.turn.toRotationMatrix(), part.place);
      if (const Passage found = passage_into(solid, a, b); found.share < first.share) first = found;
    }
    return first;
  };
  return held_back(from, to, kept * half_size, first_of_parts);
}

}  // namespace

SideGuard::SideGuard(const RankState& state) {
  const World& world = state.world;
  for (std::size_t i = world.first_static(); i < world.size(); ++i)
    if (is_obstacle(world.properties[i].shape))
      obstacles_.push_back({i, world.position[i], world.orientation_of(i).toRotationMatrix()});
  if (obstacles_.empty()) return;
  const auto homes = static_cast<std::ptrdiff_t>(world.homes);
  places_.assign(world.position.begin(), world.position.begin() + homes);
  for (std::size_t i = 0; i < world.homes && turns_.empty(); ++i)
    if (is_compound(world.properties[i].shape)) turns_.assign(world.orientation.begin(), world.orientation.begin() + homes);
}

// rad, by which a body has turned, or a little more.
double SideGuard::turn_of(const World& world, std::size_t body) const {
  const auto &now = world.orientation[body].coeffs(), &before = turns_[body].coeffs();
  return M_PI * std::min((now - before).norm(), (now + before).norm());
}

// m, the most that a point of an obstacle moves in the step.
double SideGuard::motion_of(const Obstacle& obstacle, const RankState& state) {
  const World& world = state.world;
  if (world.properties[obstacle.slot].motion == Motion::fixed) return 0;
  const double turned = state.step() * world.angular_velocity_of(obstacle.slot).norm();
  return (world.position[obstacle.slot] - obstacle.place).norm() +
         std::min(turned, 2.0) * bounding_radius(world.properties[obstacle.slot].shape);
}

// Slots of the bodies that may have got into a solid, which moves by `driven` (m) at most: most bodies move too little for that.
std::vector<std::size_t> SideGuard::fast_bodies(const RankState& state, double driven) const {
  const World& world = state.world;
  std::vector<std::size_t> fast;
  for (std::size_t i = 0; i < world.homes; ++i) {
    const Shape& shape = world.properties[i].shape;
    const double turned = is_compound(shape) ? bounding_radius(shape) * turn_of(world, i) : 0;
    const double moved = (world.position[i] - places_[i]).norm() + turned + driven;
    if (moved > least_before_solid * half_size_of(shape) && !is_inside_a_solid(state, i)) fast.push_back(i);
  }
  return fast;
}

// The ways of these bodies and those of solids that come near each other, by their places in the two lists.
std::vector<SideGuard::Pair> SideGuard::near_solids(const World& world, const std::vector<std::size_t>& bodies) const {
  std::vector<Bounds> bounds;
  std::vector<Role> roles;
  const auto add = [&](const Vec3& from, const Vec3& to, double reach, Role role) {
    bounds.push_back({from.cwiseMin(to).array() - reach, from.cwiseMax(to).array() + reach}), roles.push_back(role);
  };
  for (const std::size_t i : bodies) {
    const Shape& shape = world.properties[i].shape;
    add(places_[i], world.position[i], is_compound(shape) ? bounding_radius(shape) : 0, Role::home);
  }
  for (const Obstacle& o : obstacles_) {
    const Shape& shape = world.properties[o.slot].shape;
    add(o.place, world.position[o.slot], bounding_radius(shape), is_mesh(shape) ? Role::absent : Role::other);
  }
  BroadPhase broad_phase;
  Pairs found;
  world.period.any() ? find_periodic(broad_phase, world.period, bounds, roles, found) : broad_phase.find(bounds, roles, found);
  std::vector<Pair> near;
  for (const IndexPair& pair : found) {
    const auto first = static_cast<std::size_t>(pair.first), second = static_cast<std::size_t>(pair.second);
    if (first < bodies.size() && second >= bodies.size()) near.push_back({bodies[first], second - bodies.size()});
  }
  return near;
}

// All bodies with all meshes, whose triangles are found sooner than they could be left out, and the fast ones with the solids
// near them; ascending.
std::vector<SideGuard::Pair> SideGuard::pairs(const RankState& state) const {
  const World& world = state.world;
  std::vector<Pair> found;
  double driven = 0;  // m
  std::size_t solids = 0;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    if (!is_mesh(world.properties[obstacles_[k].slot].shape)) {
      driven = std::max(driven, motion_of(obstacles_[k], state)), ++solids;
      continue;
    }
    for (std::size_t i = 0; i < world.homes; ++i)
      if (!is_inside_a_solid(state, i)) found.push_back({i, k});
  }
  if (const std::vector<std::size_t> fast = solids > 0 ? fast_bodies(state, driven) : std::vector<std::size_t>(); !fast.empty()) {
    const std::vector<Pair> near = near_solids(world, fast);
    found.insert(found.end(), near.begin(), near.end());
  }
  const Strangers strangers(state);
  std::erase_if(found, [&](const Pair& pair) { return strangers.are(pair.body, obstacles_[pair.obstacle].slot); });
  std::ranges::sort(found);
  return found;
}

std::vector<SideGuard::Centre> SideGuard::centres_of(const World& world, std::size_t body) const {
  const Shape& shape = world.properties[body].shape;
  const Vec3 &from = places_[body], &to = world.position[body];
  if (!is_compound(shape)) return {{from, to, 0.5 * smallest_size(shape)}};
  std::vector<Centre> centres;
  for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
    centres.push_back(
        {from + turns_[body] * part.place, to + world.orientation[body] * part.place, 0.5 * smallest_size(part.shape)});
  return centres;
}

// m, by what the body's way has to change for its centres to stay in front of an obstacle.
Vec3 SideGuard::change_before(const Obstacle& obstacle, const World& world, std::size_t body,
                              const std::vector<Centre>& centres) const {
  const Vec3 image = world.period.shift(world.period.nearest(places_[body], obstacle.place));  // of a periodic scene's obstacle
  const Mat3 turn = world.orientation_of(obstacle.slot).toRotationMatrix();
  Vec3 change = Vec3::Zero();
  for (std::size_t round = 0; round < (centres.size() > 1 ? 4 : 1); ++round) {
    const Vec3 before = change;
    for (const Centre& centre : centres) {
      const Vec3 from = obstacle.turn.transpose() * (centre.from - image - obstacle.place);
      const Vec3 to = turn.transpose() * (centre.to + change - image - world.position[obstacle.slot]);
      const Vec3 place = held_place(world.properties[obstacle.slot].shape, from, to, centre.half_size);
      if (place != to) change += turn * (place - to);
    }
    if (change == before) break;
  }
  return change;
}

std::int64_t SideGuard::hold(RankState& state) const {
  if (obstacles_.empty()) return 0;
  World& world = state.world;
  std::int64_t held = 0;
  const std::vector<Pair> near = pairs(state);
  for (auto pair = near.begin(); pair != near.end();) {
    const std::size_t body = pair->body;
    std::vector<Centre> centres = centres_of(world, body);
    Vec3 change = Vec3::Zero();
    for (; pair != near.end() && pair->body == body; ++pair) {
      const Vec3 more = change_before(obstacles_[pair->obstacle], world, body, centres);
      for (Centre& centre : centres) centre.to += more;
      change += more;
    }
    if (change.isZero(0)) continue;
    ++held;
    world.position[body] += change, world.velocity[body] += change / state.step();
  }
  if (!state.is_alone()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_INT64_T, MPI_SUM, state.comm()));
  return held;
}

}  // namespace unibody
