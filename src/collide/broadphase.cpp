#include "collide/broadphase.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace unibody {

namespace {

constexpr int few = 16;                     // a level of so few bodies is tested one by one
constexpr int bins = 16;                    // of the mantissa, to choose the cell size within an octave
constexpr int lowest = -60, octaves = 160;  // exponents of two that a size can have

double largest_extent(const Bounds& b) { return (b.upper - b.lower).maxCoeff(); }

bool usable(const Bounds& b) { return b.lower.allFinite() && b.upper.allFinite(); }

std::int64_t cell_coordinate(double x, double inverse) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x * inverse, -1e15, 1e15)));
}

std::size_t hash(std::int64_t y, std::int64_t z, std::int64_t level) {
  std::uint64_t h = static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15u;
  h ^= static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4fu + (h >> 29);
  h += static_cast<std::uint64_t>(level) * 0x27d4eb2f165667c5u;
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93u;
  return static_cast<std::size_t>(h ^ (h >> 32));
}

template <class Entry>
void test(const Entry& a, const Entry& b, Pairs& pairs) {
  const bool overlap = (a.lower.x() <= b.upper.x()) & (b.lower.x() <= a.upper.x()) & (a.lower.y() <= b.upper.y()) &
                       (b.lower.y() <= a.upper.y()) & (a.lower.z() <= b.upper.z()) & (b.lower.z() <= a.upper.z());
  if (overlap & (a.home | b.home) && a.filter.meets(b.filter))
    pairs.push_back({std::min(a.index, b.index), std::max(a.index, b.index)});
}

// std::sort has some overhead for the usual three or four.
template <class T, class Less>
void sort_few(T* begin, T* end, Less less) {
  if (end - begin > 24) return std::sort(begin, end, less);
  for (T* p = begin + 1; p < end; ++p) {
    const T value = *p;
    T* hole = p;
    for (; hole > begin && less(value, hole[-1]); --hole) *hole = hole[-1];
    *hole = value;
  }
}

// The 4 of the 8 neighbouring rows (y, z) that come after a row.
constexpr std::array<std::array<int, 2>, 4> forward{{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

}  // namespace

BroadPhase::BroadPhase(std::pmr::memory_resource* memory)
    : levels_(memory),
      level_of_(memory),
      row_of_(memory),
      rows_(memory),
      places_(memory),
      entries_(memory),
      few_(memory),
      table_(memory),
      starts_(memory),
      sorted_(memory) {}

void BroadPhase::find(std::span<const Bounds> bounds, std::span<const Role> roles, Pairs& pairs, std::span<const Filter> filters,
                      std::int32_t first) {
  choose_levels(bounds, roles);
  fill(bounds, roles, filters, first);
  for (const Row& row : rows_) {
    within_row(row, pairs);
    for (const auto& step : forward) {
      const std::int32_t other = find_row(row.y + step[0], row.z + step[1], row.level);
      if (other >= 0) between_rows(row, rows_[other], pairs);
    }
    with_coarser(row, pairs);
  }
}

// Cell sizes are f 2^k with one f in [1/2, 1) for all levels: the one that leaves the cells the least too large, by volume.
void BroadPhase::choose_levels(std::span<const Bounds> bounds, std::span<const Role> roles) {
  std::array<std::int32_t, bins> histogram{};
  const auto bin_of = [](double mantissa) { return std::clamp(static_cast<int>((mantissa - 0.5) * 2 * bins), 0, bins - 1); };
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    if (roles[i] == Role::absent || !usable(bounds[i])) continue;
    int exponent;
    ++histogram[bin_of(std::frexp(largest_extent(bounds[i]), &exponent))];
  }
  const auto top = [](int bin) { return 0.5 + (bin + 1) * 0.5 / bins; };
  double best = -1, factor = 1;
  for (int c = 0; c < bins; ++c) {
    double cost = 0;
    for (int b = 0; b < bins; ++b) {
      const double ratio = (b <= c ? 1 : 2) * top(c) / top(b);
      cost += histogram[b] * ratio * ratio * ratio;
    }
    if (best < 0 || cost < best) best = cost, factor = top(c);
  }

  const double fits = factor * (1 - 1e-9);  // centres are rounded: leave a hair
  std::array<std::int32_t, octaves> population{};
  level_of_.assign(bounds.size(), -1);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    if (roles[i] == Role::absent || !usable(bounds[i])) continue;
    int exponent;
    const double mantissa = std::frexp(largest_extent(bounds[i]), &exponent);
    const int octave = std::clamp(exponent + (mantissa > fits) - lowest, 0, octaves - 1);
    ++population[octave];
    level_of_[i] = octave;
  }
  std::array<std::int32_t, octaves> number{};
  levels_.clear();
  for (int o = 0; o < octaves; ++o) {
    if (population[o] == 0) continue;
    number[o] = static_cast<std::int32_t>(levels_.size());
    const double size = std::ldexp(factor, o + lowest);
    levels_.push_back({size, 1 / size, population[o]});
  }
  for (auto& level : level_of_)
    if (level >= 0) level = number[level];
}

