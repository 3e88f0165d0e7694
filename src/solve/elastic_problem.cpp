#include "solve/elastic_problem.hpp"

#include <algorithm>
#include <numeric>

namespace unibody {

namespace {

template <class C>
auto impulses(const Constraint<C>& c, const Rows<C::stencil, C::rows>& at, const typename Local<C>::Gradient& D,
              const typename Local<C>::Place& v, double h) {
  Eigen::Matrix<double, Local<C>::rows, 1> lambda;
  for (int k = 0; k < Local<C>::rows; ++k) {
    const auto n = static_cast<std::size_t>(k);
    lambda[k] = -h * (at.value[n][0] + c.damping * D.col(k).dot(v)) / c.compliance[n];
  }
  return lambda;
}

}  // namespace

ElasticProblem::ElasticProblem(const World& world, const ConstraintSet& constraints, std::span<const SolverBody> predicted,
                               double step)
    : step_(world, constraints, predicted, step) {
  for (std::size_t s = 0; s < step_.slots(); ++s) {
    const auto slot = static_cast<Slot>(s);
    if (step_.first_of(slot) < 0) continue;
    points_.push_back(step_.place(slot)), mass_.push_back(1 / step_.inverse_mass(slot));
  }
  if (!mass_.empty()) mean_mass_ = std::accumulate(mass_.begin(), mass_.end(), 0.0) / static_cast<double>(mass_.size());
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list) damped_ = damped_ || c.damping > 0;
  });
  find_neighbours();
}

void ElasticProblem::find_neighbours() {
  std::vector<std::vector<std::ptrdiff_t>> of(points_.size());
  for (std::size_t a = 0; a < of.size(); ++a) of[a].push_back(static_cast<std::ptrdiff_t>(a));
  step_.for_each_constraint([&](const auto&, const auto& slots, Eigen::Index) {
    for (const Slot s : slots)
      for (const Slot t : slots) {
        const std::ptrdiff_t a = step_.first_of(s), b = step_.first_of(t);
        if (a < 0 || b < 0) continue;
        auto& row = of[static_cast<std::size_t>(a / 3)];
        if (const auto at = std::lower_bound(row.begin(), row.end(), b / 3); at == row.end() || *at != b / 3)
          row.insert(at, b / 3);
      }
  });
  first_block_ = {0};
  for (const auto& row : of) {
    neighbours_.insert(neighbours_.end(), row.begin(), row.end());
    first_block_.push_back(neighbours_.size());
  }
}

std::size_t ElasticProblem::block(std::ptrdiff_t a, std::ptrdiff_t b) const {
  const auto row = neighbours_.begin() + static_cast<std::ptrdiff_t>(first_block_[static_cast<std::size_t>(a)]);
  const auto end = neighbours_.begin() + static_cast<std::ptrdiff_t>(first_block_[static_cast<std::size_t>(a) + 1]);
  return static_cast<std::size_t>(std::lower_bound(row, end, b) - neighbours_.begin());
}

Eigen::VectorXd ElasticProblem::start() const {
  const Eigen::VectorXd predicted = step_.predicted(), none = Eigen::VectorXd::Zero(predicted.size());
  return residual(predicted).norm() <= residual(none).norm() ? predicted : none;
}

Eigen::VectorXd ElasticProblem::residual(const Eigen::VectorXd& u) const {
  Eigen::VectorXd F = u - step_.predicted();
  for (std::size_t a = 0; a < mass_.size(); ++a) F.segment<3>(3 * static_cast<Eigen::Index>(a)) *= mass_[a];
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index) {
    using At = Local<C>;
    const auto [x, v] = step_.ends<C>(slots, u);
    const auto at = At::evaluate(c, {x, x, x, x});
    const auto D = At::gradient(at, 0);
    const typename At::Place impulse = D * impulses(c, at, D, v, step_.step());
    for (std::size_t e = 0; e < C::stencil; ++e)
      if (const auto first = step_.first_of(slots[e]); first >= 0)
        F.segment<3>(first) -= impulse.template segment<3>(3 * static_cast<Eigen::Index>(e));
  });
  return F / mean_mass_;
}

