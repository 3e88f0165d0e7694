#include "partition/halo.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "collide/periodic_pairs.hpp"
#include "core/checked.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_cells = 101, tag_large = 102, tag_guests = 103, tag_homes = 104, tag_questions = 105, tag_wanted = 106,
              tag_asked = 107, tag_told = 108;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t cells_of_a_large_body = 64;  // beyond this a body is compared by its bounds rather than by its cells

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

bool contains(const Bounds& outer, const Bounds& inner) {
  return (outer.lower.array() <= inner.lower.array()).all() && (inner.upper.array() <= outer.upper.array()).all();
}

// A cell's key wraps round after 2^21 cells an axis: two far cells may share a key, which costs a needless guest and nothing
// else.
std::int64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::int64_t mask = (1 << 21) - 1;
  return (x & mask) << 42 | (y & mask) << 21 | (z & mask);
}

struct CellRange {
  std::int64_t lower[3], upper[3];
  std::int64_t count() const {
    double n = 1;
    for (int i = 0; i < 3; ++i) n *= static_cast<double>(upper[i] - lower[i] + 1);
    return n > 1e9 ? 1000000000 : static_cast<std::int64_t>(n);
  }
};

CellRange cells_of(const Bounds& b, double cell) {
  CellRange r{};
  for (int i = 0; i < 3; ++i) {
    r.lower[i] = static_cast<std::int64_t>(std::floor(std::clamp(b.lower[i] / cell, -1e15, 1e15)));
    r.upper[i] = static_cast<std::int64_t>(std::floor(std::clamp(b.upper[i] / cell, -1e15, 1e15)));
  }
  return r;
}

template <typename F>
void for_each_cell(const CellRange& r, F&& f) {
  for (auto x = r.lower[0]; x <= r.upper[0]; ++x)
    for (auto y = r.lower[1]; y <= r.upper[1]; ++y)
      for (auto z = r.lower[2]; z <= r.upper[2]; ++z) f(cell_key(x, y, z));
}

// What a rank tells its neighbours of where its bodies are.
struct Occupancy {
  std::vector<std::int64_t> cells;  // sorted, unique
  std::vector<Bounds> large;
  bool meets(const Bounds& b, double cell) const {
    if (std::any_of(large.begin(), large.end(), [&](const Bounds& l) { return overlap(l, b); })) return true;
    bool found = false;
    for_each_cell(cells_of(b, cell), [&](std::int64_t key) { found |= std::binary_search(cells.begin(), cells.end(), key); });
    return found;
  }
};

// Cells and large bodies of this rank, as far as a neighbour's bounds reach.
Occupancy occupancy(const std::vector<Bounds>& bodies, const std::vector<Bounds>& everyone, const std::vector<int>& neighbours,
                    double cell) {
  Occupancy mine;
  for (const Bounds& b : bodies) {
    if (std::none_of(neighbours.begin(), neighbours.end(),
                     [&](int r) { return overlap(b, everyone[static_cast<std::size_t>(r)]); }))
      continue;
    const CellRange range = cells_of(b, cell);
    if (range.count() > cells_of_a_large_body)
      mine.large.push_back(b);
    else
      for_each_cell(range, [&](std::int64_t key) { mine.cells.push_back(key); });
  }
  std::sort(mine.cells.begin(), mine.cells.end());
  mine.cells.erase(std::unique(mine.cells.begin(), mine.cells.end()), mine.cells.end());
  return mine;
}

}  // namespace

struct Halo::Guest {
  Body body;
  std::int64_t global;  // index in the Vecs
  int rank;
  int unused = 0;
};

Halo::Halo(MPI_Comm comm) : comm_(comm) {
  check_mpi(MPI_Comm_rank(comm, &rank_));
  check_mpi(MPI_Comm_size(comm, &size_));
}

Halo::~Halo() { destroy_vecs(); }

