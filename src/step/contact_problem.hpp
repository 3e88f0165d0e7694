// The frictional contact problem of a step of rigid bodies, as the field writes it: Coulomb's law with its exact cone.
//
// Unknowns: velocities v of the bodies that move (m/s, rad/s, world axes, six a body) and impulses r (N s; normal, two tangents
// of each contact point). u are the velocities at which the contacts part, in the same axes (m/s):
//   M v = H r + f,   u = H^T v + w,   K* contains u + mu |u_T| n, at right angles to r in K = {|r_T| <= mu r_n}
// or, without the bodies, u = W r + q with W = H^T M^-1 H and q = H^T M^-1 f + w. f is M times the predicted velocities; w holds
// the velocity that a gap leaves room for, or the one at which penetration is taken out, and the velocities of bodies that are
// moved by the scene. (Acary & Cadoux 2013; FCLIB.)
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// Column by column; rows ascend within one.
struct SparseMatrix {
  std::int64_t rows = 0, columns = 0;
  std::vector<std::int32_t> begin{0};  // of each column, and the end of the last
  std::vector<std::int32_t> row;
  std::vector<double> value;
};

// Two equal problems are equal bit by bit, on any number of ranks: it is put together on rank 0, which alone holds it.
struct ContactProblem {
  // A body that moves and touches something.
  struct Body {
    Id id;
    double inverse_mass;                      // 1/kg
    std::array<double, 9> inverse_inertia;    // 1/(kg m^2), world axes, row by row
    std::array<double, 6> predicted, solved;  // m/s, rad/s: before the contacts act, and after
  };
  struct Contact {
    Id id_a, id_b;
    std::int64_t feature;
    std::array<double, 3> normal, arm_a, arm_b;  // world axes; m, from the centres of the two bodies
    std::array<double, 3> offset;                // m/s, w
    std::array<double, 3> impulse;               // N s, r as the step solved it
    double friction;
  };

  std::vector<Body> bodies;       // ascending ids
  std::vector<Contact> contacts;  // ascending (id_a, id_b), then as in the manifold

  SparseMatrix M() const;  // 6 bodies x 6 bodies
  SparseMatrix H() const;  // 6 bodies x 3 contacts
  SparseMatrix W() const;  // 3 contacts x 3 contacts
  std::vector<double> f() const, w() const, q() const, mu() const;
  std::vector<double> v() const, r() const;  // as the step solved them
  std::vector<double> u() const;             // H^T v + w

  // Brings the parts that ranks have filled in to rank 0, in order. Collective.
  void gather(MPI_Comm comm);
};

struct RankState;
struct SolvedStep;
struct StepPlan;
struct System;

// The contact problem of the rigid bodies of all ranks, on rank 0, from the contacts themselves rather than from the solver's
// layout of them. Collective.
ContactProblem contact_problem_of(const RankState& state, const System& system, const StepPlan& plan, const SolvedStep& solved);

}  // namespace unibody
