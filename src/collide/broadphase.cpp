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

std::size_t hash(std::int64_t x, std::int64_t y, std::int64_t z, std::int64_t level) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u;
  h ^= static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fu + (h >> 29);
  h ^= static_cast<std::uint64_t>(z) * 0x165667b19e3779f9u + (h << 13);
  h += static_cast<std::uint64_t>(level) * 0x27d4eb2f165667c5u;
  h ^= h >> 32;
  h *= 0xd6e8feb86659fd93u;
  return static_cast<std::size_t>(h ^ (h >> 32));
}

template <class Entry>
bool overlap(const Entry& a, const Entry& b) {
  return (a.lower.x() <= b.upper.x()) & (b.lower.x() <= a.upper.x()) & (a.lower.y() <= b.upper.y()) &
         (b.lower.y() <= a.upper.y()) & (a.lower.z() <= b.upper.z()) & (b.lower.z() <= a.upper.z());
}

template <class Entry>
void test(const Entry& a, const Entry& b, std::vector<IndexPair>& pairs) {
  if (overlap(a, b) && (a.home || b.home)) pairs.push_back({std::min(a.index, b.index), std::max(a.index, b.index)});
}

// The 13 of the 26 neighbours that come after the cell itself.
constexpr std::array<std::array<int, 3>, 13> forward{{{1, 0, 0},
                                                      {-1, 1, 0},
                                                      {0, 1, 0},
                                                      {1, 1, 0},
                                                      {-1, -1, 1},
                                                      {0, -1, 1},
                                                      {1, -1, 1},
                                                      {-1, 0, 1},
                                                      {0, 0, 1},
                                                      {1, 0, 1},
                                                      {-1, 1, 1},
                                                      {0, 1, 1},
                                                      {1, 1, 1}}};

}  // namespace

void BroadPhase::find(const std::vector<Bounds>& bounds, const std::vector<Role>& roles, std::vector<IndexPair>& pairs) {
  choose_levels(bounds, roles);
  fill(bounds, roles);
  for (const Cell& cell : cells_) {
    within_cell(cell, pairs);
    for (const auto& step : forward) {
      const std::int32_t other = find_cell(cell.x + step[0], cell.y + step[1], cell.z + step[2], cell.level);
      if (other >= 0) between_cells(cell, cells_[other], pairs);
    }
    with_coarser(cell, pairs);
  }
}

// Cell sizes are f 2^k with one f in [1/2, 1) for all levels: the one that leaves the cells the least too large, by volume.
void BroadPhase::choose_levels(const std::vector<Bounds>& bounds, const std::vector<Role>& roles) {
  std::array<std::int32_t, bins> histogram{};
  const auto bin_of = [](double mantissa) { return std::min(static_cast<int>((mantissa - 0.5) * 2 * bins), bins - 1); };
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
  std::int32_t offset = 0;
  for (int o = 0; o < octaves; ++o) {
    if (population[o] == 0) continue;
    number[o] = static_cast<std::int32_t>(levels_.size());
    const double size = std::ldexp(factor, o + lowest);
    levels_.push_back({size, 1 / size, population[o], offset});
    if (population[o] <= few) offset += population[o];
  }
  by_level_.resize(offset);
  for (auto& level : level_of_)
    if (level >= 0) level = number[level];
}

void BroadPhase::fill(const std::vector<Bounds>& bounds, const std::vector<Role>& roles) {
  std::size_t capacity = 64;
  while (capacity < 2 * bounds.size()) capacity *= 2;
  mask_ = capacity - 1;
  table_.assign(capacity, -1);
  cells_.clear();
  cell_of_.assign(bounds.size(), -1);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    if (level_of_[i] < 0) continue;
    const Vec3 centre = 0.5 * (bounds[i].lower + bounds[i].upper);
    const double inverse = levels_[level_of_[i]].inverse;
    const std::int32_t cell = find_or_add_cell(cell_coordinate(centre.x(), inverse), cell_coordinate(centre.y(), inverse),
                                               cell_coordinate(centre.z(), inverse), level_of_[i]);
    cell_of_[i] = cell;
    ++cells_[cell].count;
  }
  std::int32_t total = 0;
  for (Cell& cell : cells_) cell.first = total, total += cell.count, cell.count = 0;
  entries_.resize(total);
  std::array<std::int32_t, octaves> filled{};
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    if (cell_of_[i] < 0) continue;
    Cell& cell = cells_[cell_of_[i]];
    const std::int32_t place = cell.first + cell.count++;
    entries_[place] = {bounds[i].lower, bounds[i].upper, static_cast<std::int32_t>(i), roles[i] == Role::home};
    const Level& level = levels_[level_of_[i]];
    if (level.population <= few) by_level_[level.offset + filled[level_of_[i]]++] = place;
  }
}