// Who has which body is asked of a directory: rank id % size knows of the wanted ones.
void Halo::reset(const World& world, const std::vector<Id>& wanted) {
  valid_ = placed_ = false;
  subscribed_.clear();
  std::int64_t any_wanted = static_cast<std::int64_t>(wanted.size());
  if (size_ > 1) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &any_wanted, 1, MPI_INT64_T, MPI_SUM, comm_));
  if (size_ == 1 || any_wanted == 0) return;
  const auto ranks = static_cast<std::size_t>(size_);
  const auto keeper = [&](Id id) { return static_cast<std::size_t>(id) % ranks; };
  std::vector<std::vector<Id>> here(ranks), questions(ranks);
  for (std::size_t i = 0; i < world.homes; ++i) here[keeper(world.id[i])].push_back(world.id[i]);
  for (const Id id : wanted) questions[keeper(id)].push_back(id);
  const auto homes = exchange_all(comm_, here, tag_homes);
  const auto asked = exchange_all(comm_, questions, tag_questions);
  std::vector<std::vector<std::pair<Id, int>>> to_home(ranks);  // at the home rank: who wants the body
  for (std::size_t r = 0; r < ranks; ++r)
    for (const Id id : asked[r])
      for (std::size_t home = 0; home < ranks; ++home)
        if (std::binary_search(homes[home].begin(), homes[home].end(), id)) to_home[home].emplace_back(id, static_cast<int>(r));
  for (const auto& list : exchange_all(comm_, to_home, tag_wanted))
    for (const auto& [id, rank] : list) subscribed_[rank].push_back(world.find(id));
  for (auto& [rank, slots] : subscribed_) std::sort(slots.begin(), slots.end());
}

void Halo::destroy_vecs() {
  for (Vec& v : vec_)
    if (v) check_petsc(VecDestroy(&v));
}

void Halo::make_vecs(World& world, const std::vector<PetscInt>& guest_global) {
  destroy_vecs();
  const auto homes = static_cast<PetscInt>(world.homes);
  const auto guests = static_cast<PetscInt>(guest_global.size());
  const auto make = [&](Field field, PetscInt block, double* array) {
    check_petsc(VecCreateGhostBlockWithArray(comm_, block, block * homes, PETSC_DECIDE, guests, guest_global.data(), array,
                                             &vec_[field]));
  };
  // PETSc takes a null array as "allocate your own": an empty rank gives it the address of something.
  static double nothing[4];
  const auto data = [](auto& v) { return v.empty() ? nothing : reinterpret_cast<double*>(v.data()); };
  make(position, 3, data(world.position));
  if (world.has_rotations) make(orientation, 4, data(world.orientation));
  make(velocity, 3, data(world.velocity));
  if (world.has_rotations) make(angular_velocity, 3, data(world.angular_velocity));
}

void Halo::refresh_guests(World& world, const CollideSettings& settings, Surfaces* surfaces) {
  if (valid_) update_guests();
  int valid = valid_ && still_valid(world, settings, surfaces);
  if (size_ > 1) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &valid, 1, MPI_INT, MPI_MIN, comm_));
  if (valid) return;
  find_guests(world, settings, surfaces);
  valid_ = true;
}

void Halo::refresh_partners(World& world) {
  if (valid_) return update_guests();
  place_guests(world, subscribed_guests(world, first_global(world)));
  valid_ = true;
}

void Halo::update_guests() {
  if (size_ == 1) return;
  for (Vec v : vec_)
    if (v) check_petsc(VecGhostUpdateBegin(v, INSERT_VALUES, SCATTER_FORWARD));
  for (Vec v : vec_)
    if (v) check_petsc(VecGhostUpdateEnd(v, INSERT_VALUES, SCATTER_FORWARD));
}

void Halo::update(Field field) const {
  if (size_ == 1) return;
  check_petsc(VecGhostUpdateBegin(vec_[field], INSERT_VALUES, SCATTER_FORWARD));
  check_petsc(VecGhostUpdateEnd(vec_[field], INSERT_VALUES, SCATTER_FORWARD));
}

