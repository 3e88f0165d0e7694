#include "solve/surface_guard.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_set>

#include "collide/continuous.hpp"
#include "collide/triangle_distance.hpp"
#include "core/checked.hpp"
#include "solve/free_motion.hpp"
#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

// After so many rounds the ends of a pair are stopped against each other altogether, so that it ends.
constexpr int gentle_rounds = 6, most_rounds = 60;

// Pairs are kept apart by this share of the distance at which surfaces touch, or by half of what there is.
constexpr double kept_share = 0.1;

// A round body that is no node is kept off by this share of its radius: contacts still have a clear side to push it to, while it
// is held, and what it lies on need not come as near as its centre to be safe.
constexpr double kept_of_radius = 0.5;

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

// Adds the points by which a solid counts (m, body axes), moved: corners of its core, the furthest along the diagonals and axes
// of its frame; of a compound those of its parts.
void add_points(const Shape& shape, const Vec3& place, const Quat& turn, std::vector<Vec3>& points) {
  if (shape.kind == ShapeKind::compound) {
    for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
      add_points(part.shape, place + turn * part.place, turn * part.turn, points);
    return;
  }
  const ConvexFunctions* convex = type_of(shape.kind).convex;
  if (!convex) return;
  const auto own = static_cast<std::ptrdiff_t>(points.size());
  const auto add = [&](const Vec3& direction) {
    const Vec3 point = place + turn * convex->support(shape, direction);
    if (std::find(points.begin() + own, points.end(), point) == points.end()) points.push_back(point);
  };
  for (int k = 0; k < 8; ++k) add(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  if (shape.kind == ShapeKind::box) return;
  for (int k = 0; k < 3; ++k) add(Vec3::Unit(k)), add(-Vec3::Unit(k));
}

}  // namespace

SurfaceGuard::SurfaceGuard(World& world, const Surfaces& surfaces, const CollideSettings& settings,
                           std::pmr::memory_resource* memory)
    : world_(world),
      surfaces_(surfaces),
      settings_(settings),
      bounds_(memory),
      roles_(memory),
      filters_(memory),
      pairs_(memory),
      broad_phase_(memory) {}

