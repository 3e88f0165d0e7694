// A stage may stop when its natural residual allows it. The same residual decides whether its step counts as converged.
//
// A sweep tells by how much it changed its rows, which costs nothing and is about the residual, but not the residual: the steps
// of the Jacobi solvers are along bounds of the rows' own blocks, and rows that a sweep has passed are disturbed by those after
// them. So the change says when it is worth to measure the residual, and the residual whether the stage may stop.
#pragma once

#include "partition/exchange.hpp"
#include "solve/solver.hpp"

namespace unibody {

class StopTest {
 public:
  // tolerance: m; 0: the stage never stops early.
  StopTest(const System& system, const Exchange& exchange, double tolerance)
      : system_(system), exchange_(exchange), tolerance_(tolerance), worth_measuring_(tolerance) {}

  // change: m, the largest of a sweep over all ranks.
  bool is_worth_measuring(double change) const { return tolerance_ > 0 && change <= worth_measuring_; }

  // Whether the residual is within the tolerance, and if not, from which change on it is worth to be measured again. The bodies
  // must be those of the multipliers, and guests up to date. Collective.
  bool passes(double change);

  double residual() const { return residual_; }  // m, as measured last, over all ranks

 private:
  const System& system_;
  const Exchange& exchange_;
  double tolerance_, worth_measuring_, residual_ = 0;
};

}  // namespace unibody
