#include "partition/neighbours.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "core/hash.hpp"

namespace unibody {

namespace {

constexpr int tag_blocks = 101, tag_sharers = 102, tag_occupied = 103;
constexpr std::int64_t cells_of_a_large_body = 64;  // beyond this a body is compared by its bounds rather than by its cells
constexpr std::int64_t cells_to_look_through =
    4096;                                           // of a large body; one with more is a guest of all that share a block with it
constexpr std::int64_t blocks_of_a_huge_body = 64;  // beyond this it is told to all rather than to the directory

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

// A key wraps round after 2^21 cells an axis: two far cells may share a key, which costs a needless guest and nothing else.
using Key = std::int64_t;
Key key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::int64_t mask = (1 << 21) - 1;
  return (x & mask) << 42 | (y & mask) << 21 | (z & mask);
}

struct Range {
  std::int64_t lower[3], upper[3];

  std::int64_t count() const {
    double n = 1;
    for (int i = 0; i < 3; ++i) n *= static_cast<double>(upper[i] - lower[i] + 1);
    return n > 1e9 ? 1000000000 : static_cast<std::int64_t>(n);
  }
  template <typename F>
  void for_each(F&& f) const {
    for (auto x = lower[0]; x <= upper[0]; ++x)
      for (auto y = lower[1]; y <= upper[1]; ++y)
        for (auto z = lower[2]; z <= upper[2]; ++z) f(x, y, z);
  }
};

class Grid {
 public:
  explicit Grid(const CellSizes& sizes) : sizes_(sizes) {}

  Range cells_of(const Bounds& b) const {
    Range r{};
    for (int i = 0; i < 3; ++i) {
      r.lower[i] = static_cast<std::int64_t>(std::floor(std::clamp(b.lower[i] / sizes_.cell, -1e15, 1e15)));
      r.upper[i] = static_cast<std::int64_t>(std::floor(std::clamp(b.upper[i] / sizes_.cell, -1e15, 1e15)));
    }
    return r;
  }
  Range blocks_of(const Bounds& b) const {
    Range r = cells_of(b);
    for (int i = 0; i < 3; ++i) r.lower[i] = block(r.lower[i]), r.upper[i] = block(r.upper[i]);
    return r;
  }
  // The part of bounds that lies in a cell, or somewhat more where rounding cuts a cell short.
  Bounds within_cell(const Bounds& b, std::int64_t x, std::int64_t y, std::int64_t z) const {
    const Vec3 index(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
    constexpr double more = 1e-6;  // of a cell
    return {b.lower.cwiseMax((sizes_.cell * (index.array() - more)).matrix()),
            b.upper.cwiseMin((sizes_.cell * (index.array() + 1 + more)).matrix())};
  }
  Key block_of_cell(std::int64_t x, std::int64_t y, std::int64_t z) const { return key_of(block(x), block(y), block(z)); }

 private:
  std::int64_t block(std::int64_t cell) const {
    return cell >= 0 ? cell / sizes_.cells_a_side : -((-cell - 1) / sizes_.cells_a_side) - 1;
  }
  CellSizes sizes_;
};

template <typename T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

// By block: the other ranks that have bodies in it. Blocks that no other rank has bodies in are not listed.
using Sharers = std::unordered_map<Key, std::vector<int>>;

// Each block has a keeper, which hears of all that touch it, and tells each of the others.
Sharers sharers_of(MPI_Comm comm, const std::vector<Key>& blocks) {
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  ListsByRank<Key> touched;
  for (const Key key : blocks)
    touched[static_cast<int>(Hash().add(key).value() % static_cast<std::uint64_t>(ranks))].push_back(key);
  std::vector<std::pair<Key, int>> kept;
  for (const auto& [rank, keys] : exchange_lists(comm, touched, tag_blocks))
    for (const Key key : keys) kept.emplace_back(key, rank);
  std::sort(kept.begin(), kept.end());
  ListsByRank<std::pair<Key, int>> told;
  for (auto first = kept.begin(); first != kept.end();) {
    const auto end = std::find_if(first, kept.end(), [&](const auto& entry) { return entry.first != first->first; });
    for (auto one = first; one != end; ++one)
      for (auto other = first; other != end; ++other)
        if (one != other) told[one->second].emplace_back(first->first, other->second);
    first = end;
  }
  Sharers sharers;
  for (const auto& [keeper, list] : exchange_lists(comm, told, tag_sharers))
    for (const auto& [key, rank] : list) sharers[key].push_back(rank);
  return sharers;
}

struct HugeBody {
  Bounds bounds;
  int rank;
  std::int32_t place;  // of its bounds, on that rank
};

// The part of a cell that bodies fill, as far as their bounds tell.
struct Filled {
  Key cell;
  Bounds part;
};

// Sorted by cell; parts of the same cell made one.
void merge(std::vector<Filled>& list) {
  std::ranges::sort(list, {}, &Filled::cell);
  std::size_t n = 0;
  for (const Filled& f : list)
    if (n > 0 && list[n - 1].cell == f.cell)
      list[n - 1].part = {list[n - 1].part.lower.cwiseMin(f.part.lower), list[n - 1].part.upper.cwiseMax(f.part.upper)};
    else
      list[n++] = f;
  list.resize(n);
}

// What a rank tells a neighbour: which parts of the cells of shared blocks its small bodies fill, the bounds of its large bodies
// in these blocks, and which huge bodies of the neighbour its own bodies overlap. All this is sent as one list of 64-bit words.
struct Occupancy {
  std::vector<Filled> cells;  // as merge() leaves them
  std::vector<Bounds> large;
  std::vector<std::int32_t> touched;

