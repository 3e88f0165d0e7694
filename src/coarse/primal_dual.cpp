#include "coarse/primal_dual.hpp"

#include <algorithm>
#include <cmath>

#include "coarse/conjugate_gradients.hpp"
#include "core/checked.hpp"
#include "core/largest.hpp"

namespace unibody {

namespace {

constexpr double stiffness_of_rows = 1e4;  // that of a softened row over the inertia m / h^2 of what it ties

void add_diagonal(BlockMatrix::Block& block, double x) {
  block[0] += Vec4d{x, 0, 0, 0}, block[1] += Vec4d{0, x, 0, 0}, block[2] += Vec4d{0, 0, x, 0};
}

template <class C, class List>
ElementRows<C> rows_at(const ConstraintList<C>& list, const List& elements, std::size_t first, std::size_t count,
                       const StepEnd& end) {
  return {{list.data() + first, count}, {elements.slots.data() + first, count}, end};
}

}  // namespace

PrimalDual::PrimalDual(const World& world, const ConstraintSet& constraints, const Aggregates& aggregates, MPI_Comm comm)
    : world_(world), constraints_(constraints), comm_(comm) {
  std::vector<std::pair<Slot, Slot>> pairs;
  for_each_type(constraints_, [&]<class C>(auto type, const ConstraintList<C>& list) {
    auto& elements = std::get<type.value>(elements_);
    if (!list.empty()) largest_stencil_ = std::max(largest_stencil_, static_cast<int>(C::stencil));
    for (const Constraint<C>& c : list) {
      auto& slots = elements.slots.emplace_back();
      for (std::size_t e = 0; e < C::stencil; ++e) slots[e] = world.find(c.ids[e]);
      const auto first = std::ranges::find_if(slots, [&](Slot s) { return !world.is_static(s); });
      elements.counted.push_back(first != slots.end() && world.is_home(*first));
      for (const Slot row : slots)
        for (const Slot column : slots)
          if (world.is_home(row) && !world.is_static(column)) pairs.emplace_back(row, column);
    }
    elements.softness.resize(list.size()), elements.lambda.resize(list.size()), elements.trial.resize(list.size());
  });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &largest_stencil_, 1, MPI_INT, MPI_MAX, comm_));
  matrix_.set_pattern(std::move(pairs), world.id);
  find_blocks();
  std::vector<std::int32_t> of(world.size(), -1);
  for (std::size_t i = 0; i < world.first_static(); ++i) of[i] = aggregates.of(world.id[i]);
  coarse_.set(comm_, matrix_, std::move(of), aggregates.count(), world.homes, world.id);
}

void PrimalDual::find_blocks() {
  for_each_type(constraints_, [&]<class C>(auto type, const ConstraintList<C>&) {
    auto& elements = std::get<type.value>(elements_);
    for (const auto& slots : elements.slots) {
      auto& places = elements.places.emplace_back();
      for (std::size_t e = 0; e < C::stencil; ++e)
        for (std::size_t f = 0; f < C::stencil; ++f)
          places[e * C::stencil + f] = static_cast<std::int32_t>(
              world_.is_home(slots[e]) && !world_.is_static(slots[f]) ? matrix_.place_of(slots[e], slots[f]) : -1);
    }
  });
}

template <class C>
void PrimalDual::soften(const ConstraintList<C>& list, ElementList<C>& elements) {
  const StepEnd end{world_.position, velocity_, step_};
  for (std::size_t first = 0; first < list.size(); first += lanes) {
    const std::size_t used = std::min(lanes, list.size() - first);
    const ElementRows<C> rows = rows_at<C>(list, elements, first, used, end);
    for (std::size_t l = 0; l < used; ++l)
      for (std::size_t k = 0; k < C::rows; ++k) {
        double inverse_mass = 0;  // that the row sees
        for (std::size_t e = 0; e < C::stencil; ++e) {
          const auto s = static_cast<std::size_t>(elements.slots[first + l][e]);
          if (moves_[s] != 0) inverse_mass += rows.gradient(l, k, e).squaredNorm() / mass_[s];
        }
        elements.softness[first + l][k] =
            std::max(list[first + l].compliance[k], step_ * step_ * inverse_mass / stiffness_of_rows);
      }
  }
}

