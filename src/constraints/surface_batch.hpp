// All contacts of surfaces, four to a block, and the passes that solvers make over them: the rows of ContactBatch, one point a
// contact, between means of bodies rather than bodies.
//
// Their scale is always that of the Jacobi solvers, masses split by the bodies' counts, so that a sweep over all of them at once
// is safe; Gauss-Seidel takes them as one group. They keep no memory from step to step: faces come and go under what slides.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "constraints/contact_batch.hpp"

namespace unibody {

class SurfaceBatch : public BatchDefaults {
 public:
  static constexpr std::string_view name = "contacts of surfaces";
  static constexpr bool in_velocity_stage = true, pushes_wrenches = true;
  static constexpr int relaxations = 4;  // with one, five cloths on each other are not held apart

  explicit SurfaceBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : blocks_(memory) {}

  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for (const SurfaceContact& contact : context.contacts->surface) f(0, std::span<const Slot>(contact.slots));
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) {
    count_stencils<SurfaceBatch>(context, counts);
  }

  // With Gauss-Seidel they share masses among themselves alone.
  void build(const BuildContext& context);

  std::size_t colours() const { return any_ ? 1 : 0; }

  // What has passed through comes back within one position stage, whatever the bound on recovery.
  void start_stage(const Stage& stage);

  bool bounces() const { return any_bounce_; }
  void renew(const SolveState& state);  // as ContactBatch's

  void add_applied(const SolveState& state, std::span<Vec4d> impulses) const;
  void keep_impulses(bool together);
  void join_stages();

  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);
  double relax(std::size_t colour, bool backwards, SolveState& state);
  template <class F>
  void for_each_unknown(F&& f) {
    for (Block& block : blocks_)
      for (Vec4d* of : {&block.lambda.n, &block.lambda.s, &block.lambda.t}) f(std::span(reinterpret_cast<double*>(of), lanes));
  }
  double residual(const SolveState& state) const;
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;

  // Normal multipliers of all stages together: index = that of the contact in Contacts::surface.
  void normal_impulses(std::span<double> normal) const;

  // The total impulse (N s, world axes) of all stages together on the first side of each contact, with the same index.
  void total_impulses(std::span<Vec3> impulses) const;

  std::int64_t sliding() const;
  std::size_t bytes() const { return 0; }  // in the solve's scratch memory, which is counted as a whole

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
    Vec3x4 drift;                               // m/s: at which the sides' tangential velocity aims (carried.hpp)
    Vec4d friction, gap, beyond, bounce, bias;  // 1, m, m, m/s, m/s
    Vec4d closing;                              // m/s: at which the normal velocity aims, of what is carried at a wall
    Vec4d ratio = broadcast(1);                 // of the coefficients of friction along t = n x s and along s
    Vec4d inertia[6];                           // of end 0: 1/(kg m^2), inverse, world frame: xx, yy, zz, yz, xz, xy
    Scale normal, tangential;
    Impulse lambda, y, kept;
    Mask4 counted;
  };
  struct Velocity {
    Vec4d n, s, t;
  };

  struct Drift {
    Vec3 along;
    double closing;
  };
  Drift drift_of(const SurfaceContact& contact) const;
  void fill_lane(std::size_t i, const SurfaceContact& contact, const BuildContext& context);
  void scale(Block& block, std::span<const SolverBody> bodies, std::span<const std::int32_t> counts) const;
  Vec4d bias_without_bounce(const Block& block) const;
  double bias_of_bounce(const Block& block, std::size_t lane, double speed) const;  // as ContactBatch's (m/s)
  static Velocity parting(const Block& block, const Vec3x4& t, std::span<const SolverBody> bodies);
  template <FrictionModel model>
  static Impulse stepped(const Block& block, const Velocity& u, const Impulse& from, Vec4d inverse_n, Vec4d inverse_t);
  template <class F>
  void for_each_block_residual(std::span<const SolverBody> bodies, F&& f) const;  // f(block, residual of each lane (m/s))
  template <FrictionModel model>
  void sweep_as(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);

  std::pmr::vector<Block> blocks_;
  FrictionModel friction_ = FrictionModel::disc;
  double scaling_ = 1, step_ = 0.016;
  bool any_ = false;         // on any rank
  bool any_bounce_ = false;  // on this rank
  const World* world_ = nullptr;
  std::span<const BounceStart> bounce_starts_;  // of each slot; empty: nothing bounces
  Stage stage_;
};

}  // namespace unibody
