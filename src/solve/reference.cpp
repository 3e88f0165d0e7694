#include "solve/reference.hpp"

#include "solve/elastic_problem.hpp"

namespace unibody {

ReferenceProblem::ReferenceProblem(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted,
                                   double step, double softening)
    : step_(world, constraints, predicted, step), softening_(softening) {}

Eigen::VectorXd ReferenceProblem::start() const {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size()));
  u.head(static_cast<Eigen::Index>(step_.velocities())) = step_.predicted();
  return u;
}

Eigen::VectorXd ReferenceProblem::residual(const Eigen::VectorXd& u) const {
  Eigen::VectorXd F = u - start();
  const double h = step_.step();
  const auto rows = static_cast<Eigen::Index>(step_.velocities());
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    const auto [x, v] = step_.ends<C>(slots, u);
    const auto at = At::evaluate(c, {x, x, x, x});
    const auto D = At::gradient(at, 0);
    const auto lambda = u.segment<At::rows>(rows + row);
    const typename At::Place impulse = D * lambda;
    for (std::size_t e = 0; e < C::stencil; ++e)
      if (const auto first = step_.first_of(slots[e]); first >= 0)
        F.segment<3>(first) -= step_.inverse_mass(slots[e]) * impulse.template segment<3>(3 * static_cast<Eigen::Index>(e));
    for (int k = 0; k < At::rows; ++k) {
      const auto n = static_cast<std::size_t>(k);
      F[rows + row + k] = (at.value[n][0] + c.compliance[n] * lambda[k] / h + c.damping * D.col(k).dot(v)) / (h + c.damping);
    }
  });
  return F;
}

// The order of entries: the identity, then for each constraint its geometric stiffness, -W D with the transposed rows beside it,
// and its compliance. jacobian() follows it.
void ReferenceProblem::pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const {
  rows.clear(), columns.clear();
  const auto add = [&](auto row, auto column) {
    rows.push_back(static_cast<PetscInt>(row)), columns.push_back(static_cast<PetscInt>(column));
  };
  for (std::size_t i = 0; i < step_.velocities(); ++i) add(i, i);
  step_.for_each_constraint([&]<class C>(const Constraint<C>&, const std::array<Slot, C::stencil>& slots, Eigen::Index first) {
    using At = Local<C>;
    const Eigen::Index row = static_cast<Eigen::Index>(step_.velocities()) + first;
    const auto unknown = [&](int j) {
      const std::ptrdiff_t of = step_.first_of(slots[static_cast<std::size_t>(j / 3)]);
      return of < 0 ? -1 : of + j % 3;
    };
    for (int j = 0; j < At::coordinates; ++j)
      for (int i = 0; i < At::coordinates; ++i) add(unknown(i), unknown(j));
    for (int k = 0; k < At::rows; ++k) {
      for (int i = 0; i < At::coordinates; ++i) add(unknown(i), row + k), add(row + k, unknown(i));
      add(row + k, row + k);
    }
  });
}

void ReferenceProblem::jacobian(const Eigen::VectorXd& u, std::vector<double>& values) const {
  values.assign(step_.velocities(), 1);
  const double h = step_.step();
  const auto rows = static_cast<Eigen::Index>(step_.velocities());
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    const auto [x, v] = step_.ends<C>(slots, u);
    typename At::Place w;
    for (std::size_t e = 0; e < C::stencil; ++e)
      w.template segment<3>(3 * static_cast<Eigen::Index>(e)).setConstant(step_.inverse_mass(slots[e]));
    const auto D = At::gradient(At::evaluate(c, {x, x, x, x}), 0);
    const auto H = At::second_derivatives(c, x);
    typename At::Hessian stiffness = At::Hessian::Zero();
    for (int k = 0; k < At::rows; ++k) stiffness += u[rows + row + k] * H[static_cast<std::size_t>(k)];
    for (int j = 0; j < At::coordinates; ++j)
      for (int i = 0; i < At::coordinates; ++i) values.push_back(-h * w[i] * stiffness(i, j));
    const double over = 1 / (h + c.damping);
    for (int k = 0; k < At::rows; ++k) {
      const auto n = static_cast<std::size_t>(k);
      const typename At::Place turn = H[n] * v;  // dD/dt: how the damped direction turns
      for (int i = 0; i < At::coordinates; ++i) {
        values.push_back(-w[i] * D(i, k));
        values.push_back(D(i, k) + h * c.damping * over * turn[i]);
      }
      values.push_back(std::max(c.compliance[n], softening_) / h * over);
    }
  });
}

ConstraintMultipliers ReferenceProblem::multipliers(const Eigen::VectorXd& unknowns) const {
  return step_.multipliers(unknowns.tail(static_cast<Eigen::Index>(step_.rows())));
}

double ReferenceProblem::scale() const { return step_.largest_place() / step_.step() + step_.largest_speed(); }

namespace {

bool is_elastic(const ConstraintSet& constraints) {
  bool elastic = true;
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list)
      for (const double compliance : c.compliance) elastic = elastic && compliance > 0;
  });
  return elastic;
}

template <class Problem>
ReferenceStep solve(const Problem& problem, const ReferenceSettings& settings) {
  const NewtonResult result = newton(problem, settings);
  const auto velocities = static_cast<Eigen::Index>(problem.velocities());
  return {problem.velocity(result.unknowns),
          problem.multipliers(result.unknowns),
          result.iterations,
          result.residual,
          result.correction.head(velocities).lpNorm<Eigen::Infinity>(),
          result.converged,
          result.reason};
}

}  // namespace

ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted,
                             double step, const ReferenceSettings& settings) {
  if (is_elastic(constraints)) return solve(ElasticProblem(world, constraints, predicted, step), settings);
  return solve(ReferenceProblem(world, constraints, predicted, step, settings.softening), settings);
}

ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step,
                             const ReferenceSettings& settings) {
  return reference_step(world, constraints, predict_bodies(world, gravity, step), step, settings);
}

}  // namespace unibody