void Halo::tell_guests(const World& world, std::span<std::int32_t> values) const {
  if (size_ == 1) return;
  std::vector<std::vector<Id>> questions(static_cast<std::size_t>(size_));
  for (std::size_t g = 0; g < world.guests; ++g)
    questions[static_cast<std::size_t>(guest_rank_[g])].push_back(world.id[world.homes + g]);
  const auto asked = exchange_all(comm_, questions, tag_asked);
  std::vector<std::vector<std::int32_t>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const Id id : asked[r]) answers[r].push_back(values[static_cast<std::size_t>(world.find(id))]);
  const auto told = exchange_all(comm_, answers, tag_told);
  std::vector<std::size_t> next(told.size(), 0);
  for (std::size_t g = 0; g < world.guests; ++g) {
    const auto home = static_cast<std::size_t>(guest_rank_[g]);
    values[world.homes + g] = told[home][next[home]++];
  }
}

// What the home bodies may touch in a step; with a skin, so that it holds for some steps.
std::vector<Bounds> Halo::reach(const World& world, const CollideSettings& settings, const Surfaces* surfaces, bool skin) const {
  std::vector<Bounds> bounds(world.homes);
  for (std::size_t i = 0; i < world.homes; ++i) bounds[i] = swept_bounds(world, i, settings);
  if (surfaces) surfaces->widen(world, settings, bounds);
  for (std::size_t i = 0; i < world.homes && skin; ++i) {
    const bool is_node = surfaces && surfaces->is_node(static_cast<Slot>(i));
    const double size = is_node ? (bounds[i].upper - bounds[i].lower).maxCoeff() / 2 : bounding_radius(world.properties[i].shape);
    const double width = 0.3 * size + settings.step * world.velocity[i].norm();
    bounds[i].lower.array() -= width, bounds[i].upper.array() += width;
  }
  return bounds;
}

bool Halo::still_valid(const World& world, const CollideSettings& settings, const Surfaces* surfaces) const {
  if (size_ == 1) return true;
  const std::vector<Bounds> now = reach(world, settings, surfaces, false);
  for (std::size_t i = 0; i < world.homes; ++i)
    if (!contains(registered_[i], now[i])) return false;
  return true;
}

std::int64_t Halo::first_global(const World& world) const {
  const auto homes = static_cast<std::int64_t>(world.homes);
  std::int64_t first = 0;
  check_mpi(MPI_Exscan(&homes, &first, 1, MPI_INT64_T, MPI_SUM, comm_));
  return rank_ == 0 ? 0 : first;
}

std::vector<Halo::Guest> Halo::subscribed_guests(const World& world, std::int64_t first) const {
  std::vector<int> neighbours;
  std::vector<std::vector<Guest>> to;
  for (const auto& [rank, slots] : subscribed_) {
    neighbours.push_back(rank);
    auto& list = to.emplace_back();
    for (const Slot s : slots) list.push_back({world.body(static_cast<std::size_t>(s)), first + s, rank_});
  }
  std::vector<Guest> guests;
  for (const auto& list : exchange_with(comm_, neighbours, to, tag_guests)) guests.insert(guests.end(), list.begin(), list.end());
  return guests;
}

// In place of the old ones; statics move along behind them. Where they are the old ones, whose states are up to date, nothing
// moves.
void Halo::place_guests(World& world, std::vector<Guest> guests) {
  std::sort(guests.begin(), guests.end(), [](const Guest& a, const Guest& b) { return a.body.id < b.body.id; });
  const auto is_old = [&](const Guest& guest) {
    const auto g = static_cast<std::size_t>(&guest - guests.data());
    return world.id[world.homes + g] == guest.body.id && guest_rank_[g] == guest.rank;
  };
  const bool stay = placed_ && guests.size() == world.guests && std::all_of(guests.begin(), guests.end(), is_old);
  int all_stay = stay;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all_stay, 1, MPI_INT, MPI_MIN, comm_));
  if (all_stay) return;
  if (!stay) put_guests(world, guests);
  std::vector<PetscInt> global(guests.size());
  for (std::size_t g = 0; g < guests.size(); ++g) global[g] = static_cast<PetscInt>(guests[g].global);
  make_vecs(world, global);
  placed_ = true;
}

