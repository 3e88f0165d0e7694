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

// Particles are nodes, which the guard of surfaces knows.
bool is_obstacle(const Shape& shape) {
  if (shape.kind == ShapeKind::particle) return false;
  return shape.kind == ShapeKind::mesh || is_compound(shape) || type_of(shape.kind).convex;
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

// Where a point ends (m, in the obstacle's frame).
Vec3 held_place(const Shape& obstacle, const Vec3& from, const Vec3& to, double half_size) {
  const double moved = (to - from).norm();
  if (obstacle.kind == ShapeKind::mesh) {
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

// Those of bodies and obstacles that come near each other, the smaller slot first.
std::vector<SideGuard::Pair> SideGuard::pairs(const RankState& state) const {
  const World& world = state.world;
  std::vector<Pair> found;
  const Strangers strangers(state);
  const auto add = [&](std::size_t body, std::size_t obstacle) {
    if (!strangers.are(body, obstacles_[obstacle].slot)) found.push_back({body, obstacle});
  };
  const auto is_mesh = [&](const Obstacle& o) { return world.properties[o.slot].shape.kind == ShapeKind::mesh; };
  double driven = 0;  // m
  std::vector<std::size_t> meshes;
  for (std::size_t k = 0; k < obstacles_.size(); ++k)
    is_mesh(obstacles_[k]) ? meshes.push_back(k) : void(driven = std::max(driven, motion_of(obstacles_[k], state)));

  std::vector<Bounds> bounds;
  std::vector<std::size_t> fast;
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (state.has_surfaces() && state.search.surfaces.is_interior(static_cast<Slot>(i))) continue;
    for (const std::size_t mesh : meshes) add(i, mesh);
    if (meshes.size() == obstacles_.size()) continue;
    const Shape& shape = world.properties[i].shape;
    const double reach = is_compound(shape) ? bounding_radius(shape) : 0, turned = reach > 0 ? reach * turn_of(world, i) : 0;
    if (!((world.position[i] - places_[i]).norm() + turned + driven > least_before_solid * half_size_of(shape))) continue;
    fast.push_back(i);
    bounds.push_back(
        {world.position[i].cwiseMin(places_[i]).array() - reach, world.position[i].cwiseMax(places_[i]).array() + reach});
  }
  if (!fast.empty()) {
    std::vector<Role> roles(fast.size(), Role::home);
    for (const Obstacle& obstacle : obstacles_) {
      const Vec3 &from = obstacle.place, &to = world.position[obstacle.slot];
      const double radius = bounding_radius(world.properties[obstacle.slot].shape);
      bounds.push_back({from.cwiseMin(to).array() - radius, from.cwiseMax(to).array() + radius});
      roles.push_back(is_mesh(obstacle) ? Role::absent : Role::other);
    }
    BroadPhase broad_phase;
    Pairs near;
    world.period.any() ? find_periodic(broad_phase, world.period, bounds, roles, near) : broad_phase.find(bounds, roles, near);
    const auto bodies = static_cast<std::int32_t>(fast.size());
    for (const IndexPair& pair : near)
      if (pair.first < bodies && pair.second >= bodies)
        add(fast[static_cast<std::size_t>(pair.first)], static_cast<std::size_t>(pair.second - bodies));
  }
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
