#include "world/compound_mass.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

// Sums over a mass: about the origin of the parts' axes.
struct Sums {
  double volume = 0, mass = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  void add(double cell, double density, const Vec3& at) {
    const double m = density * cell;
    volume += cell, mass += m, first += m * at, second += m * at * at.transpose();
  }
};

Mat3 turn_of(const Compound::Part& part) { return (part.turn * frame_of(part.shape)).toRotationMatrix(); }

void add_whole(const Compound::Part& part, double density, Sums& sums) {
  const double m = density * volume(part.shape);
  const Mat3 turn = turn_of(part);
  const Vec3 own = part.shape.kind == ShapeKind::particle ? Vec3(Vec3::Zero()) : inertia(part.shape, 1);
  const Vec3 spread = Vec3::Constant(0.5 * own.sum()) - own;
  sums.volume += volume(part.shape), sums.mass += m, sums.first += m * part.place;
  sums.second += m * (turn * spread.asDiagonal() * turn.transpose() + part.place * part.place.transpose());
}

bool is_inside(const Compound::Part& part, const Mat3& turn, const Vec3& at) {
  return type_of(part.shape.kind).convex->contains(part.shape, turn.transpose() * (at - part.place));
}

// Takes what of parts[k] lies in parts before it out of the sums. Cells are along the axes of that part.
void take_overlap(std::span<const Compound::Part> parts, std::size_t k, double density, Sums& sums) {
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
  if (others.empty()) return;
  const Vec3 cell = (high - low) / cells;
  Sums overlap;
  for (int i = 0; i < cells * cells * cells; ++i) {
    const Vec3 number(i % cells, i / cells % cells, i / (cells * cells));
    const Vec3 at = part.place + own * (low + cell.cwiseProduct(number + Vec3::Constant(0.5)));
    const auto holds = [&](std::size_t j) { return is_inside(parts[j], turn_of(parts[j]), at); };
    if (is_inside(part, own, at) && std::ranges::any_of(others, holds)) overlap.add(cell.prod(), density, at);
  }
  sums.volume -= overlap.volume, sums.mass -= overlap.mass, sums.first -= overlap.first, sums.second -= overlap.second;
}

}  // namespace

CompoundMass compound_mass(std::span<const Compound::Part> parts, std::span<const double> densities, Overlap overlap) {
  Sums sums;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    add_whole(parts[k], densities[k], sums);
    if (overlap == Overlap::once) take_overlap(parts, k, densities[k], sums);
  }
  const Vec3 centre = sums.first / sums.mass;
  return {sums.volume, sums.mass, centre, sums.second / sums.mass - centre * centre.transpose()};
}

}  // namespace unibody
