#include "solve/colouring.hpp"

#include <algorithm>
#include <numeric>

#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_colours = 121;

std::uint64_t mix(std::uint64_t x) {  // splitmix64's finaliser
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint64_t priority_of(const Manifold& m) {
  return mix(mix(static_cast<std::uint64_t>(m.id_a) + 0x9e3779b97f4a7c15ULL) + static_cast<std::uint64_t>(m.id_b));
}

// The waiting lines: for each home body its manifolds, first in line first.
class Lines {
 public:
  Lines(const World& world, const Contacts& contacts) : world_(world), manifolds_(contacts.manifolds) {
    const std::size_t n = manifolds_.size();
    std::vector<std::uint64_t> priority(n);
    begin_.assign(world.homes + 1, 0);
    for (std::uint32_t m = 0; m < n; ++m) {
      priority[m] = priority_of(manifolds_[m]);
      for (const Slot s : {manifolds_[m].slot_a, manifolds_[m].slot_b})
        if (world.is_home(s)) ++begin_[static_cast<std::size_t>(s) + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    line_.resize(begin_.back());
    head_.assign(begin_.begin(), begin_.end() - 1);
    std::vector<std::uint32_t> fill(head_);
    for (std::uint32_t m = 0; m < n; ++m)
      for (const Slot s : {manifolds_[m].slot_a, manifolds_[m].slot_b})
        if (world.is_home(s)) line_[fill[static_cast<std::size_t>(s)]++] = m;
    for (std::size_t i = 0; i < world.homes; ++i)  // ties: by manifold number, that is by key
      std::sort(line_.begin() + begin_[i], line_.begin() + begin_[i + 1],
                [&](auto x, auto y) { return std::pair(priority[x], x) < std::pair(priority[y], y); });
  }

  bool first_in_line(Slot s, std::uint32_t m) const { return line_[head_[static_cast<std::size_t>(s)]] == m; }

  // Moves the body's line on and returns the manifold that is first now, or -1.
  std::int64_t advance(Slot s) {
    const auto i = static_cast<std::size_t>(s);
    return ++head_[i] < begin_[i + 1] ? static_cast<std::int64_t>(line_[head_[i]]) : -1;
  }

  // The manifolds of a body that have their colour already.
  std::span<const std::uint32_t> served(Slot s) const {
    const auto i = static_cast<std::size_t>(s);
    return {line_.data() + begin_[i], head_[i] - begin_[i]};
  }

 private:
  const World& world_;
  const std::vector<Manifold>& manifolds_;
  std::vector<std::uint32_t> begin_, head_, line_;
};

// Which colours are taken, as a growing bit set.
class Taken {
 public:
  void clear() { bits_.clear(); }
  void add(std::int32_t colour) {
    const auto word = static_cast<std::size_t>(colour) / 64;
    if (word >= bits_.size()) bits_.resize(word + 1, 0);
    bits_[word] |= std::uint64_t{1} << (colour % 64);
  }
  std::int32_t smallest_free() const {
    for (std::size_t w = 0; w < bits_.size(); ++w)
      if (~bits_[w] != 0) return static_cast<std::int32_t>(64 * w) + __builtin_ctzll(~bits_[w]);
    return static_cast<std::int32_t>(64 * bits_.size());
  }

 private:
  std::vector<std::uint64_t> bits_;
};

class Colourer {
 public:
  Colourer(const World& world, const Contacts& contacts, const Cut& cut)
      : world_(world), contacts_(contacts), cut_(cut), lines_(world, contacts) {
    result_.colour.assign(contacts.manifolds.size(), -1);
    remote_.assign(contacts.manifolds.size(), -1);
    queued_.assign(contacts.manifolds.size(), 0);
    for (std::size_t k = 0; k < cut.neighbours().size(); ++k)
      for (std::size_t i = 0; i < cut.neighbours()[k].manifolds.size(); ++i)
        remote_[cut.neighbours()[k].manifolds[i]] = static_cast<std::int32_t>(k);
    waiting_.resize(cut.neighbours().size());
  }

  Colouring run() {
    for (std::uint32_t m = 0; m < contacts_.manifolds.size(); ++m) ready_.push_back(m);
    colour_ready();
    exchange_until_done();
    for (const std::int32_t c : result_.colour) result_.colours = std::max(result_.colours, static_cast<std::size_t>(c) + 1);
    return std::move(result_);
  }

 private:
  bool first_at_home_bodies(std::uint32_t m) const {
    const Manifold& manifold = contacts_.manifolds[m];
    for (const Slot s : {manifold.slot_a, manifold.slot_b})
      if (world_.is_home(s) && !lines_.first_in_line(s, m)) return false;
    return true;
  }

  void colour_ready() {
    while (!ready_.empty()) {
      const std::uint32_t m = ready_.back();
      ready_.pop_back();
      if (result_.colour[m] >= 0 || !first_at_home_bodies(m)) continue;
      if (remote_[m] < 0) {
        give_colour(m, {});
      } else if (!queued_[m]) {
        queued_[m] = 1;
        waiting_[static_cast<std::size_t>(remote_[m])].push_back(m);
      }
    }
  }

  void give_colour(std::uint32_t m, std::span<const std::int32_t> taken_elsewhere) {
    taken_.clear();
    const Manifold& manifold = contacts_.manifolds[m];
    for (const std::int32_t c : taken_elsewhere) taken_.add(c);
    for (const Slot s : {manifold.slot_a, manifold.slot_b})
      if (world_.is_home(s))
        for (const std::uint32_t other : lines_.served(s)) taken_.add(result_.colour[other]);
    result_.colour[m] = taken_.smallest_free();
    for (const Slot s : {manifold.slot_a, manifold.slot_b})
      if (world_.is_home(s))
        if (const std::int64_t next = lines_.advance(s); next >= 0) ready_.push_back(static_cast<std::uint32_t>(next));
  }

  // Message of one round to a neighbour: for each manifold newly first in line here, its place in the shared list, the number of
  // colours taken at this rank's body, and those colours.
  std::vector<std::int32_t> message(std::size_t k, std::vector<std::uint32_t>& told) {
    std::vector<std::int32_t> out;
    const auto& shared = cut_.neighbours()[k].manifolds;
    for (const std::uint32_t m : waiting_[k]) {
      const auto served = lines_.served(cut_.ends(m).home);
      out.push_back(static_cast<std::int32_t>(std::lower_bound(shared.begin(), shared.end(), m) - shared.begin()));
      out.push_back(static_cast<std::int32_t>(served.size()));
      for (const std::uint32_t other : served) out.push_back(result_.colour[other]);
      told.push_back(m);
    }
    waiting_[k].clear();
    return out;
  }

  // Rounds with the neighbours that still share an uncoloured manifold. Both sides of a pair count alike, so both stop together.
  void exchange_until_done() {
    const std::size_t n = cut_.neighbours().size();
    if (n == 0) return;
    const PhaseClock::Scope scope(cut_.clock(), Phase::halo);
    struct Offer {
      bool here = false, there = false;
      std::vector<std::int32_t> taken;
    };
    std::vector<std::vector<Offer>> offers(n);
    std::vector<std::size_t> left(n);
    for (std::size_t k = 0; k < n; ++k) offers[k].resize(left[k] = cut_.neighbours()[k].manifolds.size());
    for (;;) {
      std::vector<int> ranks;
      std::vector<std::size_t> who;
      std::vector<std::vector<std::int32_t>> out;
      std::vector<std::vector<std::uint32_t>> told(n);
      for (std::size_t k = 0; k < n; ++k)
        if (left[k] > 0) ranks.push_back(cut_.neighbours()[k].rank), who.push_back(k), out.push_back(message(k, told[k]));
      if (who.empty()) return;
      const auto in = exchange_with(cut_.comm(), ranks, out, tag_colours);
      for (std::size_t i = 0; i < who.size(); ++i) {
        const std::size_t k = who[i];
        const auto& shared = cut_.neighbours()[k].manifolds;
        for (const std::uint32_t m : told[k]) {
          offers[k][static_cast<std::size_t>(std::lower_bound(shared.begin(), shared.end(), m) - shared.begin())].here = true;
        }
        for (std::size_t at = 0; at < in[i].size();) {
          Offer& offer = offers[k][static_cast<std::size_t>(in[i][at])];
          const auto count = static_cast<std::size_t>(in[i][at + 1]);
          offer.there = true;
          offer.taken.assign(in[i].begin() + static_cast<std::ptrdiff_t>(at + 2),
                             in[i].begin() + static_cast<std::ptrdiff_t>(at + 2 + count));
          at += 2 + count;
        }
        for (std::size_t j = 0; j < shared.size(); ++j)
          if (offers[k][j].here && offers[k][j].there && result_.colour[shared[j]] < 0) {
            give_colour(shared[j], offers[k][j].taken);
            --left[k];
          }
      }
      colour_ready();
    }
  }

  const World& world_;
  const Contacts& contacts_;
  const Cut& cut_;
  Lines lines_;
  Taken taken_;
  Colouring result_;
  std::vector<std::int32_t> remote_;                 // neighbour of each manifold across the cut; -1: local
  std::vector<std::uint8_t> queued_;                 // those of them that were first in line here
  std::vector<std::uint32_t> ready_;                 // may be first in line
  std::vector<std::vector<std::uint32_t>> waiting_;  // first in line here, not yet told to the neighbour
};

}  // namespace

Colouring colour_manifolds(const World& world, const Contacts& contacts, const Cut& cut) {
  return Colourer(world, contacts, cut).run();
}

}  // namespace unibody
