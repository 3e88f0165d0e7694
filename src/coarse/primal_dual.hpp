// A step of implicit Euler of the constraints between bodies' centres, by Newton's method on the bodies' velocities, with
// multipliers beside them.
//
// With v~ the velocities before the constraints, x = x_l + h v, compliance E and damping rho, a step solves
//   M (v - v~) = D lambda,    c(x) + E lambda / h + rho D^T v = 0         (lambda: impulses, N s)
// A row is softened to s = max(E, e), e = h^2 w / 10^4, w the inverse mass that it sees; what that leaves undone the multipliers
// take up from one iteration to the next (the method of multipliers), lambda <- ((s - E) lambda - h (c + rho D^T v)) / s. For
// given old multipliers the velocities minimise
//   |v - v~|^2_M / 2 + sum s lambda(v)^2 / (2 h (h + rho)),
// whose Hessian is taken as M + sum D h (h + rho) / s D^T plus the geometric stiffness of what is in tension: positive definite,
// solved by conjugate gradients on two levels (conjugate_gradients.hpp). A step along its solution is halved until that objective
// falls.
#pragma once

#include <mpi.h>

#include <functional>
#include <span>
#include <vector>

#include "coarse/aggregates.hpp"
#include "coarse/block_matrix.hpp"
#include "coarse/coarse_space.hpp"
#include "coarse/element_rows.hpp"
#include "constraints/constraint_types.hpp"
#include "constraints/solver_body.hpp"
#include "core/exact_sum.hpp"
#include "world/world.hpp"

namespace unibody {

struct PrimalDualSettings {
  int newton_iterations = 2;   // at most; four times as many where a part still gains energy
  int linear_iterations = 30;  // of conjugate gradients, in each of them, at most
  double linear_share = 0.03;  // of the preconditioned residual, at which they stop
  double tolerance = 0;        // m, of the rows and the momenta: where Newton's method stops
};

// A body that is solved as a whole, such as a cloth.
struct PartReport {
  double momentum = 0;  // m, how far a node by itself would still move by what the momenta are off by
  double gain = 0;      // J, of kinetic and elastic energy in the step, beside the work of gravity and of what moves pins
  double change = 0;    // J, |v - v~|^2_M / 2

  // Whether the step must not be kept, since the part's energy would grow. A small share of `change` is allowed, within which the
  // round-off of a part at rest lies.
  bool gains_energy() const { return !(gain <= 1e-4 * change); }
};

struct PrimalDualReport {
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0;  // m, the most that a row is off by, over all ranks
  std::vector<PartReport> parts;

  double momentum() const;  // m, of all parts
  bool gains_energy() const;
};

class PrimalDual {
 public:
  // Lays out what lasts until slots move. World and constraints must outlive it. Collective.
  PrimalDual(const World& world, const ConstraintSet& constraints, const Aggregates& aggregates, MPI_Comm comm);

  struct Step {
    std::span<const SolverBody> predicted;  // v~ and inverse masses, by slot
    std::span<const std::int32_t> part;     // number of each slot's; -1: keeps v~, constraints among such their multipliers
    std::size_t parts;
    double length;                                 // s
    std::function<void(std::span<Vec3>)> refresh;  // of guests from their homes; collective
  };
  // From the velocities at the start of the step and multipliers() to those of the solution. Collective.
  PrimalDualReport solve(const Step& step, const PrimalDualSettings& settings);

  const std::vector<Vec3>& velocities() const { return velocity_; }  // m/s, by slot
  template <class C>
  std::vector<std::array<double, C::rows>>& multipliers() {  // N s, in the order of the constraints
    return std::get<type_index<C>>(elements_).lambda;
  }
  std::size_t bytes() const;

 private:
  template <class C>
  struct ElementList {
    std::vector<std::array<Slot, C::stencil>> slots;
    std::vector<std::array<std::int32_t, C::stencil * C::stencil>> places;  // of the blocks (e, f); -1: not of this rank
    std::vector<std::uint8_t> counted;                                      // by this rank, in sums over all
    std::vector<std::uint8_t> acts;                                         // in this step: some body of it takes part
    std::vector<std::array<double, C::rows>> softness, lambda, trial;       // m/N, N s
  };
  // What is made of the constraints at some velocities: the objective, with multipliers on trial; its gradient too; the matrix
  // too; or what the momenta are off by with the multipliers as they are.
  enum class Pass { objective, gradient, system, momentum };

  void find_blocks();
  void start(const Step& step);
  template <class C>
  void soften(const ConstraintList<C>& list, ElementList<C>& elements);
  double evaluate(Pass pass, std::span<const Vec3> velocity);
  void start_evaluation(Pass pass, std::span<const Vec3> velocity, ExactSum& objective);
  template <class C>
  void evaluate_type(Pass pass, const ConstraintList<C>& list, ElementList<C>& elements, const StepEnd& end, ExactSum& objective);
  void hold_others(Pass pass);
  bool take_newton_step(const Step& step, const PrimalDualSettings& settings, double objective, PrimalDualReport& report);
  bool is_step(std::span<const Vec3> change, double objective, double slope, std::span<const Vec3> velocity);
  double slope_along(std::span<const Vec3> change) const;
  double accept_multipliers();
  void invert_diagonal();
  void balance(const Step& step, PrimalDualReport& report);
  void add_work_of_rows(const Step& step, std::span<ExactSum> gain) const;

  const World& world_;
  const ConstraintSet& constraints_;
  const MPI_Comm comm_;
  ConstraintTypes::Tuple<ElementList> elements_;
  BlockMatrix matrix_;
  CoarseSpace coarse_;
  int largest_stencil_ = 1;

  // Of a step, by slot.
  double step_ = 0;
  std::vector<std::uint8_t> moves_;
  std::vector<double> mass_;  // kg
  std::vector<Vec3> predicted_, velocity_, gradient_;
  std::vector<Mat3> inverse_;  // of the diagonal block of each of the matrix's rows
};

}  // namespace unibody
