// The last resort against passing through what does not move by forces: meshes and fixed or driven solids.
//
// The contacts of a step are found along the way that a body goes if nothing turns it. A fast body that is turned aside or set
// spinning within the step may come to something with which it has no contact, and nothing would tell afterwards on which side it
// was. So the way that each fast body's centre has gone, as the other one sees it, is tried against meshes and solids. The centre
// of a body that has passed through a mesh or has got into a solid is put back in front of it, and its velocity is changed by as
// much as if the step had taken it there; what it does along the surface is kept. What holds it is fixed or driven, so that no
// other body feels it.
#pragma once

#include <cstdint>
#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

class SideGuard {
 public:
  // Before bodies move.
  explicit SideGuard(const RankState& state);

  // After that. Changes home bodies; returns how many of them, over all ranks. Collective.
  std::int64_t hold(RankState& state) const;

 private:
  // A fixed or driven body, as it was before the step.
  struct Obstacle {
    std::size_t slot;
    Vec3 place;  // m
    Mat3 turn;   // from its axes to the world's
  };
  // The centre of a convex body, or of a part of a compound: of each it is the side that says where it is held.
  struct Centre {
    Vec3 from, to;     // m
    double half_size;  // m
  };
  struct Pair {
    std::size_t body, obstacle;  // slot, place in the list
    auto operator<=>(const Pair&) const = default;
  };
  double turn_of(const World& world, std::size_t body) const;
  static double motion_of(const Obstacle& obstacle, const RankState& state);
  std::vector<std::size_t> fast_bodies(const RankState& state, double driven) const;
  std::vector<Pair> near_solids(const World& world, const std::vector<std::size_t>& bodies) const;
  std::vector<Pair> pairs(const RankState& state) const;
  std::vector<Centre> centres_of(const World& world, std::size_t body) const;
  Vec3 change_before(const Obstacle& obstacle, const World& world, std::size_t body, const std::vector<Centre>& centres) const;

  std::vector<Obstacle> obstacles_;
  std::vector<Vec3> places_;  // m, of home bodies before the step; empty where there is no obstacle
  std::vector<Quat> turns_;   // the same where one of them is a compound
};

}  // namespace unibody
