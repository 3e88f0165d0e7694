// A step of implicit Euler without contacts, as both forms of the reference have it: the bodies that move, and the constraints
// with their slots. A vector of unknowns begins with the velocities (m/s) of those bodies, in the order of their slots.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "constraints/constraint_types.hpp"
#include "constraints/solver_body.hpp"
#include "solve/local_constraint.hpp"
#include "world/world.hpp"

namespace unibody {

// The velocities v~ before the constraints, and the inverse masses, of each slot.
std::vector<SolverBody> predict_bodies(const World& world, const Vec3& gravity, double step);

// World and constraints must outlive it.
class ImplicitStep {
 public:
  // Throws RunError where bodies are on other ranks, and for unilateral constraints: this is a step of equations.
  ImplicitStep(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted, double step);

  double step() const { return step_; }                   // s
  std::size_t velocities() const { return velocities_; }  // unknowns that are velocities
  std::size_t rows() const { return rows_; }              // of all constraints
  std::size_t slots() const { return first_of_.size(); }

  std::ptrdiff_t first_of(Slot slot) const { return first_of_[static_cast<std::size_t>(slot)]; }  // -1 where it does not move
  double inverse_mass(Slot slot) const { return inverse_mass_[static_cast<std::size_t>(slot)]; }  // 1/kg
  const Vec3& place(Slot slot) const { return world_.position[static_cast<std::size_t>(slot)]; }  // m, at the start
  Vec3 velocity(Slot slot, const Eigen::VectorXd& unknowns) const;                                // m/s
  std::vector<Vec3> velocities(const Eigen::VectorXd& unknowns) const;                            // of each slot
  Eigen::VectorXd predicted() const;                                                              // v~ of those that move
  ConstraintMultipliers multipliers(const Eigen::VectorXd& rows) const;                           // N s, from those of all rows
  double largest_place() const;                                                                   // m, of those that move
  double largest_speed() const;                                                                   // m/s, of v~

  // Places at the end of the step, x_l + h v, and velocities of a constraint's bodies.
  template <class C>
  std::pair<typename Local<C>::Place, typename Local<C>::Place> ends(const std::array<Slot, C::stencil>& slots,
                                                                     const Eigen::VectorXd& unknowns) const {
    typename Local<C>::Place x, v;
    for (std::size_t e = 0; e < C::stencil; ++e) {
      const auto first = 3 * static_cast<Eigen::Index>(e);
      v.template segment<3>(first) = velocity(slots[e], unknowns);
      x.template segment<3>(first) = place(slots[e]) + step_ * v.template segment<3>(first);
    }
    return {x, v};
  }

  // f(constraint, its slots, its first row), the rows of all types counted from 0.
  template <typename F>
  void for_each_constraint(F&& f) const {
    std::size_t row = 0;
    for_each_type(constraints_, [&](auto type, const auto& list) {
      for (std::size_t i = 0; i < list.size(); row += list[i].compliance.size(), ++i)
        f(list[i], std::get<type.value>(slots_)[i], static_cast<Eigen::Index>(row));
    });
  }

 private:
  template <class C>
  using SlotList = std::vector<std::array<Slot, C::stencil>>;

  const World& world_;
  const ConstraintSet& constraints_;
  const double step_;
  std::vector<Vec3> predicted_;           // m/s, of each slot
  std::vector<double> inverse_mass_;      // 1/kg, of each slot
  std::vector<std::ptrdiff_t> first_of_;  // first unknown of each slot, -1 where it does not move
  ConstraintTypes::Tuple<SlotList> slots_;
  std::size_t velocities_ = 0, rows_ = 0;
};

}  // namespace unibody
