// All contacts of a step, four manifolds a block, and the three passes that solvers make over them (paper, Algorithm 2).
//
// Rows of a point: normal r_n = bias + n.u, tangents r_s = s.u, r_t = t.u, with u the relative velocity of the two bodies at the
// point (less the drift of what is carried along a circle, in the tangents); all in m/s, since inside a step every residual is
// divided by h. Unknowns are impulses lambda = h gamma (N s). A block's four manifolds are four SIMD lanes; where a manifold has
// fewer points than its block, the rest are rows of zeros. The grouping into blocks changes no result. A batch holds what its
// solver needs: with Gauss-Seidel a point costs 72 bytes and its tangents 40, with the Jacobi solvers 88 and 48; a manifold costs
// 80, and 96 more with general inertia. Large scenes are bound by the memory, so what changes from sweep to sweep is kept apart:
// only that has to go back.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "constraints/batch.hpp"
#include "constraints/multipliers.hpp"
#include "core/exact_sum.hpp"
#include "core/raw_vector.hpp"
#include "world/surface_motion.hpp"

namespace unibody {

class ContactBatch : public BatchDefaults {
 public:
  using History = Multipliers;
  static constexpr std::string_view name = "contacts";
  static constexpr bool in_velocity_stage = true, in_free_islands = true, alternates = true;

  struct Block {
    Slot slot_a[lanes], slot_b[lanes];
    Vec3x4 n, s;  // third axis t = n x s
    Vec4d friction;
    std::uint32_t first_point, count;  // points a lane, padded to the longest
    std::int32_t first_tangent;        // -1: no manifold of the block has friction
    std::int32_t inertia;              // -1: both bodies of every lane have isotropic inertia
    std::int32_t drift;                // -1: no manifold of the block is carried along a circle
    std::int32_t ratio;                // -1: friction is the same in all directions
    std::int32_t manifold[lanes];      // index into Contacts::manifolds; -1: empty lane
  };
  struct Point {
    Vec3x4 arm_a, arm_b;  // m, from the centres
    Vec4d inverse_scale;  // kg, 1/P_n; 0: no row. P_n bounds the row's share of D^T W D, so that a step of 1/P_n is safe
    Vec4d bias;           // m/s
  };
  struct Normal {  // of each of `points`
    Vec4d lambda;  // N s
  };
  struct Tangents {
    Vec4d inverse_scale;  // kg, 1/P_T
  };
  struct TangentImpulse {      // of each of `tangents`
    Vec4d lambda_s, lambda_t;  // N s
  };
  struct Coupling {    // Gauss-Seidel, for each of `tangents`
    Vec4d K_ns, K_nt;  // 1/kg, of the normal impulse to the tangential velocities
  };
  struct NormalMomentum {  // Jacobi solvers, for each of `points`
    Vec4d y;               // N s, the extrapolated multiplier
  };
  struct TangentMomentum {  // Jacobi solvers, for each of `tangents`
    Vec4d y_s, y_t;         // N s
  };
  struct Inertia {
    Vec4d a[6], b[6];  // xx, yy, zz, yz, xz, xy
  };
  // The relative motion that friction seeks (carried.hpp, creep.hpp): how fast body a's centre moves against body b, and how fast
  // body a turns against it about the normal.
  struct Drift {
    Vec3x4 v, w;  // m/s, across the normal; rad/s
  };

  explicit ContactBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for (const Manifold& m : context.contacts->manifolds) f(0, std::span<const Slot>(std::array{m.slot_a, m.slot_b}));
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) {
    count_stencils<ContactBatch>(context, counts);
  }

  // Lays out the manifolds in the context's order, by its groups: a block never spans two groups (a group is a colour, or
  // everything). For Gauss-Seidel, where the state has no counts, a row's scale is the point's own block.
  void build(const BuildContext& context);

  std::size_t colours() const { return group_end_.size(); }
  bool needs_all(std::size_t) const { return false; }

  // Sets which manifolds belong to islands with constraints: those with a body whose mark (by slot) is not 0. All others belong
  // to free islands. After build(). Returns whether this rank has contacts of free islands, and whether it has others.
  std::pair<bool, bool> set_islands(std::span<const std::int32_t> constrained);
  void forget_islands() { constrained_.clear(); }

