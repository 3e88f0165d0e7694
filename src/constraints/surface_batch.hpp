// All contacts of surfaces, four to a block, and the passes that solvers make over them: the rows of ContactBatch, one point a
// contact, between means of bodies rather than bodies.
//
// Their scale is always that of the Jacobi solvers, masses split by the bodies' counts, so that a sweep over all of them at once
// is safe; Gauss-Seidel takes them as one group. They keep no memory from step to step: faces come and go under what slides.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/contact_batch.hpp"

namespace unibody {

class SurfaceBatch {
 public:
  explicit SurfaceBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : blocks_(memory) {}

  // The body that is nobody is the last of `bodies`. counts: how many constraints share each slot's mass. counted(contact):
  // whether this rank counts it in sums over all ranks.
  template <typename Counted>
  void build(std::span<const SurfaceContact> contacts, std::span<const SolverBody> bodies,
             std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic,
             std::span<const std::int32_t> counts, const SolverSettings& settings, double step, Counted&& counted) {
    start_build(contacts.size(), settings, step);
    for (std::size_t i = 0; i < contacts.size(); ++i) set_lane(i, contacts[i], bodies, inertia, isotropic, counted(contacts[i]));
    for (Block& block : blocks_) scale(block, bodies, counts);
  }

  bool empty() const { return blocks_.empty(); }

  // What has passed through comes back within one position stage, whatever the bound on recovery.
  void start_stage(const Stage& stage);

  // As ContactBatch's.
  void limit_bounces(const World& world, std::span<const SolverBody> bodies);

  // Between the stages: the second starts from zero and adds to the first's multipliers, or, if `joint`, goes on from them.
  void keep_impulses(bool joint);

  // After the stages: what follows goes on from the multipliers of both together.
  void join_stages();

  // One Jacobi sweep, as ContactBatch's.
  void sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, const Extrapolation& beyond, SweepSums& sums);

  // Natural residual (m).
  double residual(std::span<const SolverBody> bodies) const;

  // Normal multipliers of all stages together: index = that of the contact in build()'s list.
  void normal_impulses(std::span<double> normal) const;

  // Counted contacts whose multipliers of all stages together are at friction's limit.
  std::int64_t sliding() const;

 private:
  struct Impulse {
    Vec4d n, s, t;  // N s
  };
  struct Scale {
    Vec4d scale, inverse, mobility;  // 1/kg, kg, 1/kg: as in ContactBatch
  };
  struct Block {
    Slot slot[4][lanes];
    Vec4d weight[4];
    Vec3x4 arm, n, s;
    Vec4d friction, gap, beyond, bounce, bias;  // 1, m, m, m/s, m/s
    Vec4d inertia[6];                           // of end 0: 1/(kg m^2), inverse, world frame: xx, yy, zz, yz, xz, xy
    Scale normal, tangential;
    Impulse lambda, y, kept;
    Mask4 counted;
  };
  struct Velocity {
    Vec4d n, s, t;
  };

  void start_build(std::size_t count, const SolverSettings& settings, double step);
  void set_lane(std::size_t i, const SurfaceContact& contact, std::span<const SolverBody> bodies,
                std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic, bool counted);
  void scale(Block& block, std::span<const SolverBody> bodies, std::span<const std::int32_t> counts) const;
  Vec4d bias_without_bounce(const Block& block) const;
  static Velocity parting(const Block& block, const Vec3x4& t, std::span<const SolverBody> bodies);
  template <FrictionModel model>
  static Impulse stepped(const Block& block, const Velocity& u, const Impulse& from, Vec4d inverse_n, Vec4d inverse_t);
  template <FrictionModel model>
  void sweep(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, const Extrapolation& beyond, SweepSums& sums);

  std::pmr::vector<Block> blocks_;
  FrictionModel friction_ = FrictionModel::disc;
  double scaling_ = 1, step_ = 0.016;
  Stage stage_;
};

}  // namespace unibody
