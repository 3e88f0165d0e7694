// Hilbert's curve through the cells of a cube, and where to cut what lies along it: a parallel split of space in which no rank
// ever holds all cells.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace unibody {

__extension__ typedef unsigned __int128 CurvePlace;  // along the curve: three bits for each bit of a coordinate

// The place of a cell on the curve through the cube of 2^bits cells a side; bits: 1 to 32. Cells that follow each other on the
// curve share a face. After J. Skilling, Programming the Hilbert curve, AIP Conference Proceedings 707 (2004).
CurvePlace hilbert_place(std::array<std::uint32_t, 3> cell, int bits);

struct WeighedPlace {
  CurvePlace place;
  std::int64_t weight;
};

// Collective. Cuts the curve so that the weight of all ranks' places before cut k is as near as may be to shares[k] / whole of all.
// here: this rank's, sorted by place. shares: ascending, the same on every rank. bits: of a coordinate. The result is ascending: a
// place belongs to the part whose number is that of the cuts at or before it.
std::vector<CurvePlace> cuts_along_curve(MPI_Comm comm, std::span<const WeighedPlace> here, std::span<const int> shares, int whole,
                                         int bits);

}  // namespace unibody