// Block by block, each by rows.
void ElasticProblem::pattern(std::vector<PetscInt>& rows, std::vector<PetscInt>& columns) const {
  rows.clear(), columns.clear();
  for (std::size_t a = 0; a < points_.size(); ++a)
    for (std::size_t n = first_block_[a]; n < first_block_[a + 1]; ++n)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::ptrdiff_t j = 0; j < 3; ++j) {
          rows.push_back(static_cast<PetscInt>(3 * a + i));
          columns.push_back(static_cast<PetscInt>(3 * neighbours_[n] + j));
        }
}

void ElasticProblem::jacobian(const Eigen::VectorXd& u, std::vector<double>& values) const {
  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  values.assign(9 * neighbours_.size(), 0);
  const double h = step_.step();
  for (std::size_t a = 0; a < mass_.size(); ++a) {
    const auto point = static_cast<std::ptrdiff_t>(a);
    Block(&values[9 * block(point, point)]).diagonal().setConstant(mass_[a] / mean_mass_);
  }
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index) {
    using At = Local<C>;
    const auto [x, v] = step_.ends<C>(slots, u);
    const auto at = At::evaluate(c, {x, x, x, x});
    const auto D = At::gradient(at, 0);
    const auto H = At::second_derivatives(c, x);
    const auto lambda = impulses(c, at, D, v, h);
    typename At::Hessian K = At::Hessian::Zero();
    for (int k = 0; k < At::rows; ++k) {
      const auto n = static_cast<std::size_t>(k);
      typename At::Place slope = (h + c.damping) * D.col(k);  // of c + rho D^T v by v
      if (c.damping > 0) slope += h * c.damping * (H[n] * v);
      K += h / c.compliance[n] * D.col(k) * slope.transpose() - h * lambda[k] * H[n];
    }
    K /= mean_mass_;
    for (std::size_t e = 0; e < C::stencil; ++e)
      for (std::size_t f = 0; f < C::stencil; ++f) {
        const std::ptrdiff_t a = step_.first_of(slots[e]), b = step_.first_of(slots[f]);
        if (a >= 0 && b >= 0)
          Block(&values[9 * block(a / 3, b / 3)]) += K.template block<3, 3>(3 * static_cast<int>(e), 3 * static_cast<int>(f));
      }
  });
}

ConstraintMultipliers ElasticProblem::multipliers(const Eigen::VectorXd& u) const {
  Eigen::VectorXd all(static_cast<Eigen::Index>(step_.rows()));
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    const auto [x, v] = step_.ends<C>(slots, u);
    const auto at = At::evaluate(c, {x, x, x, x});
    all.segment<At::rows>(row) = impulses(c, at, At::gradient(at, 0), v, step_.step());
  });
  return step_.multipliers(all);
}

double ElasticProblem::scale() const {
  const double place = step_.largest_place(), speed = step_.largest_speed();
  std::vector<double> of(mass_);
  for (double& momentum : of) momentum *= speed;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size()));
  step_.for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index) {
    using At = Local<C>;
    const auto x = step_.ends<C>(slots, none).first;
    const auto D = At::gradient(At::evaluate(c, {x, x, x, x}), 0);
    for (int k = 0; k < At::rows; ++k) {
      const double impulse =
          step_.step() / c.compliance[static_cast<std::size_t>(k)] * D.col(k).norm() * (place + c.damping * speed);
      for (std::size_t e = 0; e < C::stencil; ++e)
        if (const auto first = step_.first_of(slots[e]); first >= 0)
          of[static_cast<std::size_t>(first / 3)] += impulse * D.col(k).template segment<3>(3 * static_cast<int>(e)).norm();
    }
  });
  return of.empty() ? 0 : *std::max_element(of.begin(), of.end()) / mean_mass_;
}

}  // namespace unibody
