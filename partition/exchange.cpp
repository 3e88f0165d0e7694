#include "partition/exchange.hpp"

#include <algorithm>
#include <utility>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr int tag_exchange = 111;

// What travels of a value, and how it is read and written.
struct SentTwist {
  double v[3], w[3];
  static SentTwist of(const SolverBody& b) { return {{b.v[0], b.v[1], b.v[2]}, {b.w[0], b.w[1], b.w[2]}}; }
  void to(SolverBody& b) const { std::copy_n(v, 3, b.v), std::copy_n(w, 3, b.w); }
};
struct Velocity {  // of bodies that do not turn
  double v[3];
  static Velocity of(const SolverBody& b) { return {{b.v[0], b.v[1], b.v[2]}}; }
  void to(SolverBody& b) const { std::copy_n(v, 3, b.v); }
};
template <class T>
struct Plain {
  T value;
  static Plain of(T v) { return {v}; }
  void to(T& v) const { v = value; }
};

void sort_unique(std::vector<Slot>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace

void Exchange::share_lasting(const World& world, std::size_t batch, bool by_colour, const Stencils& stencils) {
  if (halo_.size() == 1) return;
  std::vector<TrafficByRank> of_colour;
  TrafficByRank all;
  stencils([&](std::int32_t colour, std::span<const Slot> ends) {
    const auto c = static_cast<std::size_t>(colour);
    if (by_colour && colour >= 0 && c >= of_colour.size()) of_colour.resize(c + 1);
    share(world, ends, by_colour && colour >= 0 ? of_colour[c] : all);
  });
  std::vector<std::vector<Traffic>>& to = by_colour_[batch];
  for (TrafficByRank& traffic : of_colour) {
    add(traffic, lasting_);
    to.push_back(sorted(std::move(traffic)));
  }
  add(all, lasting_);
}

void Exchange::add(const TrafficByRank& more, TrafficByRank& traffic) {
  for (const auto& [rank, shared] : more) {
    Traffic& all = traffic.try_emplace(rank, Traffic{rank, {}, {}}).first->second;
    all.send.insert(all.send.end(), shared.send.begin(), shared.send.end());
    all.receive.insert(all.receive.end(), shared.receive.begin(), shared.receive.end());
    sort_unique(all.send), sort_unique(all.receive);
  }
}

// Slots of a range ascend with ids: the same order on both sides.
std::vector<Exchange::Traffic> Exchange::sorted(TrafficByRank&& traffic) {
  std::vector<Traffic> list;
  for (auto& [rank, shared] : traffic) {
    sort_unique(shared.send), sort_unique(shared.receive);
    list.push_back(std::move(shared));
  }
  return list;
}

void Exchange::share(const World& world, std::span<const Slot> ends, std::map<int, Traffic>& traffic) const {
  const auto is_guest = [&](Slot s) {
    return s >= 0 && static_cast<std::size_t>(s) < world.size() && !world.is_home(s) && !world.is_static(s);
  };
  std::vector<int> told;  // ranks
  for (const Slot guest : ends) {
    if (!is_guest(guest)) continue;
    const int rank = halo_.home_rank_of_guest(static_cast<std::size_t>(guest) - world.homes);
    Traffic& shared = traffic.try_emplace(rank, Traffic{rank, {}, {}}).first->second;
    shared.receive.push_back(guest);
    if (std::find(told.begin(), told.end(), rank) != told.end()) continue;
    told.push_back(rank);
    for (const Slot home : ends)
      if (home >= 0 && world.is_home(home)) shared.send.push_back(home);
  }
}

void Exchange::start_step(const World& world, const Contacts& contacts) {
  neighbours_.clear(), ends_.clear(), all_.clear();
  rotates_ = world.has_rotations;
  of_step_ = lasting_;
  if (halo_.size() == 1) return;
  std::map<int, Neighbour> found;
  for (std::uint32_t m = 0; m < contacts.manifolds.size(); ++m) {
    const Manifold& manifold = contacts.manifolds[m];
    if (world.is_static(manifold.slot_a) || world.is_static(manifold.slot_b)) continue;
    const bool a_home = world.is_home(manifold.slot_a), b_home = world.is_home(manifold.slot_b);
    if (a_home == b_home) continue;
    const Ends ends = a_home ? Ends{manifold.slot_a, manifold.slot_b} : Ends{manifold.slot_b, manifold.slot_a};
    const int rank = halo_.home_rank_of_guest(static_cast<std::size_t>(ends.guest) - world.homes);
    found.try_emplace(rank, Neighbour{rank, {}}).first->second.manifolds.push_back(m);
    ends_.emplace(m, ends);
  }
  for (auto& [rank, neighbour] : found) neighbours_.push_back(std::move(neighbour));
}

void Exchange::share(const World& world, const Stencils& stencils) {
  if (halo_.size() == 1) return;
  stencils([&](std::int32_t, std::span<const Slot> ends) { share(world, ends, of_step_); });
}

void Exchange::finish_step() { all_ = sorted(std::move(of_step_)), of_step_.clear(); }

void Exchange::set_colours(std::size_t batch, std::span<const std::int32_t> colour, std::size_t colours) {
  std::vector<std::vector<Traffic>>& by_colour = by_colour_[batch];
  by_colour.assign(colours, {});
  for (const Neighbour& neighbour : neighbours_)
    for (const std::uint32_t m : neighbour.manifolds) {
      auto& of_colour = by_colour[static_cast<std::size_t>(colour[m])];
      if (of_colour.empty() || of_colour.back().rank != neighbour.rank) of_colour.push_back({neighbour.rank, {}, {}});
      of_colour.back().send.push_back(ends_.at(m).home);
      of_colour.back().receive.push_back(ends_.at(m).guest);
    }
}

template <typename T, typename Record>
void Exchange::run(std::span<const Traffic> traffic, std::span<T> values) const {
  if (traffic.empty()) return;
  const PhaseClock::Scope scope(clock_, Phase::halo);
  const auto bytes = [](const std::vector<Slot>& slots) { return slots.size() * sizeof(Record); };
  const auto by_mail = [&](const Traffic& t, const std::vector<Slot>& slots) { return letters_.carry(t.rank, bytes(slots)); };
  std::size_t by_message = 0;
  for (const Traffic& t : traffic)
    for (const auto* slots : {&t.receive, &t.send}) by_message += by_mail(t, *slots) ? 0 : bytes(*slots);
  buffer_.resize(std::max(buffer_.size(), by_message));
  requests_.clear();
  std::byte* next = buffer_.data();
  const auto room_for = [&](const std::vector<Slot>& slots) { return std::exchange(next, next + bytes(slots)); };
  for (const Traffic& t : traffic)
    if (!by_mail(t, t.receive))
      check_mpi(MPI_Irecv(room_for(t.receive), mpi_count(bytes(t.receive)), MPI_BYTE, t.rank, tag_exchange, comm(),
                          &requests_.emplace_back()));
  for (const Traffic& t : traffic) {
    std::byte* const letter = by_mail(t, t.send) ? letters_.letter(t.rank) : room_for(t.send);
    auto* out = reinterpret_cast<Record*>(letter);
    for (const Slot s : t.send) *out++ = Record::of(values[s]);
    if (by_mail(t, t.send))
      letters_.send(t.rank);
    else
      check_mpi(MPI_Isend(letter, mpi_count(bytes(t.send)), MPI_BYTE, t.rank, tag_exchange, comm(), &requests_.emplace_back()));
  }
  check_mpi(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  next = buffer_.data();
  for (const Traffic& t : traffic) {
    const std::byte* const letter = by_mail(t, t.receive) ? letters_.receive(t.rank) : room_for(t.receive);
    const auto* in = reinterpret_cast<const Record*>(letter);
    for (const Slot s : t.receive) (in++)->to(values[s]);
  }
}

void Exchange::run(std::span<const Traffic> traffic, std::span<SolverBody> bodies) const {
  rotates_ ? run<SolverBody, SentTwist>(traffic, bodies) : run<SolverBody, Velocity>(traffic, bodies);
}

void Exchange::refresh(std::span<SolverBody> bodies) const { run(all_, bodies); }

void Exchange::refresh(std::span<std::int32_t> values) const { run<std::int32_t, Plain<std::int32_t>>(all_, values); }
void Exchange::refresh(std::span<double> values) const { run<double, Plain<double>>(all_, values); }

void Exchange::refresh(std::span<Vec3> values) const {
  std::vector<double> one(values.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < one.size(); ++i) one[i] = values[i][k];
    refresh(std::span(one));
    for (std::size_t i = 0; i < one.size(); ++i) values[i][k] = one[i];
  }
}

void Exchange::refresh(std::size_t batch, std::size_t colour, std::span<SolverBody> bodies) const {
  const auto found = by_colour_.find(batch);
  if (found != by_colour_.end() && colour < found->second.size()) run(found->second[colour], bodies);
}

}  // namespace unibody
