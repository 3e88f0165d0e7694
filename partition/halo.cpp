#include "partition/halo.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "collide/periodic_pairs.hpp"
#include "core/checked.hpp"
#include "partition/messages.hpp"
#include "partition/neighbours.hpp"

namespace unibody {

namespace {

constexpr int tag_guests = 104, tag_homes = 105, tag_questions = 106, tag_wanted = 107, tag_asked = 108, tag_told = 109;

bool contains(const Bounds& outer, const Bounds& inner) {
  return (outer.lower.array() <= inner.lower.array()).all() && (inner.upper.array() <= outer.upper.array()).all();
}

// Blocks are so large that a rank's bodies touch some tens of them where they fill space. Collective.
CellSizes cell_sizes(MPI_Comm comm, std::span<const Bounds> bounds) {
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  double sizes[2] = {0, static_cast<double>(bounds.size())}, total[2] = {0, 0};
  for (const Bounds& b : bounds) sizes[0] += (b.upper - b.lower).maxCoeff();
  check_mpi(MPI_Reduce(sizes, total, 2, MPI_DOUBLE, MPI_SUM, 0, comm));  // inexact, and harmless: no result depends on it,
  check_mpi(MPI_Bcast(total, 2, MPI_DOUBLE, 0, comm));                   // as long as every rank has the same
  // A body of the mean size touches at most eight cells.
  return {std::max(1e-6, total[0] / std::max(1.0, total[1])),
          std::max<std::int64_t>(1, std::llround(std::cbrt(total[1] / ranks) / 4))};
}

int numbers_of(Halo::Field field) { return field == Halo::orientation ? 4 : 3; }

// PETSc takes a null array as "allocate your own": an empty rank gives it the address of something.
double* array_of(World& world, Halo::Field field) {
  static double nothing[4];
  const auto data = [](auto& v) { return v.empty() ? nothing : reinterpret_cast<double*>(v.data()); };
  switch (field) {
    case Halo::position:
      return data(world.position);
    case Halo::orientation:
      return data(world.orientation);
    case Halo::velocity:
      return data(world.velocity);
    default:
      return data(world.angular_velocity);
  }
}

}  // namespace

struct Halo::Guest {
  Body body;
  std::int32_t slot;  // at home
  int rank;
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
  const auto keeper = [&](Id id) { return static_cast<int>(id % size_); };
  ListsByRank<Id> here, questions;
  for (std::size_t i = 0; i < world.homes; ++i) here[keeper(world.id[i])].push_back(world.id[i]);
  for (const Id id : wanted) questions[keeper(id)].push_back(id);
  std::vector<std::pair<Id, int>> homes;
  for (const auto& [rank, ids] : exchange_lists(comm_, here, tag_homes))
    for (const Id id : ids) homes.emplace_back(id, rank);
  std::sort(homes.begin(), homes.end());
  ListsByRank<std::pair<Id, int>> to_home;  // who wants the body
  for (const auto& [rank, ids] : exchange_lists(comm_, questions, tag_questions))
    for (const Id id : ids) {
      const auto home = std::lower_bound(homes.begin(), homes.end(), std::pair(id, 0));
      if (home != homes.end() && home->first == id) to_home[home->second].emplace_back(id, rank);
    }
  for (const auto& [keeper_rank, list] : exchange_lists(comm_, to_home, tag_wanted))
    for (const auto& [id, rank] : list) subscribed_[rank].push_back(world.find(id));
  for (auto& [rank, slots] : subscribed_) std::sort(slots.begin(), slots.end());
}

void Halo::destroy_vecs() {
  for (Vec& v : vec_)
    if (v) check_petsc(VecDestroy(&v));
}

void Halo::make_vecs(World& world) {
  destroy_vecs();
  const auto homes = static_cast<PetscInt>(world.homes);
  for (int f = 0; f < field_count; ++f)
    if (world.has_rotations || f == position || f == velocity)
      check_petsc(VecCreateMPIWithArray(comm_, numbers_of(Field(f)), numbers_of(Field(f)) * homes, PETSC_DECIDE,
                                        array_of(world, Field(f)), &vec_[f]));
}

void Halo::make_forest(const World& world) {
  std::vector<PetscSFNode> homes(world.guests);
  for (std::size_t g = 0; g < world.guests; ++g) homes[g] = {guest_rank_[g], guest_slot_[g]};
  if (forest_ == nullptr) {
    check_petsc(PetscSFCreate(comm_, &forest_));
    check_petsc(PetscSFSetFromOptions(forest_));
  }
  check_petsc(PetscSFReset(forest_));
  check_petsc(PetscSFSetGraph(forest_, static_cast<PetscInt>(world.homes), static_cast<PetscInt>(world.guests), nullptr,
                              PETSC_COPY_VALUES, homes.data(), PETSC_COPY_VALUES));
  check_petsc(PetscSFSetUp(forest_));
}

void Halo::refresh_guests(World& world, const CollideSettings& settings, Surfaces* surfaces) {
  if (valid_) update_guests(world);
  int valid = valid_ && still_valid(world, settings, surfaces);
  if (size_ > 1) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &valid, 1, MPI_INT, MPI_MIN, comm_));
  if (valid) return;
  find_guests(world, settings, surfaces);
  valid_ = true;
}

void Halo::refresh_partners(World& world) {
  if (valid_) return update_guests(world);
  place_guests(world, guests_of(world, {}));
  valid_ = true;
}