// Bounds of the way that a feature goes in the step.
Bounds SurfaceGuard::path(std::span<const Slot> nodes, std::span<const Vec3> velocity, double more) const {
  Bounds b{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
  for (const Slot s : nodes) {
    const auto i = static_cast<std::size_t>(s);
    const Vec3 &from = world_.position[i], to = from + settings_.step * velocity[i];
    b.lower = b.lower.cwiseMin(from).cwiseMin(to), b.upper = b.upper.cwiseMax(from).cwiseMax(to);
  }
  b.lower.array() -= more, b.upper.array() += more;
  return b;
}

Bounds SurfaceGuard::path(const Point& point, std::span<const Vec3> velocity, const Vec3& turned, double more) const {
  const auto i = static_cast<std::size_t>(point.slot);
  const Vec3 from = world_.position[i] + point.arm, to = from + settings_.step * velocity[i] + turned;
  return {from.cwiseMin(to).array() - more, from.cwiseMax(to).array() + more};
}

// By how much a solve may take a feature off its way for it to be looked for still (m): no more than Halo knows of.
double SurfaceGuard::slack(std::span<const Slot> nodes) const { return surface_slack(world_, nodes); }

// A side's part of how far apart pairs are kept (m).
double SurfaceGuard::kept(Slot s) const {
  const Shape& shape = world_.properties[static_cast<std::size_t>(s)].shape;
  if (surfaces_.is_node(s)) return kept_share * shape.size.x();
  return is_round(shape) ? kept_of_radius * shape.size.x() : 0;
}

// The angular velocities (rad/s) with which bodies will turn in the step; those of guests come from their homes.
std::vector<Vec3> SurfaceGuard::spins(std::span<const SolverBody> bodies, Halo& halo) {
  if (!world_.has_rotations) return std::vector<Vec3>(world_.size(), Vec3::Zero());
  const std::vector<Vec3> before = world_.angular_velocity;
  for (std::size_t i = 0; i < world_.homes; ++i) world_.angular_velocity[i] = Eigen::Map<const Vec3>(bodies[i].w);
  halo.update(world_, {Halo::angular_velocity});
  std::vector<Vec3> now = world_.angular_velocity;
  std::copy(before.begin(), before.end(), world_.angular_velocity.begin());  // in place: the Vec lies over it
  return now;
}

void SurfaceGuard::list_points(std::span<const Vec3> spins) {
  points_.clear();
  std::vector<Vec3> arms;
  for (Slot s = 0; static_cast<std::size_t>(s) < world_.size(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    const Shape& shape = world_.properties[i].shape;
    if (is_round(shape)) points_.push_back({s});
    if (is_round(shape) || !world_.properties[i].is_dynamic()) continue;
    const Quat q = world_.orientation_of(i);
    const Quat next = turned_by(q, spins[i], settings_.step);
    int corner = 0;
    arms.clear();
    add_points(shape, Vec3::Zero(), Quat::Identity(), arms);
    for (const Vec3& arm : arms) points_.push_back({s, corner++, q * arm, next * arm - q * arm});
  }
}

void SurfaceGuard::list_features(std::span<const SolverBody> bodies, Halo& halo) {
  constexpr std::uint8_t none = 0, point = 1, face = 2, edge = 4;
  filters_.clear();
  const auto add = [&](std::int32_t group, std::uint8_t kind, std::uint8_t accepts) {
    filters_.push_back({group, kind, accepts});
  };
  const auto group_of = [&](Slot s) { return surfaces_.contact_group(world_, s); };
  list_points(spins(bodies, halo));
  for (const Point& p : points_) add(surfaces_.is_node(p.slot) ? group_of(p.slot) : -1, point, face);
  double sizes = 0;
  for (const SurfaceFace& f : surfaces_.faces) {
    add(group_of(f.nodes[0]), face, surfaces_.is_closed(f.surface) ? none : point);
    sizes += 2 * surface_slack(world_, f.nodes);
  }
  face_size_ = std::max(1e-6, sizes / static_cast<double>(std::max<std::size_t>(1, surfaces_.faces.size())));
  if (surfaces_.edges_may_meet())
    for (const SurfaceEdge& e : surfaces_.edges) add(group_of(e.nodes[0]), edge, surfaces_.is_closed(e.surface) ? none : edge);
}

// Features are looked up by boxes of about one size, that of a face, so that they share a level of the grid; after the first
// round, by those near something that has moved.
void SurfaceGuard::find_pairs() {
  bounds_.clear(), roles_.clear(), pairs_.clear();
  const auto has_moved = [&](Slot s) { return moved_[static_cast<std::size_t>(s)] != 0; };
  const auto add = [&](std::span<const Slot> nodes, double more) {
    bounds_.push_back(path(nodes, world_.velocity, more));
    roles_.push_back(std::any_of(nodes.begin(), nodes.end(), has_moved) ? Role::home : Role::other);
  };
  for (const Point& p : points_) {
    bounds_.push_back(path(p, world_.velocity, p.turned, std::max(face_size_ / 2, kept(p.slot))));
    roles_.push_back(has_moved(p.slot) ? Role::home : Role::other);
  }
  for (const SurfaceFace& f : surfaces_.faces) add(f.nodes, kept(f.nodes[0]));
  if (surfaces_.edges_may_meet())
    for (const SurfaceEdge& e : surfaces_.edges) add(e.nodes, kept(e.nodes[0]));
  leave_out_distant();
  broad_phase_.find(bounds_, roles_, pairs_, filters_);
  if (settings_.touch_rules == nullptr) return;
  std::erase_if(pairs_, [&](const IndexPair& pair) {
    const Candidate both = candidate(pair);
    const auto id = [&](std::size_t k) { return world_.id[static_cast<std::size_t>(both.ends[k])]; };
    return !settings_.may_touch(id(0), id(both.point ? 1 : 2));
  });
}

// Leaves out the features that touch no cell which something that has moved touches.
void SurfaceGuard::leave_out_distant() {
  const double cell = 2 * face_size_;
  std::unordered_set<std::uint64_t> cells;
  const auto any_cell = [&](const Bounds& b, auto&& f) {  // until f says yes
    const Vec3 low = (b.lower / cell).array().floor(), high = (b.upper / cell).array().floor();
    if (!((high - low).maxCoeff() < 16)) return true;  // or it is large
    for (double x = low.x(); x <= high.x(); ++x)
      for (double y = low.y(); y <= high.y(); ++y)
        for (double z = low.z(); z <= high.z(); ++z) {
          const auto bits = [](double c) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(c)) & 0x1fffff; };
          if (f(bits(x) << 42 | bits(y) << 21 | bits(z))) return true;
        }
    return false;
  };
  if (std::find(roles_.begin(), roles_.end(), Role::other) == roles_.end()) return;
  for (std::size_t i = 0; i < bounds_.size(); ++i)
    if (roles_[i] == Role::home && any_cell(bounds_[i], [&](std::uint64_t key) {
          cells.insert(key);
          return false;
        }))
      return;
  for (std::size_t i = 0; i < bounds_.size(); ++i)
    if (!any_cell(bounds_[i], [&](std::uint64_t key) { return cells.contains(key); })) roles_[i] = Role::absent;
}