void Halo::put_guests(World& world, std::span<const Guest> guests) {
  ++version_;
  const std::size_t statics = world.size() - world.first_static();
  std::vector<Body> static_bodies(statics);
  for (std::size_t i = 0; i < statics; ++i) static_bodies[i] = world.body(world.first_static() + i);
  world.guests = guests.size();
  world.resize(world.homes + world.guests + statics);
  guest_rank_.resize(guests.size());
  for (std::size_t g = 0; g < guests.size(); ++g) {
    world.set(world.homes + g, guests[g].body);
    guest_rank_[g] = guests[g].rank;
  }
  for (std::size_t i = 0; i < statics; ++i) world.set(world.first_static() + i, static_bodies[i]);
}

void Halo::find_guests(World& world, const CollideSettings& settings, Surfaces* surfaces) {
  const std::int64_t old_version = version_;
  std::vector<Guest> guests;
  if (size_ > 1) {
    const std::int64_t first = first_global(world);
    if (surfaces && !placed_) {  // how far a face reaches is known once its nodes are here
      place_guests(world, subscribed_guests(world, first));
      surfaces->build(world);
    }
    registered_ = reach(world, settings, surfaces, true);
    double sizes[2] = {0, static_cast<double>(world.homes)};
    for (const Bounds& b : registered_) sizes[0] += (b.upper - b.lower).maxCoeff();
    // The cell edge, the mean size of the bounds, only sets the price: a body of common size touches at most eight cells.
    double total[2] = {0, 0};
    check_mpi(MPI_Reduce(sizes, total, 2, MPI_DOUBLE, MPI_SUM, 0, comm_));  // inexact, and harmless: no result depends on it,
    check_mpi(MPI_Bcast(total, 2, MPI_DOUBLE, 0, comm_));                   // as long as every rank has the same
    const double cell = std::max(1e-6, total[0] / std::max(1.0, total[1]));

    const Copies places(registered_, world.period);
    Bounds all{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
    for (const Bounds& b : places.bounds) all.lower = all.lower.cwiseMin(b.lower), all.upper = all.upper.cwiseMax(b.upper);
    std::vector<Bounds> everyone(static_cast<std::size_t>(size_));
    check_mpi(MPI_Allgather(&all, sizeof(Bounds), MPI_BYTE, everyone.data(), sizeof(Bounds), MPI_BYTE, comm_));
    std::vector<int> neighbours;
    for (int r = 0; r < size_; ++r)
      if (r != rank_ && (overlap(all, everyone[static_cast<std::size_t>(r)]) || subscribed_.contains(r))) neighbours.push_back(r);
    const Occupancy mine = occupancy(places.bounds, everyone, neighbours, cell);

    const std::size_t n = neighbours.size();
    const auto cells = exchange_with(comm_, neighbours, std::vector(n, mine.cells), tag_cells);
    const auto large = exchange_with(comm_, neighbours, std::vector(n, mine.large), tag_large);
    std::vector<std::vector<Guest>> to(n);
    for (std::size_t k = 0; k < n; ++k) {
      const Occupancy theirs{cells[k], large[k]};
      const Bounds& reach_there = everyone[static_cast<std::size_t>(neighbours[k])];
      const auto subscribed = subscribed_.find(neighbours[k]);
      const auto is_wanted = [&](std::size_t i) {
        return subscribed != subscribed_.end() &&
               std::binary_search(subscribed->second.begin(), subscribed->second.end(), static_cast<Slot>(i));
      };
      const auto is_near = [&](const Bounds& b) {
        return overlap(b, reach_there) && (cells_of(b, cell).count() > cells_of_a_large_body || theirs.meets(b, cell));
      };
      for (std::size_t i = 0, place = 0; i < world.homes; ++i) {
        bool is_guest = is_wanted(i);
        for (; place < places.of.size() && places.of[place] == static_cast<std::int32_t>(i); ++place)
          is_guest = is_guest || is_near(places.bounds[place]);
        if (is_guest) to[k].push_back({world.body(i), first + static_cast<std::int64_t>(i), rank_});
      }
    }
    for (const auto& list : exchange_with(comm_, neighbours, to, tag_guests))
      guests.insert(guests.end(), list.begin(), list.end());
  }
  place_guests(world, std::move(guests));
  if (surfaces && version_ != old_version) surfaces->build(world);
}

}  // namespace unibody
