// All joints of a step on this rank, and the passes that solvers make over them (paper, Algorithm 1).
//
// Row k of a joint: r_k = (c_k + E_k lambda_k / h + rho D_k u) / (h + rho), with c taken anew in every pass at the bodies' places
// and attitudes after the step, and D those at its start (as in SHAKE, Ryckaert et al. 1977): momentum and angular momentum are
// kept, nothing is damped, and what a step comes to does not depend on the way of the iterations. Unknowns are impulses
// lambda = h gamma (N s, N m s). Where a body turns by more than most_turn_of_rows in the step, the solve takes less
// of the rows' curvature into account, so that it stays stable. The residual takes all of it, so that an open joint is seen.
// Steps are divided (step/division.hpp) so that this is rare. A joint's own rows
// are solved as one block, whose bodies' masses are shared by their counts with the Jacobi solvers. Rows that others of the block
// determine already are left alone: those whose pivot falls below 1e-10 of their diagonal. At velocity level all rows are taken
// straight, and of a row without compliance and damping, or beyond a limit, only the share gamma of its error is to be taken out.
// What loops of joints determine twice needs no rule: every step is along a safe block, and the multipliers settle where the
// start and the iterations leave them.
//
// Where the scene asks for it, the own rows of a tree of joints are one block, all of them here, solved directly: to the Jacobi
// solvers one constraint, which counts once at each of its bodies; to Gauss-Seidel a group of its own. They start from zero.
//
// Limits, motors and friction are rows of their own beside the block. They see one angle, offset or span, c, and have a bounded
// multiplier: within limits, lambda is 0 where lower < c < upper; a drive wants its rate, or c where that is near, at a target
// with |lambda| below h times its strength. A rope's own row is one within limits, with compliance and damping: of s, what of c
// is beyond its length and 0 where it is slack, it wants s + E lambda / h + rho (s - s_before) / h = 0, and never pushes.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "constraints/batch.hpp"
#include "joints/coupling.hpp"
#include "joints/joint.hpp"
#include "joints/joint_side.hpp"
#include "joints/joint_trees.hpp"
#include "joints/joint_type.hpp"
#include "world/world.hpp"

namespace unibody {

// A joint's bodies on this rank.
struct JointSlots {
  Slot a = 0, b = 0;    // of the world: the body that is nobody
  bool counted = true;  // this rank counts it in sums over all ranks
};

// What there is to build of joints.
struct JointInput {
  std::span<const Joint> joints;         // of the scene
  const JointList* list;                 // that are here
  const std::vector<JointSlots>* slots;  // of each of these, where their bodies have slots
  std::int32_t colours = 0;              // of all joints of the scene
  bool any_tree = false;                 // some of the scene's joints are solved as trees

  const std::vector<std::uint8_t>* broken = nullptr;  // 1 for those of the scene's joints that do nothing; empty: none

  const std::vector<double>* pressed_areas =
      nullptr;  // m^2, on which the motor of each of the scene's joints presses; empty: none

  std::span<const Coupling> couplings = {};                    // of the scene
  const JointList* couplings_here = nullptr;                   // their numbers
  const std::vector<CouplingSlots>* coupling_slots = nullptr;  // of each of these
  std::int32_t coupling_colours = 0;

  // The most that the joint's motor may give over the step from `time` to `end` (N m or N).
  double strength_of(std::int64_t number, double time, double end) const {
    const Joint& joint = joints[static_cast<std::size_t>(number)];
    const double strength = joint.strength.mean(time, end);
    return joint.area ? strength * (*pressed_areas)[static_cast<std::size_t>(number)] : strength;
  }
  bool is_broken(std::int64_t joint) const {
    return broken != nullptr && !broken->empty() && (*broken)[static_cast<std::size_t>(joint)] != 0;
  }
};

inline constexpr double most_turn_of_rows = 0.5;  // rad in a step, up to which rows are taken as curved as they are

class JointBatch : public BatchDefaults {
 public:
  using History = std::vector<JointImpulses>;  // of each joint that is here
  using Key = std::array<Id, 1>;               // the joint's number
  static constexpr std::string_view name = "joints";
  static constexpr bool stencils_last = true;

  // f(key, ids of the bodies) for each joint that is here.
  template <class F>
  static void for_each_element(const Elements& elements, F&& f) {
    if (elements.joints == nullptr) return;
    for (const std::int64_t number : *elements.joints->list)
      f(Key{number}, elements.joints->joints[static_cast<std::size_t>(number)].ids);
  }

  // Joints by their colours, and each tree as a whole, of no colour.
  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for_each_tie(context, [&](std::int32_t colour, std::span<const Slot> ends) { f(colour, ends); });
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts);  // rows and blocks

  // Lays out the joints in the order of the list, or colour by colour. It depends on where the bodies are: in each step anew.
  void build(const BuildContext& context);