SurfaceGuard::Candidate SurfaceGuard::candidate(const IndexPair& pair) const {
  const std::size_t points = points_.size(), faces = points + surfaces_.faces.size();
  const auto first = static_cast<std::size_t>(pair.first), second = static_cast<std::size_t>(pair.second);
  if (first >= faces) {
    const auto *e = &surfaces_.edges[first - faces].nodes, *f = &surfaces_.edges[second - faces].nodes;
    const auto id = [&](Slot s) { return world_.id[static_cast<std::size_t>(s)]; };
    if (std::pair(id((*f)[0]), id((*f)[1])) < std::pair(id((*e)[0]), id((*e)[1]))) std::swap(e, f);
    return {{(*e)[0], (*e)[1], (*f)[0], (*f)[1]}, nullptr};
  }
  const auto& nodes = surfaces_.faces[second - points].nodes;
  return {{points_[first].slot, nodes[0], nodes[1], nodes[2]}, &points_[first]};
}

void SurfaceGuard::test(const Candidate& pair) {
  const auto& s = pair.ends;
  const auto is_dynamic = [&](Slot end) { return world_.properties[static_cast<std::size_t>(end)].is_dynamic(); };
  if (std::none_of(s.begin(), s.end(), [&](Slot end) { return world_.is_home(end); })) return;
  if (std::none_of(s.begin(), s.end(), is_dynamic)) return;  // nothing here can be changed
  const bool edges = pair.point == nullptr;
  const std::size_t sides = edges ? 2 : 1;
  for (std::size_t i = 0; i < sides; ++i)
    if (std::find(s.begin() + static_cast<std::ptrdiff_t>(sides), s.end(), s[i]) != s.end()) return;
  const std::span<const Slot> one(s.data(), sides), other(s.data() + sides, 4 - sides);
  const Vec3 turned = edges ? Vec3(Vec3::Zero()) : pair.point->turned;
  const auto first_path = [&](std::span<const Vec3> velocity, const Vec3& turn, double more) {
    return edges ? path(one, velocity, more) : path(*pair.point, velocity, turn, more);
  };
  if (!overlap(first_path(world_.velocity, turned, kept(s[0])), path(other, world_.velocity, kept(s[3])))) return;
  if (!overlap(first_path(start_, Vec3::Zero(), edges ? slack(one) : 0), path(other, start_, slack(other)))) return;

  const auto place = [&](std::size_t k) -> Vec3 {
    const Vec3& centre = world_.position[static_cast<std::size_t>(s[k])];
    return k == 0 && !edges ? Vec3(centre + pair.point->arm) : centre;
  };
  const double distance = edges ? closest_of_segments(place(0), place(1), place(2), place(3)).distance
                                : closest_on_triangle(place(0), place(1), place(2), place(3)).distance;
  const double own = edges ? kept(s[0]) : std::max(kept(s[0]), kept(s[3]));
  const double apart = std::min(own + kept(s[3]), (own > kept(s[3]) ? 0.9999 : 0.5) * distance);
  if (!(apart > 1e-12)) return;  // on each other already: contacts alone can part them
  const auto way = [&](std::size_t k) {
    Vec3 to = place(k) + settings_.step * world_.velocity[static_cast<std::size_t>(s[k])];
    if (k == 0) to += turned;
    return MovingPoint{place(k), to};
  };
  const ContinuousSettings settings{apart, (own > kept(s[3]) ? 2e-5 : 0.1) * apart, 200};
  const ContinuousHit hit = edges ? edge_meets_edge(way(0), way(1), way(2), way(3), settings)
                                  : point_meets_triangle(way(0), way(1), way(2), way(3), settings);
  if (!hit.hit) return;
  Hit& found = hits_.emplace_back(Hit{{}, turned / settings_.step, s, hit.weights, 0.9 * hit.time});
  for (std::size_t k = 0; k < 4; ++k) found.key[k] = world_.id[static_cast<std::size_t>(s[k])];
  found.key[4] = edges ? 1 : pair.point->corner < 0 ? 0 : 2 + pair.point->corner;
}

Vec3 SurfaceGuard::velocity_of(const Hit& hit, std::size_t end) const {
  const Vec3& centre = world_.velocity[static_cast<std::size_t>(hit.ends[end])];
  return end == 0 ? Vec3(centre + hit.turning) : centre;
}