void PrimalDual::start(const Step& step) {
  const std::size_t n = world_.size();
  step_ = step.length;
  moves_.assign(n, 0), mass_.assign(n, 0), predicted_.resize(n), velocity_.resize(n), gradient_.assign(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const SolverBody& body = step.predicted[i];
    velocity_[i] = predicted_[i] = Vec3(body.v);
    if (i >= world_.first_static() || !(body.inverse_mass > 0) || step.part[i] < 0) continue;
    // Constraints hold at the end of the last step: its velocities break them less than those that gravity has changed.
    moves_[i] = 1, mass_[i] = 1 / body.inverse_mass, velocity_[i] = world_.velocity[i];
  }
  for_each_type(constraints_, [&]<class C>(auto type, const ConstraintList<C>& list) {
    auto& elements = std::get<type.value>(elements_);
    elements.acts.assign(list.size(), 0);
    for (std::size_t i = 0; i < list.size(); ++i)
      elements.acts[i] = std::ranges::any_of(elements.slots[i], [&](Slot s) { return moves_[static_cast<std::size_t>(s)] != 0; });
    soften<C>(list, elements);
  });
}

template <class C>
void PrimalDual::evaluate_type(Pass pass, const ConstraintList<C>& list, ElementList<C>& elements, const StepEnd& end,
                               ExactSum& objective) {
  for (std::size_t first = 0; first < list.size(); first += lanes) {
    const std::size_t used = std::min(lanes, list.size() - first);
    const ElementRows<C> rows = rows_at<C>(list, elements, first, used, end);
    for (std::size_t i = first; i < first + used; ++i) {
      if (elements.acts[i] == 0) continue;
      const Constraint<C>& c = list[i];
      auto& trial = elements.trial[i];
      for (std::size_t k = 0; k < C::rows && pass != Pass::momentum; ++k) {
        const double soft = elements.softness[i][k];
        if (!(soft > 0)) continue;  // its gradient is zero
        const double value = rows.value(i - first, k, c, elements.slots[i], end);
        trial[k] = ((soft - c.compliance[k]) * elements.lambda[i][k] - step_ * value) / soft;
        if constexpr (is_unilateral<C>) trial[k] = std::max(0.0, trial[k]);
        if (elements.counted[i] != 0) objective += soft * trial[k] * trial[k] / (2 * step_ * (step_ + c.damping));
      }
      if (pass == Pass::objective) continue;
      const auto& places = elements.places[i];
      rows.add(
          i - first, c, elements.softness[i], pass == Pass::momentum ? elements.lambda[i] : trial, step_,
          [&](std::size_t e, const Vec3& impulse) { gradient_[static_cast<std::size_t>(elements.slots[i][e])] += impulse; },
          [&](std::size_t e, std::size_t f) { return pass == Pass::system && places[e * C::stencil + f] >= 0; },
          [&](std::size_t e, std::size_t f, const BlockMatrix::Block& part) {
            BlockMatrix::Block& block = matrix_.block(static_cast<std::size_t>(places[e * C::stencil + f]));
            for (std::size_t column = 0; column < 3; ++column) block[column] += part[column];
          });
    }
  }
}

// The part of the inertia.
void PrimalDual::start_evaluation(Pass pass, std::span<const Vec3> velocity, ExactSum& objective) {
  if (pass == Pass::system) matrix_.set_zero();
  if (pass != Pass::objective) std::ranges::fill(gradient_, Vec3::Zero());
  for (std::size_t r = 0; r < matrix_.rows(); ++r) {
    const auto s = static_cast<std::size_t>(matrix_.slot_of(r));
    if (moves_[s] == 0) continue;
    const Vec3 change = velocity[s] - predicted_[s];
    objective += 0.5 * mass_[s] * change.squaredNorm();
    if (pass != Pass::objective) gradient_[s] = mass_[s] * change;
    if (pass == Pass::system) add_diagonal(matrix_.block(matrix_.diagonal_of(r)), mass_[s]);
  }
}

// Bodies that take no part: rows of the identity, which nothing pushes.
void PrimalDual::hold_others(Pass pass) {
  for (std::size_t r = 0; r < matrix_.rows(); ++r) {
    const auto s = static_cast<std::size_t>(matrix_.slot_of(r));
    if (moves_[s] == 0) gradient_[s] = Vec3::Zero();
    if (pass != Pass::system) continue;
    for (std::size_t k = matrix_.begin_of(r); k < matrix_.end_of(r); ++k)
      if (moves_[s] == 0 || moves_[static_cast<std::size_t>(matrix_.column_of(k))] == 0) matrix_.block(k) = {};
    if (moves_[s] == 0) add_diagonal(matrix_.block(matrix_.diagonal_of(r)), 1);
  }
}

