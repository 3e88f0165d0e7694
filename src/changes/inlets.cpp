#include "changes/inlets.hpp"

#include <algorithm>
#include <cmath>

#include "core/checked.hpp"
#include "step/build.hpp"

namespace unibody {

namespace {

constexpr std::uint64_t most_tries = 20;    // of a body in a frame
constexpr std::size_t most_at_once = 4096;  // bodies that look for room in a frame, beside those that have just become due
constexpr double rounding_of_count = 1e-9;  // of an integral that should be whole

// Numbers that have become due by the start of the frame wait for room from now on.
void draw_due(const BodyGroup& group, double now, InletPast& past) {
  const Inlet& inlet = *group.inlet;
  const double due = inlet.due(now);
  while (past.drawn < group.count) {
    const double mass = group.make(past.drawn).properties.mass;
    const bool is_due = inlet.by_mass ? past.drawn_mass + 0.5 * mass <= due
                                      : static_cast<double>(past.drawn + 1) <= due * (1 + rounding_of_count);
    if (!is_due) break;
    past.waiting.push_back(past.drawn);
    ++past.drawn, past.drawn_mass += mass;
  }
}

// A body as something that is in the way: it stands still.
Body as_obstacle(Body body) {
  body.properties.motion = Motion::fixed;
  body.state.velocity.setZero(), body.state.angular_velocity.setZero();
  return body;
}

CollideSettings still_settings(const Simulation& simulation) {
  CollideSettings settings = simulation.search.settings;
  settings.step = 0, settings.margin = 0, settings.gravity.setZero();
  settings.restitution.clear(), settings.struck = {};
  return settings;
}

// This rank's bodies that a body of the inlet could touch.
std::vector<Body> obstacles_near(const Simulation& simulation, const Inlet& inlet, const CollideSettings& still) {
  const World& world = simulation.world;
  const Vec3 low = inlet.low.array() - inlet.largest_radius, high = inlet.high.array() + inlet.largest_radius;
  std::vector<Body> near;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (i == world.homes) i = world.first_static();  // guests are another rank's
    if (i >= world.size()) break;
    const Bounds bounds = swept_bounds(world, i, still);
    bool is_near = true;  // along axes of a period everything may be
    for (int k = 0; k < 3; ++k)
      is_near = is_near && (world.period.along(k) || (bounds.lower[k] <= high[k] && bounds.upper[k] >= low[k]));
    if (is_near) near.push_back(as_obstacle(world.body(i)));
  }
  return near;
}

// Which of the candidates overlap an obstacle of any rank, and which pairs of them each other.
struct Overlap {
  std::vector<std::uint8_t> blocked;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // first < second
};

Overlap find_overlaps(const Simulation& simulation, const std::vector<Body>& candidates, std::vector<Body> obstacles,
                      const CollideSettings& still) {
  std::ranges::sort(obstacles, {}, &Body::id);
  std::vector<Body> at_rest = candidates;
  for (Body& body : at_rest) body.state.velocity.setZero(), body.state.angular_velocity.setZero();
  const World world = make_world(at_rest, obstacles, simulation.scene.has_rotations(), simulation.scene.period);
  Contacts contacts;
  collide(world, still, contacts);
  Overlap overlap{std::vector<std::uint8_t>(candidates.size()), {}};
  for (const Manifold& m : contacts.manifolds) {
    bool overlaps = false;
    for (std::uint32_t k = 0; k < m.count; ++k) overlaps = overlaps || contacts.points[m.first + k].gap < 0;
    if (!overlaps) continue;
    const auto a = static_cast<std::size_t>(m.slot_a), b = static_cast<std::size_t>(m.slot_b);
    if (a < candidates.size() && b < candidates.size())
      overlap.pairs.emplace_back(std::min(a, b), std::max(a, b));
    else
      overlap.blocked[std::min(a, b)] = 1;
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, overlap.blocked.data(), static_cast<int>(overlap.blocked.size()), MPI_UINT8_T, MPI_MAX,
                          simulation.comm()));
  return overlap;
}

