// Largest values over all ranks that are the same on each rank, whatever the values are. Of a number and what is not a number,
// MPI_MAX gives one or the other by their order, which need not be the same on all ranks: ranks that then decide by the result
// would wait for each other for ever. So what is not a number counts as infinite here. tests/program/return_codes.py finds a
// reduction of doubles by MPI_MAX or MPI_MIN that stands elsewhere.
#pragma once

#include <mpi.h>

#include <cmath>
#include <span>

namespace unibody {

inline double or_infinity(double x) { return std::isnan(x) ? HUGE_VAL : x; }

// Each of `values` becomes the largest of its place on all ranks. Collective; as many values on every rank.
void make_largest(MPI_Comm comm, std::span<double> values);

inline double largest_of_ranks(MPI_Comm comm, double value) { return make_largest(comm, {&value, 1}), value; }
inline double smallest_of_ranks(MPI_Comm comm, double value) { return -largest_of_ranks(comm, -value); }

}  // namespace unibody