// The objective at these velocities. Collective.
double PrimalDual::evaluate(Pass pass, std::span<const Vec3> velocity) {
  ExactSum objective;
  start_evaluation(pass, velocity, objective);
  const StepEnd end{world_.position, velocity, step_};
  for_each_type(constraints_, [&]<class C>(auto type, const ConstraintList<C>& list) {
    evaluate_type<C>(pass, list, std::get<type.value>(elements_), end, objective);
  });
  if (pass != Pass::objective) hold_others(pass);
  return all_sums(comm_, std::span(&objective, 1))[0];
}

// The multipliers on trial become the multipliers. Returns what rows are off by (m), on this rank.
double PrimalDual::accept_multipliers() {
  double residual = 0;
  for_each_type(elements_, [&](auto type, auto& elements) {
    const auto& list = std::get<type.value>(constraints_);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (elements.acts[i] == 0) continue;
      for (std::size_t k = 0; k < elements.lambda[i].size(); ++k) {
        const double softened = elements.softness[i][k] - list[i].compliance[k];
        residual = std::max(residual, softened * std::abs(elements.trial[i][k] - elements.lambda[i][k]) / step_);
        elements.lambda[i][k] = elements.trial[i][k];
      }
    }
  });
  return residual;
}

void PrimalDual::invert_diagonal() {
  inverse_.resize(matrix_.rows());
  for (std::size_t r = 0; r < matrix_.rows(); ++r) {
    const BlockMatrix::Block& block = matrix_.block(matrix_.diagonal_of(r));
    Mat3 diagonal;
    for (int c = 0; c < 3; ++c) diagonal.col(c) = to_vec3(block[static_cast<std::size_t>(c)]);
    inverse_[r] = diagonal.inverse();
  }
}

// Takes from the gain of each part what bodies that are moved by the scene have done on it, and adds what its rows with
// compliance, c^2 / (2 E), have more than at the start of the step.
void PrimalDual::add_work_of_rows(const Step& step, std::span<ExactSum> gain) const {
  const std::vector<Vec3> none(world_.size(), Vec3::Zero());
  const StepEnd start{world_.position, none, step_}, end{world_.position, velocity_, step_};
  for_each_type(constraints_, [&]<class C>(auto type, const ConstraintList<C>& list) {
    const auto& elements = std::get<type.value>(elements_);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (elements.acts[i] == 0 || elements.counted[i] == 0) continue;
      const auto& slots = elements.slots[i];
      const auto in_part = [&](Slot s) { return moves_[static_cast<std::size_t>(s)] != 0; };
      ExactSum& of_part =
          gain[static_cast<std::size_t>(step.part[static_cast<std::size_t>(*std::ranges::find_if(slots, in_part))])];
      const bool is_soft = list[i].compliance != decltype(list[i].compliance){};
      if (!is_soft && std::ranges::all_of(slots, in_part)) continue;
      const ElementRows<C> before = rows_at<C>(list, elements, i, 1, start), after = rows_at<C>(list, elements, i, 1, end);
      for (std::size_t k = 0; k < C::rows; ++k) {
        for (std::size_t e = 0; e < C::stencil; ++e)
          if (!in_part(slots[e]))
            of_part += elements.lambda[i][k] * after.gradient(0, k, e).dot(velocity_[static_cast<std::size_t>(slots[e])]);
        if (const double E = list[i].compliance[k]; E > 0)
          of_part += (after.length(0, k) - before.length(0, k)) * (after.length(0, k) + before.length(0, k)) / (2 * E);
      }
    }
  });
}

