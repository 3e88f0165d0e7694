#include "coarse/aggregates.hpp"

#include <algorithm>
#include <numeric>

namespace unibody {

namespace {

int longest_axis(std::span<const Vec3> points, std::span<const std::int32_t> part) {
  Vec3 least = points[static_cast<std::size_t>(part.front())], most = least;
  for (const std::int32_t k : part) {
    least = least.cwiseMin(points[static_cast<std::size_t>(k)]);
    most = most.cwiseMax(points[static_cast<std::size_t>(k)]);
  }
  int axis = 0;
  (most - least).maxCoeff(&axis);
  return axis;
}

// Numbers the points of a part, which is to become so many aggregates, from `first` on.
void split(std::span<const Vec3> points, std::span<std::int32_t> part, std::int32_t aggregates, std::int32_t first,
           std::vector<std::int32_t>& number) {
  if (aggregates <= 1) {
    for (const std::int32_t k : part) number[static_cast<std::size_t>(k)] = first;
    return;
  }
  const int axis = longest_axis(points, part);
  const std::int32_t below = aggregates / 2;
  const std::size_t middle = part.size() * static_cast<std::size_t>(below) / static_cast<std::size_t>(aggregates);
  std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(middle), part.end(),
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = points[static_cast<std::size_t>(a)][axis], y = points[static_cast<std::size_t>(b)][axis];
                     return x != y ? x < y : a < b;
                   });
  split(points, part.first(middle), below, first, number);
  split(points, part.subspan(middle), aggregates - below, first + below, number);
}

}  // namespace

std::vector<std::int32_t> aggregate_points(std::span<const Vec3> points, std::size_t most) {
  std::vector<std::int32_t> number(points.size()), all(points.size());
  if (points.empty()) return number;
  std::iota(all.begin(), all.end(), 0);
  split(points, all, static_cast<std::int32_t>((points.size() + most - 1) / most), 0, number);
  return number;
}

void Aggregates::add(Id first, std::span<const Vec3> points) {
  Run run{first, aggregate_points(points)};
  std::int32_t added = 0;
  for (std::int32_t& k : run.number) added = std::max(added, k + 1), k += count_;
  count_ += added;
  runs_.insert(std::ranges::upper_bound(runs_, first, {}, &Run::first), std::move(run));
}

std::int32_t Aggregates::of(Id body) const {
  const auto next = std::ranges::upper_bound(runs_, body, {}, &Run::first);
  if (next == runs_.begin()) return -1;
  const Run& run = *(next - 1);
  const auto k = static_cast<std::size_t>(body - run.first);
  return k < run.number.size() ? run.number[k] : -1;
}

std::size_t Aggregates::bytes() const {
  std::size_t bytes = 0;
  for (const Run& run : runs_) bytes += run.number.capacity() * sizeof(std::int32_t);
  return bytes;
}

}  // namespace unibody
