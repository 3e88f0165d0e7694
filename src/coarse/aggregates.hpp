// Aggregates: parts of flexible bodies, of some dozens of neighbouring nodes each, which the coarse level moves as if they were
// rigid. They are a pure function of where the nodes are at the start of a run, so that every rank has the same.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// The most nodes of an aggregate: 8 x 8 of a cloth, 4 x 4 x 4 of a solid.
inline constexpr std::size_t nodes_of_aggregate = 64;

// The number of the aggregate of each point (m), from 0, and no gaps: the points are halved across their longest extent until no
// part has more than `most` of them.
std::vector<std::int32_t> aggregate_points(std::span<const Vec3> points, std::size_t most = nodes_of_aggregate);

// The aggregates of all flexible bodies of a scene.
class Aggregates {
 public:
  // Adds those of bodies of consecutive ids.
  void add(Id first, std::span<const Vec3> points);

  std::int32_t of(Id body) const;  // -1: of none
  std::int32_t count() const { return count_; }
  std::size_t bytes() const;

 private:
  struct Run {
    Id first;
    std::vector<std::int32_t> number;
  };
  std::vector<Run> runs_;  // ascending
  std::int32_t count_ = 0;
};

}  // namespace unibody
