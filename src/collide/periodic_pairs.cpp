#include "collide/periodic_pairs.hpp"

#include <algorithm>

namespace unibody {

namespace {

bool are_finite(const Bounds& b) { return b.lower.allFinite() && b.upper.allFinite(); }

Bounds moved(const Bounds& b, const Vec3& way) { return {b.lower + way, b.upper + way}; }

}  // namespace

Copies::Copies(std::span<const Bounds> whole, const Period& period) {
  bounds.reserve(whole.size()), of.reserve(whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const auto add = [&](const Bounds& copy) { bounds.push_back(copy), of.push_back(static_cast<std::int32_t>(i)); };
    if (!period.any() || !are_finite(whole[i])) {
      add(whole[i]);
      continue;
    }
    const Image first = period.image_of(whole[i].lower);
    Image last = period.image_of(whole[i].upper);
    for (std::size_t k = 0; k < 3; ++k) last[k] = std::min(last[k], first[k] + 1);  // none is longer than the cell
    for (Image image = first; image[0] <= last[0]; ++image[0])
      for (image[1] = first[1]; image[1] <= last[1]; ++image[1])
        for (image[2] = first[2]; image[2] <= last[2]; ++image[2]) add(moved(whole[i], -period.shift(image)));
  }
}

void find_periodic(BroadPhase& broad_phase, const Period& period, std::span<const Bounds> bounds, std::span<const Role> roles,
                   Pairs& pairs, std::span<const Filter> filters) {
  const Copies copies(bounds, period);
  std::vector<Role> roles_of_copies;
  std::vector<Filter> filters_of_copies;
  for (const std::int32_t i : copies.of) {
    roles_of_copies.push_back(roles[static_cast<std::size_t>(i)]);
    if (!filters.empty()) filters_of_copies.push_back(filters[static_cast<std::size_t>(i)]);
  }
  Pairs found;
  broad_phase.find(copies.bounds, roles_of_copies, found, filters_of_copies);
  std::vector<std::pair<std::int32_t, std::int32_t>> of_bodies;
  for (const IndexPair& pair : found) {
    const std::int32_t a = copies.of[static_cast<std::size_t>(pair.first)], b = copies.of[static_cast<std::size_t>(pair.second)];
    if (a != b) of_bodies.emplace_back(std::minmax(a, b));
  }
  std::ranges::sort(of_bodies);
  const auto repeated = std::ranges::unique(of_bodies);
  of_bodies.erase(repeated.begin(), repeated.end());
  for (const auto& [a, b] : of_bodies) pairs.push_back({a, b});
}

bool overlap_in_images(const Bounds& a, const Bounds& b, const Period& period) {
  const Image image = period.nearest(0.5 * (a.lower + a.upper), 0.5 * (b.lower + b.upper));
  const Bounds near = moved(b, period.shift(image));
  return (a.lower.array() <= near.upper.array()).all() && (near.lower.array() <= a.upper.array()).all();
}

}  // namespace unibody
