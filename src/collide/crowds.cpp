#include "collide/crowds.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "collide/periodic_pairs.hpp"
#include "world/shapes.hpp"

namespace unibody {

namespace {

std::size_t hash(const CrowdCell& c) {
  std::uint64_t h = static_cast<std::uint64_t>(c.x) * 0x9e3779b97f4a7c15u;
  h = (h ^ h >> 32) + static_cast<std::uint64_t>(c.y) * 0xc2b2ae3d27d4eb4fu;
  h = (h ^ h >> 29) + static_cast<std::uint64_t>(c.z) * 0x165667b19e3779f9u + static_cast<std::uint64_t>(c.size);
  h = (h ^ h >> 32) * 0xd6e8feb86659fd93u;
  return static_cast<std::size_t>(h ^ h >> 32);
}

// Cells by slot, of bodies that share a bucket of a table with too many others to rule a crowd out. In a scene without crowds
// there are none, at the price of a hash a body.
std::vector<std::pair<CrowdCell, Slot>> suspects(const World& world) {
  const std::size_t moving = world.first_static();
  std::size_t buckets = 64;
  while (buckets < 4 * moving) buckets *= 2;
  std::vector<std::uint8_t> filled(buckets, 0);
  constexpr std::uint8_t full = 255;
  bool any = false;
  const auto bucket = [&](std::size_t i) {
    return hash(crowd_cell(world.properties[i], world.period.wrapped(world.position[i]))) & (buckets - 1);
  };
  for (std::size_t i = 0; i < moving; ++i) {
    if (!may_crowd(world.properties[i])) continue;
    std::uint8_t& count = filled[bucket(i)];
    count = static_cast<std::uint8_t>(count + (count < full));
    any |= count > most_of_no_crowd;
  }
  std::vector<std::pair<CrowdCell, Slot>> found;
  for (std::size_t i = 0; i < moving && any; ++i)
    if (may_crowd(world.properties[i]) && filled[bucket(i)] > most_of_no_crowd)
      found.emplace_back(crowd_cell(world.properties[i], world.period.wrapped(world.position[i])), static_cast<Slot>(i));
  return found;
}

}  // namespace

bool may_crowd(const BodyProperties& body) {
  return body.is_dynamic() && body.group < 0 && body.shape.kind != ShapeKind::plane && !is_composite(body.shape.kind);
}

CrowdCell crowd_cell(const BodyProperties& body, const Vec3& position) {
  constexpr int dropped = 50;  // bits: the exponent and two bits of the mantissa stay
  const std::uint64_t level = std::bit_cast<std::uint64_t>(smallest_size(body.shape)) >> dropped;
  const double edge = 0.5 * std::bit_cast<double>(level << dropped);
  const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor(std::clamp(x / edge, -1e15, 1e15))); };
  return {static_cast<std::int64_t>(level), cell(position.x()), cell(position.y()), cell(position.z())};
}

std::vector<std::int32_t> crowd_ranks(const World& world) {
  auto found = suspects(world);
  std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) {
    return std::tuple(a.first, world.id[static_cast<std::size_t>(a.second)]) <
           std::tuple(b.first, world.id[static_cast<std::size_t>(b.second)]);
  });
  std::vector<std::int32_t> ranks;
  for (std::size_t begin = 0, end = 0; begin < found.size(); begin = end) {
    while (end < found.size() && found[end].first == found[begin].first) ++end;
    if (end - begin <= most_of_no_crowd) continue;
    for (std::size_t k = begin; k < end; ++k) {
      if (!world.is_home(found[k].second)) continue;
      if (ranks.empty()) ranks.assign(world.size(), -1);
      ranks[static_cast<std::size_t>(found[k].second)] = static_cast<std::int32_t>(k - begin);
    }
  }
  return ranks;
}

Crowds::Crowds(std::vector<Member> members) : members_(std::move(members)) {
  std::sort(members_.begin(), members_.end(),
            [](const Member& a, const Member& b) { return std::tuple(a.cell, a.rank) < std::tuple(b.cell, b.rank); });
  for (std::size_t k = 0; k < members_.size(); ++k)
    if (k == 0 || members_[k].cell != members_[k - 1].cell) first_.push_back(k);
  first_.push_back(members_.size());
}

void Crowds::stand_for(std::span<Bounds> bounds, std::span<Role> roles, std::span<Filter> filters) const {
  for (std::size_t c = 0; c < count(); ++c) {
    const auto all = members(c);
    Bounds whole = bounds[static_cast<std::size_t>(all[0].index)];
    bool home = false;
    for (const Member& m : all) {
      const auto i = static_cast<std::size_t>(m.index);
      whole.lower = whole.lower.cwiseMin(bounds[i].lower), whole.upper = whole.upper.cwiseMax(bounds[i].upper);
      home |= roles[i] == Role::home;
      roles[i] = Role::absent;
    }
    const auto i = static_cast<std::size_t>(all[0].index);
    bounds[i] = whole, roles[i] = home ? Role::home : Role::other;
    filters[i] = {-1, 0xff, 0xff};
  }
}

void Crowds::expand(Pairs& pairs, std::span<const Bounds> bounds, std::span<const Role> roles, std::span<const Filter> filters,
                    const Period& period) const {
  const auto meet = [&](std::int32_t a, std::int32_t b) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    const bool overlap = overlap_in_images(bounds[i], bounds[j], period);
    if (overlap && (roles[i] == Role::home || roles[j] == Role::home) && filters[i].meets(filters[j]))
      pairs.push_back({std::min(a, b), std::max(a, b)});
  };
  std::vector<std::int32_t> crowd_of(bounds.size(), -1);  // of those that stand for one
  for (std::size_t c = 0; c < count(); ++c)
    crowd_of[static_cast<std::size_t>(members(c)[0].index)] = static_cast<std::int32_t>(c);
  const std::vector<IndexPair> found(pairs.begin(), pairs.end());
  pairs.clear();
  const auto crowd = [&](std::int32_t i) {
    return static_cast<std::size_t>(i) < crowd_of.size() ? crowd_of[static_cast<std::size_t>(i)] : -1;
  };
  for (const IndexPair& pair : found) {
    const std::int32_t a = crowd(pair.first), b = crowd(pair.second);
    if (a < 0 && b < 0) {
      pairs.push_back(pair);
    } else if (a >= 0 && b >= 0) {
      const auto one = members(static_cast<std::size_t>(a)), other = members(static_cast<std::size_t>(b));
      for (std::size_t i = 0, j = 0; i < one.size() && j < other.size();) {
        if (one[i].rank == other[j].rank) meet(one[i].index, other[j].index);
        one[i].rank <= other[j].rank ? ++i : ++j;
      }
    } else {
      const std::int32_t alone = a < 0 ? pair.first : pair.second;
      for (const Member& m : members(static_cast<std::size_t>(std::max(a, b)))) meet(m.index, alone);
    }
  }
  for (std::size_t c = 0; c < count(); ++c) {
    const auto all = members(c);
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i + 1; j < all.size() && all[j].rank - all[i].rank <= reach_in_crowd; ++j)
        meet(all[i].index, all[j].index);
  }
}

}  // namespace unibody
