#include "solve/implicit_step.hpp"

#include <algorithm>
#include <string>

#include "core/errors.hpp"
#include "solve/free_motion.hpp"

namespace unibody {

std::vector<SolverBody> predict_bodies(const World& world, const Vec3& gravity, double step) {
  std::vector<SolverBody> bodies;
  for (std::size_t i = 0; i < world.size(); ++i)
    bodies.push_back(predict_motion(world.properties[i], world.state(i), gravity, step, false).body);
  return bodies;
}

ImplicitStep::ImplicitStep(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted,
                           double step)
    : world_(world), constraints_(constraints), step_(step) {
  if (world.guests > 0) throw RunError("the reference solver needs all bodies on one rank");
  for (std::size_t i = 0; i < world.size(); ++i) {
    const SolverBody& body = predicted[i];
    predicted_.emplace_back(body.v);
    inverse_mass_.push_back(body.inverse_mass);
    first_of_.push_back(body.inverse_mass > 0 ? static_cast<std::ptrdiff_t>(velocities_) : -1);
    if (body.inverse_mass > 0) velocities_ += 3;
  }
  for_each_type(constraints, [&]<class C>(auto type, const ConstraintList<C>& list) {
    if (is_unilateral<C> && !list.empty())
      throw RunError("the reference solver takes no unilateral constraints: found " + std::to_string(list.size()) + " of type " +
                     std::string(C::name));
    for (const auto& c : list) {
      auto& slots = std::get<type.value>(slots_).emplace_back();
      for (std::size_t e = 0; e < slots.size(); ++e) slots[e] = world.find(c.ids[e]);
      rows_ += C::rows;
    }
  });
}

Vec3 ImplicitStep::velocity(Slot slot, const Eigen::VectorXd& unknowns) const {
  const std::ptrdiff_t first = first_of(slot);
  return first < 0 ? predicted_[static_cast<std::size_t>(slot)] : Vec3(unknowns.segment<3>(first));
}

std::vector<Vec3> ImplicitStep::velocities(const Eigen::VectorXd& unknowns) const {
  std::vector<Vec3> v;
  for (std::size_t s = 0; s < slots(); ++s) v.push_back(velocity(static_cast<Slot>(s), unknowns));
  return v;
}

Eigen::VectorXd ImplicitStep::predicted() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(velocities_));
  for (std::size_t s = 0; s < slots(); ++s)
    if (first_of_[s] >= 0) v.segment<3>(first_of_[s]) = predicted_[s];
  return v;
}

ConstraintMultipliers ImplicitStep::multipliers(const Eigen::VectorXd& rows) const {
  ConstraintMultipliers result;
  Eigen::Index row = 0;
  for_each_type(constraints_, [&](auto type, const auto& list) {
    auto& of_type = std::get<type.value>(result);
    of_type.resize(list.size());
    for (auto& one : of_type)
      for (double& lambda : one) lambda = rows[row++];
  });
  return result;
}

double ImplicitStep::largest_place() const {
  double place = 0;
  for (std::size_t s = 0; s < slots(); ++s)
    if (first_of_[s] >= 0) place = std::max(place, world_.position[s].norm());
  return place;
}

double ImplicitStep::largest_speed() const {
  double speed = 0;
  for (std::size_t s = 0; s < slots(); ++s)
    if (first_of_[s] >= 0) speed = std::max(speed, predicted_[s].norm());
  return speed;
}

}  // namespace unibody