// The Vecs follow the World's arrays wherever these have moved to.
void Halo::follow_arrays(World& world) {
  for (int f = 0; f < field_count; ++f) {
    if (vec_[f] == nullptr) continue;
    check_petsc(VecResetArray(vec_[f]));
    check_petsc(VecPlaceArray(vec_[f], array_of(world, Field(f))));
  }
}

void Halo::update_guests(World& world) { update(world, {position, orientation, velocity, angular_velocity}); }

void Halo::update(World& world, std::initializer_list<Field> fields) {
  if (size_ == 1) return;
  follow_arrays(world);
  for (const bool begins : {true, false})
    for (const Field f : fields) {
      if (vec_[f] == nullptr) continue;
      const double* homes = nullptr;
      check_petsc(VecGetArrayRead(vec_[f], &homes));
      double* const guests = array_of(world, f) + static_cast<std::ptrdiff_t>(world.homes) * numbers_of(f);
      const auto bring = begins ? PetscSFBcastBegin : PetscSFBcastEnd;
      check_petsc(bring(forest_, numbers_of(f) == 4 ? four_ : three_, homes, guests, MPI_REPLACE));
      check_petsc(VecRestoreArrayRead(vec_[f], &homes));
    }
}

void Halo::tell_guests(const World& world, std::span<std::int32_t> values) const {
  if (size_ == 1) return;
  ListsByRank<Id> questions;
  for (std::size_t g = 0; g < world.guests; ++g) questions[guest_rank_[g]].push_back(world.id[world.homes + g]);
  ListsByRank<std::int32_t> answers;
  for (const auto& [rank, ids] : exchange_lists(comm_, questions, tag_asked))
    for (const Id id : ids) answers[rank].push_back(values[static_cast<std::size_t>(world.find(id))]);
  const auto told = exchange_lists(comm_, answers, tag_told);
  std::map<int, std::size_t> next;
  for (std::size_t g = 0; g < world.guests; ++g) {
    const int home = guest_rank_[g];
    values[world.homes + g] = told.at(home)[next[home]++];
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

std::vector<Halo::Guest> Halo::guests_of(const World& world, const ListsByRank<Slot>& near) const {
  ListsByRank<Guest> to;
  const auto send = [&](int rank, const std::vector<Slot>& slots) {
    for (const Slot s : slots) to[rank].push_back({world.body(static_cast<std::size_t>(s)), s, rank_});
  };
  for (const auto& [rank, slots] : subscribed_)
    if (!near.contains(rank)) send(rank, slots);
  for (const auto& [rank, slots] : near) {
    const auto subscribed = subscribed_.find(rank);
    if (subscribed == subscribed_.end()) {
      send(rank, slots);
      continue;
    }
    std::vector<Slot> all;
    std::ranges::set_union(slots, subscribed->second, std::back_inserter(all));
    send(rank, all);
  }
  return joined(exchange_lists(comm_, to, tag_guests));
}

// In place of the old ones; statics move along behind them. Where they are the old ones, whose states are up to date, nothing
// moves.
void Halo::place_guests(World& world, std::vector<Guest> guests) {
  std::sort(guests.begin(), guests.end(), [](const Guest& a, const Guest& b) { return a.body.id < b.body.id; });
  const auto is_old = [&](const Guest& guest) {
    const auto g = static_cast<std::size_t>(&guest - guests.data());
    return world.id[world.homes + g] == guest.body.id && guest_rank_[g] == guest.rank && guest_slot_[g] == guest.slot;
  };
  const bool stay = placed_ && guests.size() == world.guests && std::all_of(guests.begin(), guests.end(), is_old);
  int all_stay = stay;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all_stay, 1, MPI_INT, MPI_MIN, comm_));
  if (all_stay) return;
  if (!stay) put_guests(world, guests);
  if (!placed_) make_vecs(world);
  make_forest(world);
  placed_ = true;
}

void Halo::put_guests(World& world, std::span<const Guest> guests) {
  ++version_;
  const std::size_t statics = world.size() - world.first_static();
  std::vector<Body> static_bodies(statics);
  for (std::size_t i = 0; i < statics; ++i) static_bodies[i] = world.body(world.first_static() + i);
  world.guests = guests.size();
  world.resize(world.homes + world.guests + statics);
  guest_rank_.resize(guests.size()), guest_slot_.resize(guests.size());
  for (std::size_t g = 0; g < guests.size(); ++g) {
    world.set(world.homes + g, guests[g].body);
    guest_rank_[g] = guests[g].rank, guest_slot_[g] = guests[g].slot;
  }
  for (std::size_t i = 0; i < statics; ++i) world.set(world.first_static() + i, static_bodies[i]);
}

void Halo::find_guests(World& world, const CollideSettings& settings, Surfaces* surfaces) {
  const std::int64_t old_version = version_;
  std::vector<Guest> guests;
  if (size_ > 1) {
    if (surfaces && !placed_) {  // how far a face reaches is known once its nodes are here
      place_guests(world, guests_of(world, {}));
      surfaces->build(world);
    }
    registered_ = reach(world, settings, surfaces, true);
    const Copies places(registered_, world.period);
    guests = guests_of(world, bodies_near_ranks(comm_, places.bounds, places.of, cell_sizes(comm_, registered_)));
  }
  place_guests(world, std::move(guests));
  if (surfaces && version_ != old_version) surfaces->build(world);
}

}  // namespace unibody