// What the momenta of each part are off by, and its energy. Collective.
void PrimalDual::balance(const Step& step, PrimalDualReport& report) {
  evaluate(Pass::momentum, velocity_);
  std::vector<double> momentum(step.parts, 0);
  std::vector<ExactSum> gain(2 * step.parts);  // of each part, then the changes
  for (std::size_t r = 0; r < matrix_.rows(); ++r) {
    const auto s = static_cast<std::size_t>(matrix_.slot_of(r));
    if (moves_[s] == 0) continue;
    const auto part = static_cast<std::size_t>(step.part[s]);
    momentum[part] = std::max(momentum[part], step_ * (inverse_[r] * gradient_[s]).norm());
    const Vec3 &v = velocity_[s], &before = world_.velocity[s], &predicted = predicted_[s];
    gain[part] += mass_[s] * (0.5 * (v - before).dot(v + before) - (predicted - before).dot(v));
    gain[step.parts + part] += 0.5 * mass_[s] * (v - predicted).squaredNorm();
  }
  add_work_of_rows(step, gain);
  make_largest(comm_, momentum);
  const std::vector<double> gains = all_sums(comm_, gain);
  report.parts.resize(step.parts);
  for (std::size_t k = 0; k < step.parts; ++k) report.parts[k] = {momentum[k], gains[k], gains[step.parts + k]};
}

// Of the objective along a change of the velocities, at those of the last evaluation. Collective.
double PrimalDual::slope_along(std::span<const Vec3> change) const {
  ExactSum slope;
  for (std::size_t r = 0; r < matrix_.rows(); ++r) {
    const auto s = static_cast<std::size_t>(matrix_.slot_of(r));
    slope += gradient_[s].dot(change[s]);
  }
  return all_sums(comm_, std::span(&slope, 1))[0];
}

// Whether velocities after a change are taken: where the objective has fallen, or its slope by half. It is no objective to the
// last digit where damped directions turn, and none at all below its round-off.
bool PrimalDual::is_step(std::span<const Vec3> change, double objective, double slope, std::span<const Vec3> velocity) {
  if (evaluate(Pass::objective, velocity) <= objective) return true;
  evaluate(Pass::gradient, velocity);
  return std::abs(slope_along(change)) <= 0.5 * std::abs(slope);
}

// One iteration. Returns false where the objective did not fall, and nothing was changed.
bool PrimalDual::take_newton_step(const Step& step, const PrimalDualSettings& settings, double objective,
                                  PrimalDualReport& report) {
  invert_diagonal();
  coarse_.factorise(matrix_, world_.position, moves_);
  const LinearSystem system{matrix_, inverse_, &coarse_, static_cast<double>(largest_stencil_), comm_, step.refresh};
  std::vector<Vec3> change(world_.size()), trial(world_.size());
  for (std::size_t i = 0; i < trial.size(); ++i) trial[i] = -gradient_[i];
  report.linear_iterations +=
      conjugate_gradients(system, trial, change, settings.linear_share, settings.linear_iterations).iterations;
  ++report.newton_iterations;
  const double slope = slope_along(change);
  constexpr int most_halvings = 8;
  double share = 1;
  for (int halvings = 0; halvings <= most_halvings; ++halvings, share *= 0.5) {
    for (std::size_t i = 0; i < trial.size(); ++i) trial[i] = velocity_[i] + share * change[i];
    if (!is_step(change, objective, slope, trial)) continue;
    velocity_ = trial;
    report.residual = largest_of_ranks(comm_, accept_multipliers());
    return true;
  }
  return false;
}

PrimalDualReport PrimalDual::solve(const Step& step, const PrimalDualSettings& settings) {
  constexpr int longer = 4;
  start(step);
  PrimalDualReport report;
  for (int k = 0; k < longer * settings.newton_iterations; ++k) {
    const double objective = evaluate(Pass::system, velocity_);
    if (!take_newton_step(step, settings, objective, report)) break;
    const bool last = k + 1 >= settings.newton_iterations;
    if (!last && report.residual > settings.tolerance) continue;
    balance(step, report);
    if (report.residual <= settings.tolerance && report.momentum() <= settings.tolerance) return report;
    if (last && !report.gains_energy()) return report;
  }
  balance(step, report);
  return report;
}

double PrimalDualReport::momentum() const {
  double most = 0;
  for (const PartReport& part : parts) most = std::max(most, part.momentum);
  return most;
}

bool PrimalDualReport::gains_energy() const {
  return std::ranges::any_of(parts, [](const PartReport& part) { return part.gains_energy(); });
}

std::size_t PrimalDual::bytes() const {
  std::size_t bytes = matrix_.bytes() + coarse_.bytes() + inverse_.capacity() * sizeof(Mat3);
  for_each_type(elements_, [&](auto, const auto& list) {
    bytes += list.slots.capacity() * (sizeof(list.slots[0]) + sizeof(list.places[0]) + 3 * sizeof(list.lambda[0]) + 2);
  });
  return bytes;
}

}  // namespace unibody