std::int32_t BroadPhase::find_cell(std::int64_t x, std::int64_t y, std::int64_t z, std::int32_t level) const {
  for (std::size_t h = hash(x, y, z, level) & mask_;; h = (h + 1) & mask_) {
    const std::int32_t c = table_[h];
    if (c < 0) return -1;
    const Cell& cell = cells_[c];
    if (cell.x == x && cell.y == y && cell.z == z && cell.level == level) return c;
  }
}

std::int32_t BroadPhase::find_or_add_cell(std::int64_t x, std::int64_t y, std::int64_t z, std::int32_t level) {
  for (std::size_t h = hash(x, y, z, level) & mask_;; h = (h + 1) & mask_) {
    const std::int32_t c = table_[h];
    if (c < 0) {
      table_[h] = static_cast<std::int32_t>(cells_.size());
      cells_.push_back({x, y, z, level, 0, 0});
      return table_[h];
    }
    const Cell& cell = cells_[c];
    if (cell.x == x && cell.y == y && cell.z == z && cell.level == level) return c;
  }
}

void BroadPhase::within_cell(const Cell& cell, std::vector<IndexPair>& pairs) const {
  const Entry* entries = entries_.data() + cell.first;
  for (std::int32_t i = 0; i < cell.count; ++i)
    for (std::int32_t j = i + 1; j < cell.count; ++j) test(entries[i], entries[j], pairs);
}

void BroadPhase::between_cells(const Cell& a, const Cell& b, std::vector<IndexPair>& pairs) const {
  const Entry* of_b = entries_.data() + b.first;
  for (std::int32_t i = a.first; i < a.first + a.count; ++i)
    for (std::int32_t j = 0; j < b.count; ++j) test(entries_[i], of_b[j], pairs);
}

// A coarser level's bodies reach at most half a cell from their centres, so those that can touch have their centres within
// the bounds grown by that.
void BroadPhase::with_coarser(const Cell& cell, std::vector<IndexPair>& pairs) const {
  for (std::size_t l = cell.level + 1; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    for (std::int32_t i = cell.first; i < cell.first + cell.count; ++i) {
      const Entry& entry = entries_[i];
      if (level.population <= few) {
        for (std::int32_t k = 0; k < level.population; ++k) test(entry, entries_[by_level_[level.offset + k]], pairs);
        continue;
      }
      std::array<std::int64_t, 3> from, to;
      for (int d = 0; d < 3; ++d) {
        // a hair more than half a cell: the centre of bounds is rounded
        from[d] = cell_coordinate(entry.lower[d] - 0.500001 * level.size, level.inverse);
        to[d] = cell_coordinate(entry.upper[d] + 0.500001 * level.size, level.inverse);
      }
      for (std::int64_t z = from[2]; z <= to[2]; ++z)
        for (std::int64_t y = from[1]; y <= to[1]; ++y)
          for (std::int64_t x = from[0]; x <= to[0]; ++x) {
            const std::int32_t other = find_cell(x, y, z, static_cast<std::int32_t>(l));
            if (other < 0) continue;
            const Cell& coarse = cells_[other];
            for (std::int32_t k = coarse.first; k < coarse.first + coarse.count; ++k) test(entry, entries_[k], pairs);
          }
    }
  }
}

void BroadPhase::sort(std::vector<IndexPair>& pairs, std::size_t count) {
  starts_.assign(count + 1, 0);
  for (const IndexPair& p : pairs) ++starts_[p.first + 1];
  for (std::size_t i = 0; i < count; ++i) starts_[i + 1] += starts_[i];
  scratch_.resize(pairs.size());
  for (const IndexPair& p : pairs) scratch_[starts_[p.first]++] = p;
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t end = starts_[i];  // the scatter has moved each start to its end
    std::sort(scratch_.begin() + begin, scratch_.begin() + end,
              [](const IndexPair& a, const IndexPair& b) { return a.second < b.second; });
    begin = end;
  }
  pairs.swap(scratch_);
}

}  // namespace unibody
