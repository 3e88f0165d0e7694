#include "solve/newton.hpp"

#include <petscsnes.h>

#include <cmath>
#include <limits>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr PetscInt large = 60'000;  // unknowns, above which the fill of a factor takes more than multigrid

// SNES and what it works on.
class Newton {
 public:
  Newton(const NewtonProblem& problem, const NewtonSettings& settings) : problem_(problem), settings_(settings) {
    const auto n = static_cast<PetscInt>(problem.size());
    check_petsc(VecCreateSeq(PETSC_COMM_SELF, n, &u_));
    check_petsc(VecDuplicate(u_, &residual_));
    make_jacobian(n);
    check_petsc(SNESCreate(PETSC_COMM_SELF, &snes_));
    check_petsc(SNESSetType(snes_, SNESNEWTONLS));
    check_petsc(SNESSetFunction(snes_, residual_, residual, this));
    check_petsc(SNESSetJacobian(snes_, jacobian_, jacobian_, jacobian, this));
    check_petsc(SNESSetDivergenceTolerance(snes_, -1));
    check_petsc(SNESSetForceIteration(snes_, PETSC_TRUE));  // polish() needs a Jacobian
    if (has_points_ && (settings.linear == LinearSolver::cg || (settings.linear == LinearSolver::automatic && n > large)))
      iterate_by_multigrid();
    else
      factorise_directly();
  }
  ~Newton() {
    check_petsc(SNESDestroy(&snes_)), check_petsc(MatDestroy(&jacobian_));
    check_petsc(VecDestroy(&residual_)), check_petsc(VecDestroy(&u_));
  }
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
    check_petsc(MatCreate(PETSC_COMM_SELF, &jacobian_));
    check_petsc(MatSetSizes(jacobian_, n, n, n, n));
    check_petsc(MatSetType(jacobian_, MATSEQAIJ));
    if (has_points_) check_petsc(MatSetBlockSize(jacobian_, 3));
    check_petsc(MatSetPreallocationCOO(jacobian_, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
    check_petsc(MatSetOption(jacobian_, MAT_SYMMETRIC, problem_.is_symmetric() ? PETSC_TRUE : PETSC_FALSE));
    check_petsc(MatSetOption(jacobian_, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
    if (has_points_) set_rigid_motions(points);
  }

  // What multigrid must carry to its coarse levels: an elastic body resists all else.
  void set_rigid_motions(const std::vector<Vec3>& points) {
    Vec places;
    MatNullSpace rigid;
    check_petsc(VecDuplicate(u_, &places));
    check_petsc(VecSetBlockSize(places, 3));
    put(Eigen::Map<const Eigen::VectorXd>(points.front().data(), 3 * static_cast<Eigen::Index>(points.size())), places);
    check_petsc(MatNullSpaceCreateRigidBody(places, &rigid));
    check_petsc(MatSetNearNullSpace(jacobian_, rigid));
    check_petsc(MatNullSpaceDestroy(&rigid));
    check_petsc(VecDestroy(&places));
  }

  // Solves as far as round-off lets it: the last steps end at the floor of the residual, or in a line search that finds no
  // descent.
  NewtonResult attempt(SNESLineSearchType type) {
    SNESLineSearch search;
    check_petsc(SNESGetLineSearch(snes_, &search));
    check_petsc(SNESLineSearchSetType(search, type));
    const double entries = has_points_ ? std::sqrt(static_cast<double>(problem_.size())) : 1;  // SNES takes the 2-norm
    const double floor = 2 * std::numeric_limits<double>::epsilon() * problem_.scale() * entries;
    check_petsc(SNESSetTolerances(snes_, floor, 0, 1e-15, settings_.iterations, 100 * settings_.iterations));
    put(problem_.start(), u_);
    check_petsc(SNESSolve(snes_, nullptr, u_));

    NewtonResult result;
    PetscInt iterations = 0;
    const char* reason = nullptr;
    check_petsc(SNESGetIterationNumber(snes_, &iterations));
    check_petsc(SNESGetConvergedReasonString(snes_, &reason));
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
    check_petsc(SNESGetKSP(snes_, &ksp));
    check_petsc(KSPSetType(ksp, problem_.is_symmetric() ? KSPCG : KSPGMRES));
    check_petsc(KSPSetTolerances(ksp, 1e-8, 0, PETSC_DEFAULT, 1000));
    check_petsc(KSPGetPC(ksp, &pc));
    check_petsc(PCSetType(pc, PCGAMG));
  }

  void factorise_directly() {
    KSP ksp;
    PC pc;
    check_petsc(SNESGetKSP(snes_, &ksp));
    check_petsc(KSPSetType(ksp, KSPPREONLY));
    check_petsc(KSPGetPC(ksp, &pc));
    check_petsc(PCSetType(pc, problem_.is_symmetric() ? PCCHOLESKY : PCLU));
#ifdef PETSC_HAVE_MUMPS
    check_petsc(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    check_petsc(KSPSetOperators(ksp, jacobian_, jacobian_));
    check_petsc(PCFactorSetUpMatSolverType(pc));
    Mat factor;
    check_petsc(PCFactorGetMatrix(pc, &factor));
    if (!has_points_) check_petsc(MatMumpsSetIcntl(factor, 14, 400));  // % of room: the zeros of stiff rows delay many pivots
#else  // PETSc's own does not pivot: it must not meet the zeros of stiff rows first
    if (!has_points_) check_petsc(PCFactorReorderForNonzeroDiagonal(pc, 1e-12));
#endif
  }

  Eigen::VectorXd correction(const Eigen::VectorXd& rest) {
    KSP ksp;
    check_petsc(SNESGetKSP(snes_, &ksp));
    put(rest, residual_);
    check_petsc(KSPSolve(ksp, residual_, u_));
    return get(u_);
  }

  static Eigen::VectorXd get(Vec from) {
    PetscInt n = 0;
    const PetscScalar* values = nullptr;
    check_petsc(VecGetLocalSize(from, &n));
    check_petsc(VecGetArrayRead(from, &values));
    Eigen::VectorXd result = Eigen::Map<const Eigen::VectorXd>(values, n);
    check_petsc(VecRestoreArrayRead(from, &values));
    return result;
  }
  static void put(const Eigen::VectorXd& from, Vec to) {
    PetscScalar* values = nullptr;
    check_petsc(VecGetArrayWrite(to, &values));
    Eigen::Map<Eigen::VectorXd>(values, from.size()) = from;
    check_petsc(VecRestoreArrayWrite(to, &values));
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
