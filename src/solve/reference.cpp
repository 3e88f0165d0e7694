#include "solve/reference.hpp"

#include <petscsnes.h>

#include <limits>

#include "core/errors.hpp"
#include "solve/free_motion.hpp"

namespace unibody {

namespace {

// One constraint at one state: values, gradients as a matrix, and second derivatives.
template <class C>
struct Local {
  static constexpr int coordinates = 3 * static_cast<int>(C::stencil), rows = static_cast<int>(C::rows);
  using Place = Eigen::Matrix<double, coordinates, 1>;
  using Gradient = Eigen::Matrix<double, coordinates, rows>;
  using Hessian = Eigen::Matrix<double, coordinates, coordinates>;

  static constexpr auto pack(const std::array<Place, lanes>& places) {
    std::array<Vec3x4, C::stencil> x;
    for (std::size_t e = 0; e < C::stencil; ++e)
      for (std::size_t l = 0; l < lanes; ++l) {
        const auto at = places[l].template segment<3>(3 * static_cast<int>(e));
        x[e].x[l] = at[0], x[e].y[l] = at[1], x[e].z[l] = at[2];
      }
    return x;
  }

  static Rows<C::stencil, C::rows> evaluate(const Constraint<C>& c, const std::array<Place, lanes>& places) {
    std::array<Vec4d, C::parameter_names.size()> parameters;
    for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(c.parameters[p]);
    Rows<C::stencil, C::rows> at;
    C::evaluate(parameters, pack(places), at);
    return at;
  }

  static Gradient gradient(const Rows<C::stencil, C::rows>& at, std::size_t lane) {
    Gradient D;
    for (int k = 0; k < rows; ++k)
      for (int e = 0; e < static_cast<int>(C::stencil); ++e) {
        const Vec3x4& g = at.gradient[static_cast<std::size_t>(k)][static_cast<std::size_t>(e)];
        D.template block<3, 1>(3 * e, k) = Vec3(g.x[lane], g.y[lane], g.z[lane]);
      }
    return D;
  }

  // Fourth-order central differences of the gradients: the four lanes are the four points along one coordinate. At a thousandth
  // of the constraint's extent truncation and round-off are both about 1e-12.
  static std::array<Hessian, C::rows> second_derivatives(const Constraint<C>& c, const Place& x) {
    double extent = 0;
    for (int e = 3; e < coordinates; e += 3) extent = std::max(extent, (x.template segment<3>(e) - x.template head<3>()).norm());
    const double d = extent > 0 ? 1e-3 * extent : 1e-3;
    std::array<Hessian, C::rows> H;
    for (int j = 0; j < coordinates; ++j) {
      std::array<Place, lanes> places{x, x, x, x};
      places[0][j] += d, places[1][j] -= d, places[2][j] += 2 * d, places[3][j] -= 2 * d;
      const auto at = evaluate(c, places);
      const Gradient slope = (8 * (gradient(at, 0) - gradient(at, 1)) - (gradient(at, 2) - gradient(at, 3))) / (12 * d);
      for (int k = 0; k < rows; ++k) H[static_cast<std::size_t>(k)].col(j) = slope.col(k);
    }
    for (Hessian& h : H) h = (0.5 * (h + h.transpose())).eval();
    return H;
  }
};

void check(PetscErrorCode code) {
  if (code) throw RunError("PETSc error " + std::to_string(code) + " in the reference solver");
}

}  // namespace

ReferenceProblem::ReferenceProblem(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step)
    : world_(world), constraints_(constraints), step_(step) {
  if (world.guests > 0) throw RunError("the reference solver needs all bodies on one rank");
  for (std::size_t i = 0; i < world.size(); ++i) {
    const SolverBody body = predict_motion(world.properties[i], world.state(i), gravity, step, false).body;
    predicted_.emplace_back(body.v);
    inverse_mass_.push_back(body.inverse_mass);
    first_of_.push_back(body.inverse_mass > 0 ? static_cast<std::ptrdiff_t>(velocities_) : -1);
    if (body.inverse_mass > 0) velocities_ += 3;
  }
  for_each_type(constraints, [&](auto type, const auto& list) {
    for (const auto& c : list) {
      auto& slots = std::get<type.value>(slots_).emplace_back();
      for (std::size_t e = 0; e < slots.size(); ++e) slots[e] = world.find(c.ids[e]);
      rows_ += c.compliance.size();
    }
  });
}

template <typename F>
void ReferenceProblem::for_each_constraint(F&& f) const {
  std::size_t row = velocities_;
  for_each_type(constraints_, [&](auto type, const auto& list) {
    for (std::size_t i = 0; i < list.size(); row += list[i].compliance.size(), ++i)
      f(list[i], std::get<type.value>(slots_)[i], static_cast<Eigen::Index>(row));
  });
}

Vec3 ReferenceProblem::velocity_of(Slot slot, const Eigen::VectorXd& unknowns) const {
  const auto s = static_cast<std::size_t>(slot);
  return first_of_[s] < 0 ? predicted_[s] : Vec3(unknowns.segment<3>(first_of_[s]));
}

Eigen::VectorXd ReferenceProblem::start() const {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size()));
  for (std::size_t s = 0; s < world_.size(); ++s)
    if (first_of_[s] >= 0) u.segment<3>(first_of_[s]) = predicted_[s];
  return u;
}

