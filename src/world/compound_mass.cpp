#include "world/compound_mass.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

// The volume of a part that lies in earlier parts too, which counts once: its moments about the part's centre.
struct Overlapped {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  void add(double cell, const Vec3& at) { volume += cell, first += cell * at, second += cell * at * at.transpose(); }
};

Mat3 turn_of(const Compound::Part& part) { return (part.turn * frame_of(part.shape)).toRotationMatrix(); }

bool is_inside(const Compound::Part& part, const Mat3& turn, const Vec3& at) {
  return type_of(part.shape.kind).convex->contains(part.shape, turn.transpose() * (at - part.place));
}

// Cells are along the axes of parts[k].
Overlapped find_overlap(std::span<const Compound::Part> parts, std::size_t k) {
  constexpr int cells = 100;  // along each side
  const Compound::Part& part = parts[k];
  const Mat3 own = turn_of(part);
  const Vec3 extent = bounding_half_extents(part.shape, Mat3::Identity());
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  std::vector<std::size_t> others;
  for (std::size_t j = 0; j < k; ++j) {
    const Vec3 centre = own.transpose() * (parts[j].place - part.place);
    const Vec3 half = bounding_half_extents(parts[j].shape, Mat3(own.transpose() * turn_of(parts[j])));
    const Vec3 from = (-extent).cwiseMax(centre - half), to = extent.cwiseMin(centre + half);
    if (!(from.array() < to.array()).all()) continue;
    low = low.cwiseMin(from), high = high.cwiseMax(to), others.push_back(j);
  }
  if (others.empty()) return {};
  const Vec3 cell = (high - low) / cells;
  Overlapped overlap;
  for (int i = 0; i < cells * cells * cells; ++i) {
    const Vec3 number(i % cells, i / cells % cells, i / (cells * cells));
    const Vec3 at = own * (low + cell.cwiseProduct(number + Vec3::Constant(0.5)));
    const auto holds = [&](std::size_t j) { return is_inside(parts[j], turn_of(parts[j]), part.place + at); };
    if (is_inside(part, own, part.place + at) && std::ranges::any_of(others, holds)) overlap.add(cell.prod(), at);
  }
  return overlap;
}

}  // namespace

CompoundMass compound_mass(std::span<const Compound::Part> parts, std::span<const double> densities, Overlap overlap) {
  CompoundMass whole;
  std::vector<Overlapped> overlapped(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (overlap == Overlap::once) overlapped[k] = find_overlap(parts, k);
    const double mass = densities[k] * volume(parts[k].shape);
    whole.volume += volume(parts[k].shape) - overlapped[k].volume, whole.mass += mass - densities[k] * overlapped[k].volume;
    whole.centre += mass * parts[k].place;
    whole.centre -= densities[k] * (overlapped[k].volume * parts[k].place + overlapped[k].first);
  }
  whole.centre /= whole.mass;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Compound::Part& part = parts[k];
    const Mat3 turn = turn_of(part);
    const Vec3 own = part.shape.kind == ShapeKind::particle ? Vec3(Vec3::Zero()) : inertia(part.shape, 1);
    const Vec3 spread = Vec3::Constant(0.5 * own.sum()) - own, d = part.place - whole.centre;
    const double share = densities[k] * volume(part.shape) / whole.mass;
    whole.second += share * (turn * spread.asDiagonal() * turn.transpose() + d * d.transpose());
    if (const Overlapped& o = overlapped[k]; o.volume > 0)
      whole.second -= densities[k] / whole.mass *
                      (o.second + o.first * d.transpose() + d * o.first.transpose() + o.volume * d * d.transpose());
  }
  return whole;
}

}  // namespace unibody