  // Which manifolds what follows is about, until the next selection: rows of all others neither move nor leave a residual.
  void select_islands(Islands islands);
  bool is_selected(std::size_t manifold) const { return is_of(selected_, manifold); }
  bool is_of(Islands islands, std::size_t manifold) const {
    return islands == Islands::all || constrained_.empty() || (constrained_[manifold] != 0) == (islands == Islands::constrained);
  }
  double start_share(const WarmStart& warm, std::size_t manifold) const {
    return constrained_.empty() || constrained_[manifold] != 0 ? warm.contacts_share : warm.free_contacts_share;
  }
  // The leak of a manifold: the one that remember() is given, or of a free island the one that set_free_leak() has set.
  double leak_of(double leak, std::size_t manifold) const {
    return constrained_.empty() || constrained_[manifold] != 0 ? leak : free_leak_;
  }
  void set_free_leak(double leak) { free_leak_ = leak; }

  void start_stage(const Stage& stage);
  bool bounces() const { return !bouncing_.empty(); }

  // The rows of contacts that give way (compliance.hpp), which follow their multipliers.
  // Gaps and normals between round bodies at the present velocities, where the stage asks for it: the kernels then work on their
  // linearisation. And how fast bodies must part where they bounce.
  void renew(const SolveState& state);

  // How fast bodies must part where they bounce: at most Contacts::bounce, so that what the multipliers do gives no energy
  // (bounce_limit.cpp).
  void limit_bounces(std::span<const SolverBody> bodies);
  // m/s: of a point (its number in Contacts::points) that has to part at `speed`, as the solver's spins, which leave out some of
  // what bounces speak of, have to show it.
  double bias_of_bounce(const Manifold& m, std::size_t point, double speed) const;

  // The few iterations of a Jacobi solver may leave more than that: weakens a bouncing manifold's multipliers until they alone
  // give none, and adds what that takes from the bodies to the wrenches. Not where lambda leaves out the velocity stage's.
  void give_back_gains(SolveState& state);

  // What contacts gain that do not bounce, and who pays. Where a body that goes away from another one is thrown back against it
  // within the step, the row that stops it does work, twice `work` (J), at the speed at which the two had parted; so the bounce
  // that throws it takes as much less. By slot: the sum of its contacts, and twice the work (J) that those do which bounce.
  struct Gain {
    double work = 0, bounces = 0;
  };
  bool add_gains(std::span<const SolverBody> bodies, std::span<Gain> gains) const;  // whether there are any
  void charge_bounces(std::span<const Gain> gains);

  void reevaluate(std::span<const SolverBody> bodies);