  // Trees of joints, whose rows are solved together, have one colour, the last.
  std::size_t colours() const { return any_ ? colour_end_.size() + (any_tree_ ? 1 : 0) : 0; }
  bool needs_all(std::size_t colour) const { return colour >= colour_end_.size(); }

  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);
  double relax(std::size_t colour, bool backwards, SolveState& state);
  template <class F>
  void for_each_unknown(F&& f) {
    for (Part& part : parts_) f(std::span<double>(part.lambda));
  }

  // Index = that of the joint in the list.
  void set_impulses(std::span<const JointImpulses> impulses, double share);
  void start_from(const History& history, const WarmStart& warm);
  void add_impulses(SolveState& state, const WarmStart& warm, double) const;
  void remember(History& history, double) const;

  // The largest (h + rho) |r| of the joints' own rows, and of bounded ones what a step by their own mobility would change. Angles
  // count by their joint's lever.
  double residual(const SolveState& state) const;
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;  // of each joint's blocks and rows

  std::size_t bytes() const;

 private:
  enum class Law : std::uint8_t { equal, within, rate, place };
  using Side = JointSide;
  struct Part {
    Side side[2];
    std::uint32_t joint;  // in build()'s list
    std::int32_t link;    // in trees_; -1: a block or row by itself
    std::uint8_t type, first;
    Law law;
    bool counted;
    bool presses;  // a motor whose strength is a pressure
    double compliance, turning, damping, lever;
    double lower, upper;  // within: m or rad; rate, place: the target, and N m or N; equal: upper, where a spring is at rest
    std::array<double, 6> lambda, y;   // N s or N m s
    std::uint32_t row = 0, block = 0;  // where its rows and its block begin
  };
  // A row at the start of the step: its value (m or rad), and its gradients by the bodies' places and turns.
  struct Row {
    Vec3 linear, angular, angular_b;
    double value;
  };
  // Where velocities lead a joint's two ends. All parts of a joint follow each other, and share them while its bodies' velocities
  // stay.
  struct Ends {
    JointEnd a, b;
    std::int64_t joint = -1;  // of the list
  };
  template <class T>
  struct Rows;  // those of a part, and their values after the step
  template <class T>
  struct Step;

  // Below it a row's diagonal is round-off: 1e-10 of what it were if both bodies turned about all axes as about their easiest. In
  // a planar scene that is so of rows that would tilt a body out of the plane, and they are left alone.
  static double least_diagonal(const Side& a, const Side& b, double share_a, double share_b, const Vec3& linear,
                               const Vec3& angular, const Vec3& angular_b);
  static void for_each_tie(const BuildContext& context, const std::function<void(std::int32_t, std::span<const Slot>)>& f);
  double relax_colour(std::size_t colour, std::span<SolverBody> bodies);
  double relax_trees(std::span<SolverBody> bodies);
  void add_to_tree(Part& part, std::int32_t tree);
  void solve_trees(std::span<const SolverBody> bodies, bool extrapolated);
  template <class T>
  Step<T> step_in_tree(const Part& part, const std::array<double, 6>& from) const;
  template <class T>
  double push(Part& part, const Step<T>& step, std::span<SolverBody> bodies, Ends& ends) const;
  // strength: N m or N, the most that its motor gives.
  void add_parts(const Joint& joint, const Part& common, double time, double strength);
  void add_spring(const Joint& joint, const Part& common);
  void limit_approach(Part& part, JointKind kind, double from, double rate) const;
  template <class T>
  static std::array<Row, T::rows> evaluate(const Part& part);
  void prepare_rows();
  // The blocks of all parts, with the bodies' masses shared or not: made where they are first asked for in a step.
  void prepare_blocks(bool shared) const;
  template <class T>
  void fill_block(const Part& part, bool shared, double* block) const;
  template <class T>
  Rows<T> evaluate_ahead(const Part& part, std::span<const SolverBody> bodies, Ends& ends, bool as_they_are = false) const;
  template <class T>
  static double rest_of(const Part& part);
  template <class T>
  double left_alone(const Part& part, std::size_t row, double value) const;
  template <class T>
  std::array<double, T::rows> residual_of(const Part& part, const Rows<T>& at, const std::array<double, 6>& lambda,
                                          std::span<const SolverBody> bodies) const;
  double residual_of(const Part& part, std::span<const SolverBody> bodies, Ends& ends) const;  // m; after prepare_blocks(false)
  template <class T>
  double beyond(const Part& part, const Rows<T>& at, bool upper, double lambda) const;
  template <class T>
  Step<T> step_from(const Part& part, const std::array<double, 6>& from, std::span<const SolverBody> bodies, Ends& ends,
                    bool shared, bool as_they_are = false) const;
  template <class T>
  static double length_of(const Part& part, std::size_t row, double x);

  std::vector<Part> parts_;
  std::vector<Row> rows_;
  mutable std::vector<double> blocks_[2];  // P, factored (semidefinite.hpp), of each part; the second with shared masses
  std::vector<std::size_t> colour_end_;
  JointTrees trees_;
  std::vector<JointTrees::Vector6> residual_, change_;  // of each of their joints
  bool any_ = false, any_tree_ = false;                 // of the scene's joints
  double step_ = 0.016, stabilisation_ = -1;            // the latter: gamma of the velocity level, else negative
};

}  // namespace unibody
