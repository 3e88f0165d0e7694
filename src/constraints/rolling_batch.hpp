// Rolling and spinning friction: torques that resist how two touching bodies turn against each other, about the tangents of
// their contact and about its normal.
//
// Rows of a manifold, rad/s: r = w.n, w.s, w.t, with w the angular velocity of one body against the other's. Unknowns are
// angular impulses (N m s), bounded by the manifold's normal impulses N, summed over its points, at every iteration anew:
//   |tau_n| <= spinning N,  |(tau_s, tau_t)| <= rolling N
// with coefficients in metres: the arm at which the normal force meets the ground ahead of the centre. As friction, it is the
// same in both stages, each with its own N, whose bounds add up. All starts from zero in every step: it keeps no history.
// Scales are absolute row sums of the manifold's 3 x 3 block, masses split by the bodies' counts with the Jacobi solvers, where
// such a manifold counts twice: once for its contact, once for these rows.
#pragma once

#include <array>
#include <memory_resource>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/system.hpp"

namespace unibody {

// A manifold that resists rolling or spinning.
struct RollingContact {
  std::uint32_t manifold;
  double rolling, spinning;  // m
};

class RollingBatch {
 public:
  explicit RollingBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : rows_(memory) {}

  // Lays out the list (ascending manifolds) as `batch`, built before, has laid out its contacts. counts: how many constraints
  // share each slot's mass; empty for Gauss-Seidel. scaling: factor on them; step: s.
  void build(std::span<const RollingContact> list, const Contacts& contacts, const ContactBatch& batch, const World& world,
             std::span<const SolverBody> bodies, std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic,
             std::span<const std::int32_t> counts, double scaling, double step);

  // After a sweep or pass of `batch`, whose normal multipliers are the bound: as its own. relax() returns the largest change (m).
  void sweep_jacobi(const ContactBatch& batch, std::span<const SolverBody> bodies, std::span<Wrench> wrenches,
                    const Extrapolation& beyond, SweepSums& sums, std::span<const std::uint8_t> counted);
  double relax(std::size_t group, const ContactBatch& batch, std::span<SolverBody> bodies);

  // Between the stages: as ContactBatch's. join_stages(): works on the multipliers of both stages from now on.
  void keep_impulses(bool joint);
  void join_stages();

  // Natural residual (m): as ContactBatch's, an angle counting by the longer arm from the bodies' centres to the contact.
  double residual(const ContactBatch& batch, std::span<const SolverBody> bodies) const;

 private:
  using Torque = std::array<double, 3>;  // N m s, about n, s and t
  struct Row {
    std::uint32_t manifold, block, lane;
    Slot a, b;
    double rolling, spinning, lever;  // m
    std::array<Vec3, 3> axes;         // n, s, t
    Mat3 turn_a, turn_b;              // 1/(kg m^2), inverse inertia, world frame
    std::array<double, 2> scale;      // 1/(kg m^2), of the spinning row and the rolling ones; 0: neither body can turn so
    std::array<double, 2> own_scale;  // without the split of masses
    Torque lambda, y, kept;
  };
  static std::array<double, 2> scale_of(const Row& row, double share_a, double share_b);
  static Torque rates(const Row& row, std::span<const SolverBody> bodies);
  static Torque project_step(const Row& row, const std::array<double, 2>& scale, const Torque& from, const Torque& rates,
                             const ContactBatch& batch);
  static Vec3 torque_of(const Row& row, const Torque& lambda);

  std::pmr::vector<Row> rows_;
  std::vector<std::size_t> group_end_;
  double step_ = 0.016;
};

}  // namespace unibody
