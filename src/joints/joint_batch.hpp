// All joints of a step on this rank, and the passes that solvers make over them (paper, Algorithm 1).
//
// Row k of a joint: r_k = (c_k + E_k lambda_k / h + rho D_k u) / (h + rho), with c taken anew in every pass at the bodies' places
// and attitudes after the step, and D those at its start (as in SHAKE, Ryckaert et al. 1977): momentum and angular momentum are
// kept, nothing is damped, and what a step comes to does not depend on the way of the iterations. Unknowns are impulses
// lambda = h gamma (N s, N m s). Of a body that turns far in the step the rows are taken straight: c + h D u. A joint's own rows
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

#include <memory_resource>
#include <span>
#include <vector>

#include "constraints/system.hpp"
#include "joints/joint.hpp"
#include "joints/joint_trees.hpp"
#include "joints/joint_type.hpp"
#include "world/world.hpp"

namespace unibody {

// A joint's bodies on this rank.
struct JointSlots {
  Slot a = 0, b = 0;    // of the world: the body that is nobody
  bool counted = true;  // this rank counts it in sums over all ranks
};

class JointBatch {
 public:
  explicit JointBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : parts_(memory) {}

  // Lays out the joints `list` of `joints`, in this order or colour by colour. The body that is nobody is the last of `bodies`.
  // counts: how many constraints share each slot's mass; empty for Gauss-Seidel. scaling: factor on them; step: s.
  void build(std::span<const Joint> joints, const JointList& list, std::span<const JointSlots> slots, bool by_colour,
             std::int32_t colours, const World& world, std::span<const SolverBody> bodies,
             std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic,
             std::span<const std::int32_t> counts, double scaling, double step, double stabilisation = -1);

  // Adds to the bodies' counts how many rows and blocks the joints put at them.
  static void count(std::span<const Joint> joints, const JointList& list, std::span<const JointSlots> slots,
                    std::span<std::int32_t> counts);

  // Index = that of the joint in build()'s list.
  void set_impulses(std::span<const JointImpulses> impulses, double share);
  void get_impulses(std::span<JointImpulses> impulses) const;

  // Adds D lambda to the bodies' wrenches: a warm start.
  void add_impulses(std::span<const SolverBody> bodies, std::span<Wrench> wrenches) const;

  // One Jacobi sweep, as ConstraintBatch's.
  void sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, const Extrapolation& beyond, SweepSums& sums);

  // One Gauss-Seidel pass over a colour: each joint changes its bodies at once. Returns the largest change (m).
  std::size_t colour_count() const { return colour_end_.size(); }
  double relax(std::size_t colour, std::span<SolverBody> bodies);
  double relax_trees(std::span<SolverBody> bodies);

  // Natural residual (m): the largest (h + rho) |r| of the joints' own rows, and of bounded ones what a step by their own
  // mobility would change. Angles count by their joint's lever.
  double residual(std::span<const SolverBody> bodies) const;

  std::size_t bytes() const { return parts_.capacity() * sizeof(Part) + trees_.bytes(); }

 private:
  enum class Law : std::uint8_t { equal, within, rate, place };
  // One side at the start of the step.
  struct Side {
    Slot slot;
    double inverse_mass, share;  // 1/kg; how many constraints share the mass
    Vec3 centre, arm;            // m; the arm in the joint's axes
    Quat axes;
    Mat3 inverse_inertia;  // 1/(kg m^2), world frame
  };
  struct Part {
    Side side[2];
    std::uint32_t joint;  // in build()'s list
    std::int32_t link;    // in trees_; -1: a block or row by itself
    std::uint8_t type, first;
    Law law;
    bool counted;
    double compliance, turning, damping, lever;
    double lower, upper;              // within: m or rad; rate, place: the target, and N m or N
    std::array<double, 6> lambda, y;  // N s or N m s
  };
  template <class T>
  struct Rows;
  template <class T>
  struct Step;

  // Below it a row's diagonal is round-off: 1e-10 of what it were if both bodies turned about all axes as about their easiest. In
  // a planar scene that is so of rows that would tilt a body out of the plane, and they are left alone.
  static double least_diagonal(const Side& a, const Side& b, double share_a, double share_b, const Vec3& linear,
                               const Vec3& angular, const Vec3& angular_b);
  void add_to_tree(Part& part, std::int32_t tree, std::span<const SolverBody> bodies);
  void solve_trees(std::span<const SolverBody> bodies, bool extrapolated);
  template <class T>
  Step<T> step_in_tree(const Part& part, const std::array<double, 6>& from, std::span<const SolverBody> bodies) const;
  template <class T>
  double push(Part& part, const Step<T>& step, std::span<SolverBody> bodies) const;
  void add_parts(const Joint& joint, const Part& common);
  void limit_approach(Part& part, JointKind kind) const;
  static JointEnd end_of(const Side& side, const SolverBody& body, double step);
  template <class T>
  static Rows<T> evaluate(const Part& part, std::span<const SolverBody> bodies);
  template <class T>
  Rows<T> evaluate_ahead(const Part& part, std::span<const SolverBody> bodies) const;
  template <class T>
  double left_alone(const Part& part, std::size_t row, double value) const;
  template <class T>
  std::array<double, T::rows> residual_of(const Part& part, const Rows<T>& at, const std::array<double, 6>& lambda,
                                          std::span<const SolverBody> bodies) const;
  template <class T>
  double beyond(const Part& part, const Rows<T>& at, bool upper, double lambda) const;
  template <class T>
  Step<T> step_from(const Part& part, const std::array<double, 6>& from, std::span<const SolverBody> bodies, bool shared) const;
  template <class T>
  static double length_of(const Part& part, std::size_t row, double x);

  std::pmr::vector<Part> parts_;
  std::vector<std::size_t> colour_end_;
  JointTrees trees_;
  std::vector<JointTrees::Vector6> residual_, change_;  // of each of their joints
  double step_ = 0.016, stabilisation_ = -1;            // the latter: gamma of the velocity level, else negative
};

}  // namespace unibody