Eigen::VectorXd ReferenceProblem::residual(const Eigen::VectorXd& u) const {
  Eigen::VectorXd F = u - start();
  for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    typename At::Place x, v;
    for (std::size_t e = 0; e < C::stencil; ++e) {
      const auto first = 3 * static_cast<Eigen::Index>(e);
      v.template segment<3>(first) = velocity_of(slots[e], u);
      x.template segment<3>(first) = world_.position[static_cast<std::size_t>(slots[e])] + step_ * v.template segment<3>(first);
    }
    const auto at = At::evaluate(c, {x, x, x, x});
    const auto D = At::gradient(at, 0);
    const auto lambda = u.segment<At::rows>(row);
    const typename At::Place impulse = D * lambda;
    for (std::size_t e = 0; e < C::stencil; ++e) {
      const auto s = static_cast<std::size_t>(slots[e]);
      if (first_of_[s] >= 0)
        F.segment<3>(first_of_[s]) -= inverse_mass_[s] * impulse.template segment<3>(3 * static_cast<Eigen::Index>(e));
    }
    for (int k = 0; k < At::rows; ++k) {
      const auto n = static_cast<std::size_t>(k);
      F[row + k] = (at.value[n][0] + c.compliance[n] * lambda[k] / step_ + c.damping * D.col(k).dot(v)) / (step_ + c.damping);
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
  for (std::size_t i = 0; i < velocities_; ++i) add(i, i);
  for_each_constraint([&]<class C>(const Constraint<C>&, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    const auto unknown = [&](int j) {
      const std::ptrdiff_t first = first_of_[static_cast<std::size_t>(slots[static_cast<std::size_t>(j / 3)])];
      return first < 0 ? -1 : first + j % 3;
    };
    for (int j = 0; j < At::coordinates; ++j)
      for (int i = 0; i < At::coordinates; ++i) add(unknown(i), unknown(j));
    for (int k = 0; k < At::rows; ++k) {
      for (int i = 0; i < At::coordinates; ++i) add(unknown(i), row + k), add(row + k, unknown(i));
      add(row + k, row + k);
    }
  });
}

void ReferenceProblem::jacobian(const Eigen::VectorXd& u, double softening, std::vector<double>& values) const {
  values.assign(velocities_, 1);
  for_each_constraint([&]<class C>(const Constraint<C>& c, const std::array<Slot, C::stencil>& slots, Eigen::Index row) {
    using At = Local<C>;
    typename At::Place x, v, w;
    for (std::size_t e = 0; e < C::stencil; ++e) {
      const auto first = 3 * static_cast<Eigen::Index>(e);
      const auto s = static_cast<std::size_t>(slots[e]);
      v.template segment<3>(first) = velocity_of(slots[e], u);
      w.template segment<3>(first).setConstant(inverse_mass_[s]);
      x.template segment<3>(first) = world_.position[s] + step_ * v.template segment<3>(first);
    }
    const auto D = At::gradient(At::evaluate(c, {x, x, x, x}), 0);
    const auto H = At::second_derivatives(c, x);
    typename At::Hessian stiffness = At::Hessian::Zero();
    for (int k = 0; k < At::rows; ++k) stiffness += u[row + k] * H[static_cast<std::size_t>(k)];
    for (int j = 0; j < At::coordinates; ++j)
      for (int i = 0; i < At::coordinates; ++i) values.push_back(-step_ * w[i] * stiffness(i, j));
    const double over = 1 / (step_ + c.damping);
    for (int k = 0; k < At::rows; ++k) {
      const auto n = static_cast<std::size_t>(k);
      const typename At::Place turn = H[n] * v;  // dD/dt: how the damped direction turns
      for (int i = 0; i < At::coordinates; ++i) {
        values.push_back(-w[i] * D(i, k));
        values.push_back(D(i, k) + step_ * c.damping * over * turn[i]);
      }
      values.push_back(std::max(c.compliance[n], softening) / step_ * over);
    }
  });
}

std::vector<Vec3> ReferenceProblem::velocity(const Eigen::VectorXd& unknowns) const {
  std::vector<Vec3> v;
  for (std::size_t s = 0; s < world_.size(); ++s) v.push_back(velocity_of(static_cast<Slot>(s), unknowns));
  return v;
}

ConstraintMultipliers ReferenceProblem::multipliers(const Eigen::VectorXd& unknowns) const {
  ConstraintMultipliers result;
  auto row = static_cast<Eigen::Index>(velocities_);
  for_each_type(constraints_, [&](auto type, const auto& list) {
    auto& of_type = std::get<type.value>(result);
    of_type.resize(list.size());
    for (auto& one : of_type)
      for (double& lambda : one) lambda = unknowns[row++];
  });
  return result;
}

double ReferenceProblem::scale() const {
  double place = 0, speed = 0;
  for (std::size_t s = 0; s < world_.size(); ++s) {
    if (first_of_[s] < 0) continue;
    place = std::max(place, world_.position[s].norm()), speed = std::max(speed, predicted_[s].norm());
  }
  return place / step_ + speed;
}

namespace {

// SNES and what it works on, serial.
class Newton {
 public:
  Newton(const ReferenceProblem& problem, const ReferenceSettings& settings) : problem_(problem), settings_(settings) {
    const auto n = static_cast<PetscInt>(problem.size());
    check(VecCreateSeq(PETSC_COMM_SELF, n, &u_));
    check(VecDuplicate(u_, &residual_));
    std::vector<PetscInt> rows, columns;
    problem.pattern(rows, columns);
    check(MatCreate(PETSC_COMM_SELF, &jacobian_));
    check(MatSetSizes(jacobian_, n, n, n, n));
    check(MatSetType(jacobian_, MATSEQAIJ));
    check(MatSetPreallocationCOO(jacobian_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
    check(SNESCreate(PETSC_COMM_SELF, &snes_));
    check(SNESSetType(snes_, SNESNEWTONLS));
    check(SNESSetFunction(snes_, residual_, residual, this));
    check(SNESSetJacobian(snes_, jacobian_, jacobian_, jacobian, this));
    SNESLineSearch search;
    check(SNESGetLineSearch(snes_, &search));
    check(SNESLineSearchSetType(search, SNESLINESEARCHBT));
    factorise_directly();
  }
  ~Newton() { SNESDestroy(&snes_), MatDestroy(&jacobian_), VecDestroy(&residual_), VecDestroy(&u_); }
  Newton(const Newton&) = delete;
  Newton& operator=(const Newton&) = delete;

  // As far as round-off lets it: the last steps end at the floor of the residual, or in a line search that finds no descent.
  ReferenceStep solve() {
    const double floor = 2 * std::numeric_limits<double>::epsilon() * problem_.scale();
    check(SNESSetTolerances(snes_, floor, 0, 1e-15, settings_.iterations, 100 * settings_.iterations));
    put(problem_.start(), u_);
    check(SNESSolve(snes_, nullptr, u_));

    ReferenceStep step;
    const Eigen::VectorXd u = get(u_);
    PetscInt iterations = 0;
    const char* reason = nullptr;
    check(SNESGetIterationNumber(snes_, &iterations));
    check(SNESGetConvergedReasonString(snes_, &reason));
    step.iterations = static_cast<int>(iterations), step.reason = reason;
    step.velocity = problem_.velocity(u), step.multipliers = problem_.multipliers(u);
    step.residual = problem_.residual(u).lpNorm<Eigen::Infinity>();
    step.converged = step.residual <= settings_.tolerance * problem_.scale();
    return step;
  }

 private:
  void factorise_directly() {
    KSP ksp;
    PC pc;
    check(SNESGetKSP(snes_, &ksp));
    check(KSPSetType(ksp, KSPPREONLY));
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, PCLU));
#ifdef PETSC_HAVE_MUMPS
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    check(KSPSetOperators(ksp, jacobian_, jacobian_));
    check(PCFactorSetUpMatSolverType(pc));
    Mat factor;
    check(PCFactorGetMatrix(pc, &factor));
    check(MatMumpsSetIcntl(factor, 14, 400));  // % of room beyond its estimate: the zeros of stiff rows delay many pivots
#else                                          // PETSc's own does not pivot: it must not meet the zeros of stiff rows first
    check(PCFactorReorderForNonzeroDiagonal(pc, 1e-12));
#endif
  }

  static Eigen::VectorXd get(Vec from) {
    PetscInt n = 0;
    const PetscScalar* values = nullptr;
    VecGetLocalSize(from, &n);
    VecGetArrayRead(from, &values);
    Eigen::VectorXd result = Eigen::Map<const Eigen::VectorXd>(values, n);
    VecRestoreArrayRead(from, &values);
    return result;
  }
  static void put(const Eigen::VectorXd& from, Vec to) {
    PetscScalar* values = nullptr;
    VecGetArrayWrite(to, &values);
    Eigen::Map<Eigen::VectorXd>(values, from.size()) = from;
    VecRestoreArrayWrite(to, &values);
  }

  static PetscErrorCode residual(SNES, Vec u, Vec out, void* context) {
    put(static_cast<Newton*>(context)->problem_.residual(get(u)), out);
    return 0;
  }
  static PetscErrorCode jacobian(SNES, Vec u, Mat, Mat out, void* context) {
    auto* self = static_cast<Newton*>(context);
    self->problem_.jacobian(get(u), self->settings_.softening, self->values_);
    return MatSetValuesCOO(out, self->values_.data(), INSERT_VALUES);
  }

  const ReferenceProblem& problem_;
  const ReferenceSettings& settings_;
  SNES snes_ = nullptr;
  Mat jacobian_ = nullptr;
  Vec u_ = nullptr, residual_ = nullptr;
  std::vector<double> values_;
};

}  // namespace

ReferenceStep reference_step(const World& world, const ConstraintSet& constraints, const Vec3& gravity, double step,
                             const ReferenceSettings& settings) {
  const ReferenceProblem problem(world, constraints, gravity, step);
  return Newton(problem, settings).solve();
}

}  // namespace unibody
