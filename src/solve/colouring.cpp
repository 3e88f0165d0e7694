#include "solve/colouring.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <unordered_map>

#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_colours = 121;
constexpr std::size_t ahead = 16;  // manifolds are asked for this long before their turn: they come in no order

std::uint64_t mix(std::uint64_t x) {  // splitmix64's finaliser
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint32_t priority_of(const Manifold& m) {
  return static_cast<std::uint32_t>(
      mix(mix(static_cast<std::uint64_t>(m.id_a) + 0x9e3779b97f4a7c15ULL) + static_cast<std::uint64_t>(m.id_b)) >> 32);
}

// Manifold numbers in the order of their priorities; ties by number, that is by key. A radix sort.
std::pmr::vector<std::uint32_t> by_priority(const std::vector<Manifold>& manifolds, std::pmr::memory_resource* memory) {
  using Entry = std::pair<std::uint32_t, std::uint32_t>;
  constexpr int digit = 11;
  std::pmr::vector<Entry> from(manifolds.size(), memory), to(manifolds.size(), memory);
  for (std::uint32_t m = 0; m < from.size(); ++m) from[m] = {priority_of(manifolds[m]), m};
  for (int shift = 0; shift < 32; shift += digit) {
    std::uint32_t begin[(1 << digit) + 1] = {};
    const auto digit_of = [&](const Entry& e) { return e.first >> shift & ((1u << digit) - 1); };
    for (const Entry& e : from) ++begin[digit_of(e) + 1];
    std::partial_sum(std::begin(begin), std::end(begin), std::begin(begin));
    for (const Entry& e : from) to[begin[digit_of(e)]++] = e;
    std::swap(from, to);
  }
  std::pmr::vector<std::uint32_t> order(from.size(), memory);
  for (std::size_t i = 0; i < from.size(); ++i) order[i] = from[i].second;
  return order;
}

// The colours taken at each home body: 64 in place, more for the few bodies that many others touch.
class TakenColours {
 public:
  using Words = std::span<const std::uint64_t>;

  TakenColours(std::size_t homes, std::pmr::memory_resource* memory) : first_(homes, 0, memory) {}

  void take(Slot s, std::int32_t colour) {
    const auto word = static_cast<std::size_t>(colour) / 64;
    const std::uint64_t bit = std::uint64_t{1} << (colour % 64);
    if (word == 0) {
      first_[static_cast<std::size_t>(s)] |= bit;
      return;
    }
    auto& more = more_[s];
    if (more.size() < word) more.resize(word, 0);
    more[word - 1] |= bit;
  }
  std::uint64_t word(Slot s, std::size_t i) const {
    if (i == 0) return first_[static_cast<std::size_t>(s)];
    const auto it = more_.find(s);
    return it != more_.end() && i <= it->second.size() ? it->second[i - 1] : 0;
  }
  std::size_t words(Slot s) const {
    if (more_.empty()) return 1;
    const auto it = more_.find(s);
    return it == more_.end() ? 1 : 1 + it->second.size();
  }

 private:
  std::pmr::vector<std::uint64_t> first_;
  std::unordered_map<Slot, std::vector<std::uint64_t>> more_;
};

// Takes the manifolds in the order of their priorities, pass after pass. A manifold across the cut has to wait for the other
// rank's offer: the colours taken at the body there, sent when it is first in line there. While it waits, so do those behind it.
class Colourer {
 public:
  Colourer(const World& world, const Contacts& contacts, const Exchange& exchange, std::pmr::memory_resource* memory)
      : world_(world),
        ends_(contacts.manifolds.size(), memory),
        exchange_(exchange),
        taken_(world.homes, memory),
        waiting_(by_priority(contacts.manifolds, memory)),
        result_{std::pmr::vector<std::int32_t>(ends_.size(), -1, memory), 0} {
    for (std::size_t m = 0; m < ends_.size(); ++m) ends_[m] = {contacts.manifolds[m].slot_a, contacts.manifolds[m].slot_b};
    for (std::size_t k = 0; k < exchange.neighbours().size(); ++k)
      for (std::size_t i = 0; i < exchange.neighbours()[k].manifolds.size(); ++i)
        shared_.emplace(exchange.neighbours()[k].manifolds[i], Shared{k, i, false, {}});
  }

  Colouring run() {
    std::vector<std::size_t> left(exchange_.neighbours().size());
    for (std::size_t k = 0; k < left.size(); ++k) left[k] = exchange_.neighbours()[k].manifolds.size();
    offers_.resize(left.size());
    pass();
    while (std::any_of(left.begin(), left.end(), [](auto n) { return n > 0; })) {
      exchange_offers(left);
      pass();
    }
    for (const std::int32_t c : result_.colour) result_.colours = std::max(result_.colours, static_cast<std::size_t>(c) + 1);
    return std::move(result_);
  }

 private:
  using Ends = std::array<Slot, 2>;
  struct Shared {
    std::size_t neighbour, place;            // place in the list that both ranks have
    bool offered;                            // by this rank
    std::vector<std::uint64_t> taken_there;  // empty: no offer yet
  };

  void pass() {
    std::vector<std::uint8_t> blocked(world_.homes, 0);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      const std::uint32_t m = waiting_[i];
      if (i + ahead < waiting_.size()) __builtin_prefetch(&ends_[waiting_[i + ahead]]);
      const Ends& ends = ends_[m];
      bool ready = true;
      for (const Slot s : ends) ready &= !world_.is_home(s) || !blocked[static_cast<std::size_t>(s)];
      if (ready && give_colour(m, ends)) continue;
      for (const Slot s : ends)
        if (world_.is_home(s)) blocked[static_cast<std::size_t>(s)] = 1;
      waiting_[kept++] = m;
    }
    waiting_.resize(kept);
  }

  // The smallest colour free at both bodies; false where the other rank has not said what is free at its own.
  bool give_colour(std::uint32_t m, const Ends& ends) {
    const bool across = is_guest(ends[0]) || is_guest(ends[1]);
    Shared* shared = across ? &shared_.at(m) : nullptr;
    if (shared && !shared->offered) offer(*shared, is_guest(ends[0]) ? ends[1] : ends[0]);
    if (shared && shared->taken_there.empty()) return false;
    std::int32_t colour = 0;
    for (std::size_t w = 0;; ++w) {
      std::uint64_t taken = shared && w < shared->taken_there.size() ? shared->taken_there[w] : 0;
      for (const Slot s : ends)
        if (world_.is_home(s)) taken |= taken_.word(s, w);
      if (~taken == 0) continue;
      colour = static_cast<std::int32_t>(64 * w) + __builtin_ctzll(~taken);
      break;
    }
    result_.colour[m] = colour;
    for (const Slot s : ends)
      if (world_.is_home(s)) taken_.take(s, colour);
    return true;
  }

  bool is_guest(Slot s) const { return !world_.is_home(s) && !world_.is_static(s); }

  // Message: for each manifold newly first in line here its place, the number of words, and the words of the colours taken.
  void offer(Shared& shared, Slot home) {
    auto& message = offers_[shared.neighbour];
    const std::size_t words = taken_.words(home);
    message.push_back(shared.place), message.push_back(words);
    for (std::size_t w = 0; w < words; ++w) message.push_back(taken_.word(home, w));
    shared.offered = true;
  }

  // With the neighbours that still share an uncoloured manifold. A shared manifold gets its colour on both ranks in the pass
  // after both have offered, so the two count alike and stop together.
  void exchange_offers(std::vector<std::size_t>& left) {
    const PhaseClock::Scope scope(exchange_.clock(), Phase::halo);
    std::vector<int> ranks;
    std::vector<std::size_t> who;
    std::vector<std::vector<std::uint64_t>> out;
    for (std::size_t k = 0; k < left.size(); ++k)
      if (left[k] > 0)
        ranks.push_back(exchange_.neighbours()[k].rank), who.push_back(k), out.push_back(std::move(offers_[k])), offers_[k] = {};
    const auto in = exchange_with(exchange_.comm(), ranks, out, tag_colours);
    for (std::size_t i = 0; i < who.size(); ++i) {
      const auto& list = exchange_.neighbours()[who[i]].manifolds;
      for (std::size_t at = 0; at < in[i].size(); at += 2 + in[i][at + 1]) {
        const auto begin = in[i].begin() + static_cast<std::ptrdiff_t>(at + 2);
        shared_.at(list[in[i][at]]).taken_there.assign(begin, begin + static_cast<std::ptrdiff_t>(in[i][at + 1]));
      }
      left[who[i]] = 0;
      for (const std::uint32_t m : list) left[who[i]] += !shared_.at(m).offered || shared_.at(m).taken_there.empty();
    }
  }

  const World& world_;
  std::pmr::vector<Ends> ends_;  // of each manifold: small enough for the cache, where they come in no order
  const Exchange& exchange_;
  TakenColours taken_;
  std::pmr::vector<std::uint32_t> waiting_;           // manifolds that have no colour yet, in the order of their priorities
  std::unordered_map<std::uint32_t, Shared> shared_;  // manifolds across the cut
  std::vector<std::vector<std::uint64_t>> offers_;    // to be sent, by neighbour
  Colouring result_;
};

}  // namespace

Colouring colour_manifolds(const World& world, const Contacts& contacts, const Exchange& exchange,
                           std::pmr::memory_resource* memory) {
  return Colourer(world, contacts, exchange, memory).run();
}

}  // namespace unibody