  bool meets(const Bounds& b, const Range& range) const {
    if (std::ranges::any_of(large, [&](const Bounds& l) { return overlap(l, b); })) return true;
    bool found = false;
    range.for_each([&](auto x, auto y, auto z) {
      if (found) return;
      const auto filled = std::ranges::lower_bound(cells, key_of(x, y, z), {}, &Filled::cell);
      found = filled != cells.end() && filled->cell == key_of(x, y, z) && overlap(filled->part, b);
    });
    return found;
  }
  std::vector<std::int64_t> words() const;
  static Occupancy of(std::span<const std::int64_t> words);
};

constexpr std::size_t words_of_bounds = 6;

void write(const Bounds& b, std::vector<std::int64_t>& words) {
  for (const Vec3& corner : {b.lower, b.upper})
    for (int k = 0; k < 3; ++k) words.push_back(std::bit_cast<std::int64_t>(corner[k]));
}

Bounds read_bounds(std::span<const std::int64_t> words) {
  const auto number = [&](std::size_t k) { return std::bit_cast<double>(words[k]); };
  return {{number(0), number(1), number(2)}, {number(3), number(4), number(5)}};
}

std::vector<std::int64_t> Occupancy::words() const {
  std::vector<std::int64_t> list{static_cast<std::int64_t>(cells.size()), static_cast<std::int64_t>(large.size())};
  for (const Filled& f : cells) list.push_back(f.cell), write(f.part, list);
  for (const Bounds& b : large) write(b, list);
  list.insert(list.end(), touched.begin(), touched.end());
  return list;
}

Occupancy Occupancy::of(std::span<const std::int64_t> words) {
  Occupancy o;
  const std::int64_t cell_count = words[0], large_count = words[1];
  words = words.subspan(2);
  for (std::int64_t i = 0; i < cell_count; ++i, words = words.subspan(1 + words_of_bounds))
    o.cells.push_back({words[0], read_bounds(words.subspan(1))});
  for (std::int64_t i = 0; i < large_count; ++i, words = words.subspan(words_of_bounds)) o.large.push_back(read_bounds(words));
  for (const std::int64_t word : words) o.touched.push_back(static_cast<std::int32_t>(word));
  return o;
}

class Search {
 public:
  Search(MPI_Comm comm, std::span<const Bounds> bounds, std::span<const std::int32_t> of, const CellSizes& sizes)
      : comm_(comm), bounds_(bounds), of_(of), grid_(sizes) {
    check_mpi(MPI_Comm_rank(comm, &rank_));
  }