void BroadPhase::fill(std::span<const Bounds> bounds, std::span<const Role> roles, std::span<const Filter> filters,
                      std::int32_t first) {
  std::size_t capacity = 64;
  while (capacity < 2 * bounds.size()) capacity *= 2;
  mask_ = capacity - 1;
  table_.assign(capacity, -1);
  rows_.clear();
  row_of_.assign(bounds.size(), -1);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    if (level_of_[i] < 0) continue;
    const double y = 0.5 * (bounds[i].lower.y() + bounds[i].upper.y()), z = 0.5 * (bounds[i].lower.z() + bounds[i].upper.z());
    const double inverse = levels_[level_of_[i]].inverse;
    row_of_[i] = find_or_add_row(cell_coordinate(y, inverse), cell_coordinate(z, inverse), level_of_[i]);
    ++rows_[row_of_[i]].last;
  }
  std::int32_t total = 0;
  for (Row& row : rows_) {
    const std::int32_t count = row.last;
    row.first = row.last = total;
    total += count;
  }
  places_.resize(total);
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (row_of_[i] >= 0) places_[rows_[row_of_[i]].last++] = {bounds[i].lower.x(), static_cast<std::int32_t>(i)};

  entries_.resize(total);
  if (few_.size() < levels_.size()) few_.resize(levels_.size());
  for (auto& list : few_) list.clear();
  for (const Row& row : rows_) {
    sort_few(places_.data() + row.first, places_.data() + row.last, [](const Place& a, const Place& b) { return a.x < b.x; });
    for (std::int32_t e = row.first; e < row.last; ++e) {
      const std::int32_t i = places_[e].index;
      entries_[e] = {bounds[i].lower, bounds[i].upper, i + first, filters.empty() ? Filter{} : filters[i],
                     roles[i] == Role::home};
      if (levels_[row.level].population <= few) few_[row.level].push_back(e);
    }
  }
}

std::int32_t BroadPhase::find_row(std::int64_t y, std::int64_t z, std::int32_t level) const {
  for (std::size_t h = hash(y, z, level) & mask_;; h = (h + 1) & mask_) {
    const std::int32_t r = table_[h];
    if (r < 0 || (rows_[r].y == y && rows_[r].z == z && rows_[r].level == level)) return r;
  }
}

std::int32_t BroadPhase::find_or_add_row(std::int64_t y, std::int64_t z, std::int32_t level) {
  for (std::size_t h = hash(y, z, level) & mask_;; h = (h + 1) & mask_) {
    std::int32_t& r = table_[h];
    if (r < 0) {
      r = static_cast<std::int32_t>(rows_.size());
      rows_.push_back({y, z, level, 0, 0});
      return r;
    }
    if (rows_[r].y == y && rows_[r].z == z && rows_[r].level == level) return r;
  }
}

void BroadPhase::within_row(const Row& row, Pairs& pairs) const {
  const Entry* end = entries_.data() + row.last;
  for (const Entry* a = entries_.data() + row.first; a < end; ++a)
    for (const Entry* b = a + 1; b < end && b->lower.x() <= a->upper.x(); ++b) test(*a, *b, pairs);
}

// No body of a level is longer than its cells, so what begins more than a cell before a body ends before it.
void BroadPhase::between_rows(const Row& a, const Row& b, Pairs& pairs) const {
  const double size = levels_[a.level].size;
  const Entry *p = entries_.data() + b.first, *end = entries_.data() + b.last;
  for (std::int32_t i = a.first; i < a.last; ++i) {
    const Entry& entry = entries_[i];
    while (p < end && p->lower.x() < entry.lower.x() - size) ++p;
    for (const Entry* q = p; q < end && q->lower.x() <= entry.upper.x(); ++q) test(entry, *q, pairs);
  }
}

// A coarser level's bodies reach at most half a cell from their centres, so those that can touch have their centres within
// the bounds grown by that (and by a hair: the centres are rounded).
void BroadPhase::with_coarser(const Row& row, Pairs& pairs) const {
  for (std::size_t l = row.level + 1; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    for (std::int32_t i = row.first; i < row.last; ++i) {
      const Entry& entry = entries_[i];
      if (level.population <= few) {
        for (const std::int32_t k : few_[l]) test(entry, entries_[k], pairs);
        continue;
      }
      const double grow = 0.500001 * level.size;
      const std::int64_t y_end = cell_coordinate(entry.upper.y() + grow, level.inverse);
      const std::int64_t z_end = cell_coordinate(entry.upper.z() + grow, level.inverse);
      for (std::int64_t z = cell_coordinate(entry.lower.z() - grow, level.inverse); z <= z_end; ++z)
        for (std::int64_t y = cell_coordinate(entry.lower.y() - grow, level.inverse); y <= y_end; ++y) {
          const std::int32_t other = find_row(y, z, static_cast<std::int32_t>(l));
          if (other < 0) continue;
          const Entry *begin = entries_.data() + rows_[other].first, *end = entries_.data() + rows_[other].last;
          const double from = entry.lower.x() - level.size;
          begin = std::partition_point(begin, end, [&](const Entry& e) { return e.lower.x() < from; });
          for (; begin < end && begin->lower.x() <= entry.upper.x(); ++begin) test(entry, *begin, pairs);
        }
    }
  }
}

std::span<const IndexPair> BroadPhase::sort(const Pairs& pairs, std::size_t count) {
  starts_.assign(count + 1, 0);
  for (const IndexPair& p : pairs) ++starts_[p.first + 1];
  for (std::size_t i = 0; i < count; ++i) starts_[i + 1] += starts_[i];
  sorted_.resize(pairs.size());
  for (const IndexPair& p : pairs) sorted_[starts_[p.first]++] = p;
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t end = starts_[i];  // the scatter has moved each start to its end
    sort_few(sorted_.data() + begin, sorted_.data() + end,
             [](const IndexPair& a, const IndexPair& b) { return a.second < b.second; });
    begin = end;
  }
  return sorted_;
}

}  // namespace unibody