// m/s, towards which the ends of a pair are drawn: their mean; that of the held ones where there are any, and of a side that is
// held all over the velocity of its point that is met, as it may turn.
Vec3 SurfaceGuard::common_velocity(const Hit& hit) const {
  Vec3 momentum = Vec3::Zero(), held = Vec3::Zero();
  double mass = 0;
  int immobile = 0;
  const std::size_t second = hit.key[4] == 1 ? 2 : 1;  // where the second side begins
  for (const auto& [begin, end] : {std::pair(std::size_t{0}, second), std::pair(second, std::size_t{4})}) {
    Vec3 met = Vec3::Zero();
    std::size_t held_here = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const BodyProperties& body = world_.properties[static_cast<std::size_t>(hit.ends[k])];
      const Vec3 v = velocity_of(hit, k);
      met += hit.weights[k] * v;
      if (body.is_dynamic())
        momentum += body.mass * v, mass += body.mass;
      else
        held += v, ++immobile, ++held_here;
    }
    if (held_here == end - begin) return met;
  }
  return immobile > 0 ? Vec3(held / immobile) : Vec3(momentum / mass);
}

// Each home end goes to the mean of what its pairs ask of it. In the order of keys, so that sums are the same on all ranks.
void SurfaceGuard::draw_together(bool stop) {
  std::sort(hits_.begin(), hits_.end(), [](const Hit& a, const Hit& b) { return a.key < b.key; });
  struct Target {
    Vec3 sum = Vec3::Zero();
    int count = 0;
  };
  std::map<Slot, Target> targets;
  for (const Hit& hit : hits_) {
    const Vec3 mean = common_velocity(hit);
    for (std::size_t k = 0; k < 4; ++k) {
      const Slot s = hit.ends[k];
      const auto i = static_cast<std::size_t>(s);
      if (!world_.properties[i].is_dynamic() || !world_.is_home(s)) continue;
      Target& t = targets[s];
      const Vec3 v = velocity_of(hit, k);
      t.sum += world_.velocity[i] - (stop ? 1 : 1 - hit.share) * (v - mean), ++t.count;
    }
  }
  for (const auto& [slot, target] : targets) world_.velocity[static_cast<std::size_t>(slot)] = target.sum / target.count;
}

// The pair of the smallest first id, over all ranks.
std::array<Id, 2> SurfaceGuard::first_pair(MPI_Comm comm) const {
  constexpr Id none = std::numeric_limits<Id>::max();
  std::array<Id, 2> pair{none, none};
  for (const Hit& hit : hits_) pair = std::min(pair, {hit.key[0], hit.key[hit.key[4] == 1 ? 2 : 1]});
  Id first = pair[0];
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, comm));
  if (pair[0] != first) pair[1] = none;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &pair[1], 1, MPI_INT64_T, MPI_MIN, comm));
  return {first, pair[1]};
}

SurfaceGuard::Held SurfaceGuard::hold(std::span<SolverBody> bodies, Halo& halo) {
  if (surfaces_.all_closed()) return {};
  start_ = world_.velocity;
  for (std::size_t i = 0; i < world_.homes; ++i) world_.velocity[i] = Eigen::Map<const Vec3>(bodies[i].v);
  halo.update(world_, {Halo::velocity});
  list_features(bodies, halo);
  moved_.assign(world_.size(), 1);  // the pairs of the first round: all
  Held held;
  for (int round = 0;; ++round) {
    find_pairs();
    hits_.clear();
    for (const IndexPair& pair : pairs_) test(candidate(pair));
    const auto counts_here = [&](const Hit& hit) { return world_.is_home(hit.ends[world_.is_static(hit.ends[0]) ? 1 : 0]); };
    auto counted = static_cast<std::int64_t>(std::count_if(hits_.begin(), hits_.end(), counts_here));
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &counted, 1, MPI_INT64_T, MPI_SUM, halo.comm()));
    if (counted == 0) break;
    if (round == most_rounds) {
      held.not_held = first_pair(halo.comm());
      break;
    }
    held.pairs += counted;
    const std::vector<Vec3> before = world_.velocity;
    draw_together(round >= gentle_rounds);
    halo.update(world_, {Halo::velocity});
    for (std::size_t i = 0; i < before.size(); ++i) moved_[i] = before[i] != world_.velocity[i];
  }
  for (std::size_t i = 0; i < world_.homes && held.pairs > 0; ++i) std::copy_n(world_.velocity[i].data(), 3, bodies[i].v);
  return held;
}

}  // namespace unibody
