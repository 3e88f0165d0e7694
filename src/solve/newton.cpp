#include "solve/newton.hpp"

#include <petscsnes.h>

#include <cmath>
#include <limits>

#include "core/errors.hpp"

namespace unibody {

namespace {

constexpr PetscInt large = 60'000;  // unknowns, above which the fill of a factor takes more than multigrid

void check(PetscErrorCode code) {
  if (code) throw RunError("PETSc error " + std::to_string(code) + " in the reference solver");
}

// SNES and what it works on.
class Newton {
 public:
  Newton(const NewtonProblem& problem, const NewtonSettings& settings) : problem_(problem), settings_(settings) {
    const auto n = static_cast<PetscInt>(problem.size());
    check(VecCreateSeq(PETSC_COMM_SELF, n, &u_));
    check(VecDuplicate(u_, &residual_));
    make_jacobian(n);
    check(SNESCreate(PETSC_COMM_SELF, &snes_));
    check(SNESSetType(snes_, SNESNEWTONLS));
    check(SNESSetFunction(snes_, residual_, residual, this));
    check(SNESSetJacobian(snes_, jacobian_, jacobian_, jacobian, this));
    check(SNESSetDivergenceTolerance(snes_, -1));
    check(SNESSetForceIteration(snes_, PETSC_TRUE));  // polish() needs a Jacobian
    if (has_points_ && (settings.linear == LinearSolver::cg || (settings.linear == LinearSolver::automatic && n > large)))
      iterate_by_multigrid();
    else
      factorise_directly();
  }
  ~Newton() { SNESDestroy(&snes_), MatDestroy(&jacobian_), VecDestroy(&residual_), VecDestroy(&u_); }
  Newton(const Newton&) = delete;
  Newton& operator=(const Newton&) = delete;

  NewtonResult solve() {
    if (!has_points_) return attempt(SNESLINESEARCHBT);
    const NewtonResult full = attempt(SNESLINESEARCHBASIC);
    if (full.converged) return full;
    NewtonResult result = attempt(SNESLINESEARCHBT);
    result.iterations += full.iterations;
    return result;
  }