  // One iteration of a Jacobi solver, in key order.
  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);

  // Each manifold changes its bodies at once.
  double relax(std::size_t colour, bool backwards, SolveState& state) { return relax(colour, backwards, state.bodies); }
  double relax(std::size_t group, bool backwards, std::span<SolverBody> bodies);

  template <class F>
  void for_each_unknown(F&& f) {
    f(numbers_of(normals)), f(numbers_of(tangent_impulses));
  }

  // settle(), where the solver is Jacobi's, then hold_centres().
  void end_stage(SolveState& state);

  // Ends a stage of a Jacobi solver, for which a pile may be too much: a home body that would end the step further in what does
  // not move than its centre is out of it, is relaxed against that alone, in key order. So none is lost through a floor, however
  // few the iterations. Where the rows hold nothing changes.
  void settle(std::size_t homes, std::size_t first_static, std::span<SolverBody> bodies);

  // Ends a stage of any solver, after that: a home body whose centre would yet go through a static plane or convex solid that it
  // touches is stopped before it, in its linear velocity along the normal alone. Where it holds nothing changes.
  void hold_centres(std::size_t homes, std::size_t first_static, std::span<SolverBody> bodies) const;

  // max K |lambda - Proj(lambda - K^-1 r)|
  double residual(const SolveState& state) const { return residual(state.bodies); }
  double residual(std::span<const SolverBody> bodies) const;
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;

  // Multipliers of all points: index = that of the point in Contacts::points; normal, s and t components (N s).
  struct Impulse {
    double n, s, t;
  };
  void set_impulses(std::span<const Impulse> impulses);
  void get_impulses(std::span<Impulse> impulses) const;

  void start_from(const Multipliers& history, const WarmStart& warm);
  void add_impulses(SolveState& state, const WarmStart& warm, double) const {
    if (warm.has_contacts()) add_impulses(state.wrenches);
  }
  void add_impulses(std::span<Wrench> wrenches) const;  // in key order

  // Between the stages: keeps the velocity stage's multipliers; the position stage then starts from zero and adds to them, or, if
  // `together`, from them.
  void add_applied(const SolveState& state, std::span<Vec4d> impulses) const;
  void keep_impulses(bool together);

  void join_stages();

  // At the end, of both stages together: the multipliers, and the normal ones alone, of all points.
  std::vector<Impulse> total_impulses() const;
  void normal_impulses(std::span<double> normal) const;

  // At the end, of counted contacts that the position stage pushed on: sum g u, sum g |u| and sum g, with g its normal multiplier
  // (N s) and u the normal velocity that it left (m/s; positive: opening). A coherent opening is a pile that swells. Guests must
  // be as their homes: the sums then have the same bits on any number of ranks.
  using Opening = std::array<ExactSum, 3>;
  Opening opening(std::span<const SolverBody> bodies) const;  // of the islands selected
  void unload(double share);  // of the impulses kept so much is remembered; of the islands selected

  // Points whose multipliers of both stages together are at friction's limit.
  std::int64_t sliding() const;

  // Remembers what was kept, and `leak` times what the position stage added to it; after a single stage all of its multipliers.
  void remember(Multipliers& history, double leak) const;

  // Bounds the leak of each point. A point that opens at these velocities gets no leak. Where a manifold bears more than
  // most_weights, in weights of the lighter of its bodies, its points get less, by the cube of the ratio. (The leak is an
  // integral feedback on penetration. A deep pile answers it too slowly, and would swing up further each time.) weight: N s per
  // kg, the impulse of gravity on a body in a step. Guests must be as their homes: the bounds are then the same on any number of
  // ranks. Of the islands selected.
  void limit_leak(std::span<const SolverBody> bodies, double most_weights, double weight);

  // By how much two bodies that stick have crept in this step, beside what they were asked for, for remember() to keep
  // (creep.hpp); of manifolds of so many points at least. Guests must be as their homes.
  void note_creep(std::span<const SolverBody> bodies, std::uint32_t least_points);

  // Marks manifolds whose residual is more than the tolerance (m): remember() keeps but `share` of what the normal forces of
  // their points differ from the manifold's mean by. Guests must be as their homes. Of the islands selected.
  void even_out(std::span<const SolverBody> bodies, double tolerance, double share);

  std::size_t bytes() const { return 0; }  // in the solve's scratch memory, which is counted as a whole

  bool is_counted(std::size_t manifold) const { return counted_[manifold] != 0; }  // by this rank in sums over all ranks

  std::size_t group_count() const { return group_end_.size(); }
  std::size_t group_end(std::size_t group) const { return group_end_[group]; }  // in blocks

  // The manifold in a lane that is not empty.
  const Manifold& manifold(const Block& block, std::size_t lane) const {
    return contacts_->manifolds[static_cast<std::size_t>(block.manifold[lane])];
  }

  // The relative velocity (m/s, across the normal) that friction at a point of a manifold seeks, which takes back what it has
  // slipped (creep.hpp); zero where nothing is to be taken back.
  Vec3 aim_of(std::size_t manifold, std::size_t point) const;

  const Drift* drift_at(const Block& block) const { return block.drift < 0 ? nullptr : &drifts[block.drift]; }
  // The coefficients of friction along t, over those along s.
  Vec4d ratio_at(const Block& block) const { return block.ratio < 0 ? broadcast(1) : ratios[block.ratio]; }

  RawVector<Block> blocks;
  RawVector<Point> points;
  RawVector<Normal> normals;
  RawVector<Tangents> tangents;
  RawVector<TangentImpulse> tangent_impulses;
  RawVector<Coupling> couplings;
  RawVector<Vec4d> normal_scales, tangent_scales;  // Jacobi solvers: P_n of each of `points`, P_T of each of `tangents`, 1/kg
  RawVector<NormalMomentum> normal_momenta;
  RawVector<TangentMomentum> tangent_momenta;
  RawVector<Inertia> inertias;
  RawVector<Drift> drifts;
  RawVector<Vec4d> ratios;  // with anisotropic friction, of each block with tangents

 private:
  struct Rows {  // of a block: where they are, and how many lanes it uses
    std::uint32_t first_point = 0;
    std::uint16_t count = 0, used = 0;
    std::int32_t first_tangent = -1, inertia = -1, drift = -1, ratio = -1;
  };
  void lay_out(std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups,
               std::span<const std::uint8_t> isotropic, bool gauss_seidel);
  void begin_block(std::size_t number, Slot nobody);
  static constexpr std::size_t no_tangent = -1, most_points = 8;  // of a manifold
  // Calls f(number of the manifold, lane, point, tangent, number in Contacts::points) for every row in use, in key order.
  template <class F>
  void for_each_row(F&& f) const;
  // Calls f(block, residual of each lane (m/s)).
  template <class F>
  void for_each_block_residual(std::span<const SolverBody> bodies, F&& f) const;
  void recall_creeps(const Multipliers* history);
  void remember_creep(Multipliers& history, std::size_t manifold, Creep& sum, int& count) const;
  Vec3 creeps_about(const Manifold& m) const;
  double smaller_radius(const Manifold& m) const;  // m, of the bounding spheres of its two bodies
  void forget_solids(const Surfaces& surfaces, std::span<Impulse> start) const;
  bool sinks(const Block& block, std::size_t lane, bool is_a, std::span<const SolverBody> bodies) const;
  struct Lane {
    std::uint32_t block, lane;
  };
  struct Closing {  // how fast the bodies of a manifold have to part for their surfaces, which turn, to stay in touch (m/s)
    Lane at;
    double speed;
  };
  template <class F>
  void for_each_point(const Lane& at, F&& f) const;
  using HiddenRow = std::array<double, 7>;  // in one lane: scales and their inverses, normal and tangential; multipliers
  template <class F>
  void for_each_hidden(F&& f);
  // A point of a contact that gives way: its row's residual is u + bias + softness lambda (compliance.hpp).
  struct SoftPoint {
    std::uint32_t point, lane, contact;  // the last: into Contacts::points
    double softness, bias;               // 1/kg, m/s
  };
  void soften(const BuildContext& context);
  void renew_soft_points();
  void start_bounces();
  double work_of_bounces(const Lane& at) const;  // J, twice that of the normal impulses at the speeds of Contacts::bounce
  bool hold_centre(const Manifold& m, bool is_a, bool stop, std::span<SolverBody> bodies) const;
  void start_momenta();  // at the multipliers, at rest
  Impulse row(std::size_t lane, std::size_t point, std::size_t tangent) const;
  bool is_carried(const Manifold& m) const;  // or the surface of one of the two moves
  OwnMotion drift_of(const Manifold& m) const;
  double closing_of(const Manifold& m) const;
  void fill_lane(Block& block, std::size_t lane, std::uint32_t number);
  void scale_jacobi(Block& block, std::span<const SolverBody> bodies, std::span<const std::int32_t> counts);
  void scale_gauss_seidel(Block& block, std::span<const SolverBody> bodies);

  std::vector<std::uint32_t> group_end_;     // in blocks
  std::pmr::vector<std::uint32_t> places_;   // of each manifold: its block times the lanes, and its lane
  std::pmr::vector<Rows> rows_;              // of each of `blocks`, once more: what is looked up in key order stays in the cache
  std::pmr::vector<Closing> closing_;        // of what is carried along a circle
  std::pmr::vector<Lane> bouncing_;          // whose manifolds have points that bounce
  std::pmr::vector<double> left_shares_;     // of each of them: of its speeds, what it keeps when it has paid for others
  std::pmr::vector<std::uint8_t> counted_;   // of each manifold: this rank counts it in sums over all manifolds
  std::pmr::vector<Impulse> kept_impulses_;  // of all points: the velocity stage's multipliers
  std::pmr::vector<double> leak_shares_;     // of all points, what limit_leak() leaves of the leak; empty: all of it
  std::pmr::vector<double> uneven_shares_;   // of each manifold, what even_out() leaves; empty: all of it everywhere
  std::pmr::vector<Creep> creeps_;           // of each manifold, from before the step, then after it; empty: none
  std::pmr::vector<std::uint8_t> constrained_;  // of each manifold: its island has constraints; empty: nobody asks
  std::pmr::vector<HiddenRow> hidden_;          // of the rows that are not selected
  std::pmr::vector<SoftPoint> soft_points_;
  Islands selected_ = Islands::all;
  bool any_selected_ = true;
  double free_leak_ = 0;
  const Contacts* contacts_ = nullptr;
  const World* world_ = nullptr;
  std::span<const BounceStart> bounce_starts_;  // of each slot; empty: nothing bounces
  std::span<const Vec3> displaced_;             // only while it is built
  FrictionModel friction_ = FrictionModel::disc;
  double scaling_ = 1, step_ = 0.016, least_creep_ = 0;
  Stage stage_;
  bool is_gauss_seidel_ = false;
  bool bias_is_gap_ = false;                                           // just built: Point::bias holds the gap
  bool creeps_noted_ = false;                                          // creeps_ is of after the step
  enum class Kept { nothing, apart, together } kept_ = Kept::nothing;  // together: lambda holds both stages' multipliers
};

}  // namespace unibody
