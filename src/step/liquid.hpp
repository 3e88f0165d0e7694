// Bridges of liquid between bodies that have touched, where one of the two is round. A bridge pulls its bodies together until
// they are as far apart as it can reach; then it breaks, and there is none until they touch again.
#pragma once

#include <cstdint>

#include "step/rank_state.hpp"

namespace unibody {

// m, the gap at which a bridge breaks: (1 + theta / 2) V^(1/3), of volume V (m^3) and contact angle theta (rad) (Lian, Thornton,
// Adams, Journal of Colloid and Interface Science 161, 1993, 138).
double rupture_distance(double volume, double angle);

// N, by which a bridge pulls at a gap S (m, 0 where the bodies touch): 2 pi R gamma cos(theta) / (1 + 1.05 S' + 2.5 S'^2) with
// S' = S sqrt(R / V), gamma the surface tension (N/m) and R twice the radius of the ball that touches a plane as the two bodies
// touch each other: of two equal balls their radius (Willett, Adams, Johnson, Seville, Langmuir 16, 2000, 9396).
double bridge_force(double reduced_radius, double gap, double volume, double tension, double angle);

// Makes the history's bridges those of the present contacts: of pairs that touch, or pressed on each other in the last step, and
// of pairs that had one and are within its reach. Called again for the same state, it changes nothing.
void renew_bridges(RankState& state);

// N, by which the pair's bridge pulls at this gap (m); 0 where it has none. With its reach (m).
struct BridgePull {
  double force = 0, reach = 0;
};
BridgePull bridge_pull(const RankState& state, const Manifold& m, double gap);

// How many bridges there are. Collective.
std::int64_t count_bridges(const RankState& state);

}  // namespace unibody
