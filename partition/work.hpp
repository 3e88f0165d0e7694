// Work: what a step costs a rank, counted from what it has to evaluate and not timed, so that a run and its report repeat.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/constraint_types.hpp"
#include "joints/joint.hpp"
#include "world/world.hpp"

namespace unibody {

// What one rank evaluates in a step. A part that is absent is null or empty.
struct StepParts {
  const World& world;
  const Contacts& contacts;
  const ConstraintSet* constraints = nullptr;  // that touch its home bodies
  std::span<const Joint> joints = {};          // of the scene
  std::span<const std::int64_t> joints_here = {};
};

// The weights, ns of one core an iteration. They were measured as the difference of runs with 50 and 150 iterations of
// accelerated Jacobi, and are good to some 30 %: a pair of spheres takes 25, one of boxes with four points 40, a contact of a
// surface 45, a link of cloth 10, a tetrahedron 140, a ball joint 1200, a hinge 1650, a fixed joint 3800. That of a body stands
// for prediction, collision detection and bookkeeping, spread over the iterations.
namespace work {
inline constexpr double of_a_body = 20, of_a_pair = 20, of_a_point = 5, of_a_surface_contact = 45;
inline constexpr double of_a_row_at_a_node = 6, of_a_joint_row = 400;
}  // namespace work

// The cost (ns) of each constraint of a list, and of one joint.
template <class C>
constexpr double cost_of_type(const std::vector<Constraint<C>>&) {
  return work::of_a_row_at_a_node * static_cast<double>(C::rows * C::stencil);
}
double cost_of(const Joint& joint);

// The work of this rank: all that it evaluates. What is cut by a border of ranks counts on both sides.
double work_of(const StepParts& parts);

// The work that this rank counts. What a border cuts is counted on one side of it (counts_here()), so that the sum over all ranks
// is the work of one rank alone. The first function counts bodies and contacts; where `marks` are given, by slot, it leaves out
// the marked bodies and what touches them. The second one counts constraints, and its `world` needs no guests.
std::int64_t counted_work_of(const World& world, const Contacts& contacts, std::span<const std::int32_t> marks = {});
std::int64_t counted_work_of(const World& world, const ConstraintSet& constraints);

// What the borders between ranks cost.
struct BorderCosts {
  double guests = 0;         // of all ranks, over the home bodies
  double repeated_work = 0;  // evaluated by one more rank than one, over the work of one rank alone
};

// Collective.
BorderCosts border_costs(MPI_Comm comm, const StepParts& parts);

// The work of each home body: its own cost, and an equal share, with the other moving bodies, of what touches it. Over all
// ranks these sum up to what one rank alone would have to do.
std::vector<float> work_by_body(const StepParts& parts);

}  // namespace unibody