  ListsByRank<std::int32_t> find() {
    find_blocks();
    meet_huge();
    occupy();
    ListsByRank<std::int64_t> words;
    for (const auto& [rank, mine] : to_) words[rank] = mine.words();
    for (const auto& [rank, list] : exchange_lists(comm_, words, tag_occupied)) compare(rank, Occupancy::of(list));
    std::erase_if(near_, [](const auto& of_rank) { return of_rank.second.empty(); });
    for (auto& [rank, bodies] : near_) sort_unique(bodies);
    return std::move(near_);
  }

 private:
  void find_blocks() {
    std::vector<Key> blocks;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      const Range range = grid_.blocks_of(bounds_[i]);
      if (range.count() > blocks_of_a_huge_body)
        huge_.push_back({bounds_[i], rank_, static_cast<std::int32_t>(i)});
      else
        range.for_each([&](auto x, auto y, auto z) { blocks.push_back(key_of(x, y, z)); });
    }
    sort_unique(blocks);
    sharers_ = sharers_of(comm_, blocks);
  }

  void meet_huge() {
    for (const HugeBody& huge : all_of_ranks<HugeBody>(comm_, huge_))
      for (std::size_t i = 0; i < bounds_.size() && huge.rank != rank_; ++i)
        if (overlap(bounds_[i], huge.bounds)) {
          near_[huge.rank].push_back(of_[i]);
          to_[huge.rank].touched.push_back(huge.place);
        }
    for (auto& [rank, occupancy] : to_) sort_unique(occupancy.touched);
  }

  // The ranks with which the blocks of these bounds are shared, each once.
  std::vector<int> sharing(const Bounds& b) const {
    const Range range = grid_.blocks_of(b);
    std::vector<int> ranks;
    if (range.count() > blocks_of_a_huge_body) return ranks;
    range.for_each([&](auto x, auto y, auto z) {
      const auto found = sharers_.find(key_of(x, y, z));
      if (found != sharers_.end()) ranks.insert(ranks.end(), found->second.begin(), found->second.end());
    });
    sort_unique(ranks);
    return ranks;
  }

  void occupy() {
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      const std::vector<int> ranks = sharing(bounds_[i]);
      if (ranks.empty()) continue;
      const Range cells = grid_.cells_of(bounds_[i]);
      for (const int rank : ranks) shared_with_[rank].push_back(i);
      if (cells.count() > cells_of_a_large_body)
        for (const int rank : ranks) to_[rank].large.push_back(bounds_[i]);
      else
        cells.for_each([&](auto x, auto y, auto z) {
          const auto found = sharers_.find(grid_.block_of_cell(x, y, z));
          if (found == sharers_.end()) return;
          const Filled filled{key_of(x, y, z), grid_.within_cell(bounds_[i], x, y, z)};
          for (const int rank : found->second) to_[rank].cells.push_back(filled);
        });
    }
    for (auto& [rank, occupancy] : to_) merge(occupancy.cells);
  }

  void compare(int rank, const Occupancy& theirs) {
    std::vector<std::int32_t>& near = near_[rank];
    for (const std::int32_t place : theirs.touched) near.push_back(of_[static_cast<std::size_t>(place)]);
    for (const std::size_t i : shared_with_[rank]) {
      const Range cells = grid_.cells_of(bounds_[i]);
      if (cells.count() > cells_to_look_through || theirs.meets(bounds_[i], cells)) near.push_back(of_[i]);
    }
  }

  MPI_Comm comm_;
  int rank_ = 0;
  std::span<const Bounds> bounds_;
  std::span<const std::int32_t> of_;
  Grid grid_;
  Sharers sharers_;
  std::vector<HugeBody> huge_;
  std::map<int, std::vector<std::size_t>> shared_with_;  // the places of bounds in blocks that are shared with a rank
  std::map<int, Occupancy> to_;
  ListsByRank<std::int32_t> near_;
};

}  // namespace

ListsByRank<std::int32_t> bodies_near_ranks(MPI_Comm comm, std::span<const Bounds> bounds, std::span<const std::int32_t> of,
                                            const CellSizes& sizes) {
  return Search(comm, bounds, of, sizes).find();
}

}  // namespace unibody
