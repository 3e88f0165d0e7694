// The rows of a checkpoint's tables of bodies and of remembered contact points, as numbers.
#pragma once

#include <array>
#include <cstdint>

#include "constraints/multipliers.hpp"
#include "world/body.hpp"

namespace unibody {

// A body as one row of the data set "bodies": reals, then the small numbers, which doubles hold exactly.
constexpr Id body_columns = 30;
using BodyRow = std::array<double, body_columns>;
BodyRow to_row(const BodyProperties& p, const BodyState& s);
Body from_row(Id id, const BodyRow& row);

// One remembered contact point with the key of its manifold. The owner is the pair's first dynamic body: the file is sorted by
// it, then by key and place in the manifold, so that a ground that touches everything does not gather all points on one rank.
struct PointRow {
  std::int64_t owner, id_a, id_b, place_in_manifold, placed;  // placed: 1, or 0 where no place is kept
  std::array<double, 7> reals;                                // place, normal, tangential
  std::array<double, 6> creep;                                // of the manifold's first point: slip (m), turn (rad)
};
constexpr Id key_columns = 5;

inline auto order(const PointRow& p) { return std::array{p.owner, p.id_a, p.id_b, p.place_in_manifold}; }

// The k-th point of the m-th manifold that is remembered.
PointRow to_row(Id owner, const Multipliers& all, std::size_t m, std::size_t k);
// Adds the point. The caller has begun its manifold before, and sets the manifold's creep.
void append(Multipliers& to, const PointRow& row);

}  // namespace unibody