// The candidates that may come in: none overlaps an obstacle, nor one of a smaller number that may.
std::vector<std::size_t> those_with_room(Overlap overlap) {
  std::ranges::sort(overlap.pairs);
  std::vector<std::size_t> chosen;
  auto pair = overlap.pairs.begin();
  for (std::size_t i = 0; i < overlap.blocked.size(); ++i) {
    const bool has_room = overlap.blocked[i] == 0;
    if (has_room) chosen.push_back(i);
    for (; pair != overlap.pairs.end() && pair->first == i; ++pair)
      if (has_room) overlap.blocked[pair->second] = 1;
  }
  return chosen;
}

// The bodies of an inlet that find room in this frame, on all ranks alike. `others`: those of inlets before it.
std::vector<Body> place_waiting(const Simulation& simulation, const BodyGroup& group, std::int64_t frame, std::size_t most,
                                const std::vector<Body>& others, InletPast& past) {
  const CollideSettings still = still_settings(simulation);
  std::vector<Body> obstacles = obstacles_near(simulation, *group.inlet, still), placed;
  for (const Body& body : others) obstacles.push_back(as_obstacle(body));
  for (std::uint64_t t = 0; t < most_tries && !past.waiting.empty(); ++t) {
    const auto count = std::min(most, past.waiting.size());
    std::vector<Body> candidates;
    for (std::size_t i = 0; i < count; ++i)
      candidates.push_back(group.inlet->place(past.waiting[i], static_cast<std::uint64_t>(frame) * most_tries + t));
    const std::vector<std::size_t> chosen = those_with_room(find_overlaps(simulation, candidates, obstacles, still));
    for (const std::size_t i : chosen) {
      placed.push_back(candidates[i]), obstacles.push_back(as_obstacle(candidates[i]));
      ++past.placed, past.placed_mass += candidates[i].properties.mass;
      past.waiting[i] = -1;
    }
    std::erase(past.waiting, -1);
  }
  return placed;
}

// The rank that has the most bodies near the inlet; where none has any, the one with the fewest bodies.
int rank_for(const Simulation& simulation, const Inlet& inlet) {
  const World& world = simulation.world;
  const double reach = 4 * inlet.largest_radius;
  struct {
    double number;
    int rank;
  } most{0, simulation.halo.rank()}, fewest{static_cast<double>(world.homes), simulation.halo.rank()};
  const Vec3 low = inlet.low.array() - reach, high = inlet.high.array() + reach;
  for (std::size_t i = 0; i < world.homes; ++i) {
    const Vec3 place = world.period.wrapped(world.position[i], low);
    most.number += (place.array() >= low.array()).all() && (place.array() <= high.array()).all();
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, simulation.comm()));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &fewest, 1, MPI_DOUBLE_INT, MPI_MINLOC, simulation.comm()));
  return most.number > 0 ? most.rank : fewest.rank;
}

}  // namespace

bool let_in(Simulation& simulation, std::int64_t frame) {
  const Scene& scene = simulation.scene;
  const double now = static_cast<double>(frame - 1) * scene.time.frame;
  std::vector<Body> all;
  Simulation::BodyChanges changes;
  std::size_t number = 0;
  for (const BodyGroup& group : scene.groups) {
    if (!group.inlet) continue;
    InletPast& past = simulation.history.past.inlets[number++];
    const Id before = past.drawn;
    draw_due(group, now, past);
    if (past.waiting.empty()) continue;
    const std::size_t most = most_at_once + static_cast<std::size_t>(past.drawn - before);
    const std::vector<Body> placed = place_waiting(simulation, group, frame, most, all, past);
    all.insert(all.end(), placed.begin(), placed.end());
    if (!placed.empty() && rank_for(simulation, *group.inlet) == simulation.halo.rank())
      changes.homes.insert(changes.homes.end(), placed.begin(), placed.end());
  }
  if (!all.empty()) simulation.change_bodies(changes);
  return !all.empty();
}

}  // namespace unibody
