// A stage may stop when its natural residual allows it. The same residual decides whether its step counts as converged.
//
// A sweep tells by how much it changed its rows, which costs nothing and is about the residual, but not the residual: the steps
// of the Jacobi solvers are along bounds of the rows' own blocks, and rows that a sweep has passed are disturbed by those after
// them. So the change says when it is worth to measure the residual, and the residual whether the stage may stop.
//
// With an accuracy a stage has iterations enough to reach it, unless what is asked for cannot be: a body between jaws that close
// on it has no solution. Its residual is therefore also measured after some 50, 100, 200 ... iterations; where two doublings
// one after the other have taken less than a twentieth away, the stage gives up. After as many iterations a rule is asked what
// the rows hide, where it tells that and the change has fallen to a hundredth of its largest.
#pragma once

#include "partition/exchange.hpp"
#include "solve/solver.hpp"

namespace unibody {

class StopTest {
 public:
  StopTest(const System& system, const Exchange& exchange, const StopRule& rule);

  // After `done` sweeps, the last of which changed a row by at most `change` (m), over all ranks.
  bool is_worth_measuring(double change, int done);

  // Whether the stage may stop: the residual is within what the rule allows, or it is given up. If not, from which change on the
  // residual is worth to be measured again. The bodies must be those of the multipliers, and guests up to date. Collective.
  bool may_stop(double change, int done);

  double residual() const { return residual_; }  // m, as measured last, over all ranks
  bool passed() const { return passed_; }

 private:
  double target(int done) const { return done >= rule_.least ? rule_.allowed : rule_.tolerance; }
  bool gives_up(int done);
  bool looks(double change, int done);

  const System& system_;
  const Exchange& exchange_;
  StopRule rule_;
  double worth_measuring_, residual_ = 0;
  double largest_change_ = 0;      // m
  int next_look_ = -1, idle_ = 0;  // iterations after which the residual is looked at whatever the change; -1: none
  double looked_ = 0;              // m, the residual at the look before; 0: there was none
  bool hides_ = false;             // more than the rows have left
  bool passed_ = false;
};

}  // namespace unibody