 private:
  void make_jacobian(PetscInt n) {
    const std::vector<Vec3> points = problem_.points();
    has_points_ = !points.empty();
    std::vector<PetscInt> rows, columns;
    problem_.pattern(rows, columns);
    check(MatCreate(PETSC_COMM_SELF, &jacobian_));
    check(MatSetSizes(jacobian_, n, n, n, n));
    check(MatSetType(jacobian_, MATSEQAIJ));
    if (has_points_) check(MatSetBlockSize(jacobian_, 3));
    check(MatSetPreallocationCOO(jacobian_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
    check(MatSetOption(jacobian_, MAT_SYMMETRIC, problem_.is_symmetric() ? PETSC_TRUE : PETSC_FALSE));
    check(MatSetOption(jacobian_, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
    if (has_points_) set_rigid_motions(points);
  }

  // What multigrid must carry to its coarse levels: an elastic body resists all else.
  void set_rigid_motions(const std::vector<Vec3>& points) {
    Vec places;
    MatNullSpace rigid;
    check(VecDuplicate(u_, &places));
    check(VecSetBlockSize(places, 3));
    put(Eigen::Map<const Eigen::VectorXd>(points.front().data(), 3 * static_cast<Eigen::Index>(points.size())), places);
    check(MatNullSpaceCreateRigidBody(places, &rigid));
    check(MatSetNearNullSpace(jacobian_, rigid));
    check(MatNullSpaceDestroy(&rigid));
    check(VecDestroy(&places));
  }

  // As far as round-off lets it: the last steps end at the floor of the residual, or in a line search that finds no descent.
  NewtonResult attempt(SNESLineSearchType type) {
    SNESLineSearch search;
    check(SNESGetLineSearch(snes_, &search));
    check(SNESLineSearchSetType(search, type));
    const double entries = has_points_ ? std::sqrt(static_cast<double>(problem_.size())) : 1;  // SNES takes the 2-norm
    const double floor = 2 * std::numeric_limits<double>::epsilon() * problem_.scale() * entries;
    check(SNESSetTolerances(snes_, floor, 0, 1e-15, settings_.iterations, 100 * settings_.iterations));
    put(problem_.start(), u_);
    check(SNESSolve(snes_, nullptr, u_));

    NewtonResult result;
    PetscInt iterations = 0;
    const char* reason = nullptr;
    check(SNESGetIterationNumber(snes_, &iterations));
    check(SNESGetConvergedReasonString(snes_, &reason));
    result.iterations = static_cast<int>(iterations), result.reason = reason;
    result.unknowns = get(u_);
    result.residual = problem_.residual(result.unknowns).lpNorm<Eigen::Infinity>();
    result.converged = result.residual <= settings_.tolerance * problem_.scale();
    polish(result);
    return result;
  }

  // What is stiff has a residual's floor that soft motions lie below: a small residual is no small error. Newton steps by the
  // last Jacobian go on for as long as each is less than half of the one before.
  void polish(NewtonResult& result) {
    constexpr int most = 20;
    result.correction = correction(problem_.residual(result.unknowns));
    for (int i = 0; result.converged && i < most; ++i) {
      const Eigen::VectorXd next = result.unknowns - result.correction, rest = problem_.residual(next);
      const Eigen::VectorXd left = correction(rest);
      if (!(left.norm() < 0.5 * result.correction.norm())) return;
      result.unknowns = next, result.correction = left, result.residual = rest.lpNorm<Eigen::Infinity>();
      ++result.iterations;
    }
  }

  void iterate_by_multigrid() {
    KSP ksp;
    PC pc;
    check(SNESGetKSP(snes_, &ksp));
    check(KSPSetType(ksp, problem_.is_symmetric() ? KSPCG : KSPGMRES));
    check(KSPSetTolerances(ksp, 1e-8, 0, PETSC_DEFAULT, 1000));
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, PCGAMG));
  }

  void factorise_directly() {
    KSP ksp;
    PC pc;
    check(SNESGetKSP(snes_, &ksp));
    check(KSPSetType(ksp, KSPPREONLY));
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, problem_.is_symmetric() ? PCCHOLESKY : PCLU));
#ifdef PETSC_HAVE_MUMPS
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    check(KSPSetOperators(ksp, jacobian_, jacobian_));
    check(PCFactorSetUpMatSolverType(pc));
    Mat factor;
    check(PCFactorGetMatrix(pc, &factor));
    if (!has_points_) check(MatMumpsSetIcntl(factor, 14, 400));  // % of room: the zeros of stiff rows delay many pivots
#else  // PETSc's own does not pivot: it must not meet the zeros of stiff rows first
    if (!has_points_) check(PCFactorReorderForNonzeroDiagonal(pc, 1e-12));
#endif
  }

  Eigen::VectorXd correction(const Eigen::VectorXd& rest) {
    KSP ksp;
    check(SNESGetKSP(snes_, &ksp));
    put(rest, residual_);
    check(KSPSolve(ksp, residual_, u_));
    return get(u_);
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
    self->problem_.jacobian(get(u), self->values_);
    return MatSetValuesCOO(out, self->values_.data(), INSERT_VALUES);
  }

  const NewtonProblem& problem_;
  const NewtonSettings& settings_;
  SNES snes_ = nullptr;
  Mat jacobian_ = nullptr;
  Vec u_ = nullptr, residual_ = nullptr;
  std::vector<double> values_;
  bool has_points_ = false;
};

}  // namespace

NewtonResult newton(const NewtonProblem& problem, const NewtonSettings& settings) {
  if (problem.size() > 0) return Newton(problem, settings).solve();
  NewtonResult nothing;
  nothing.converged = true, nothing.reason = "no unknowns";
  return nothing;
}

}  // namespace unibody
