#include "solve/stop_test.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "core/largest.hpp"

namespace unibody {

namespace {

constexpr double helps = 0.95;  // of the residual, which twice the iterations must leave no more of
constexpr int first_look = 50;
constexpr int most_idle = 2;  // doublings that do not

}  // namespace

StopTest::StopTest(const System& system, const Exchange& exchange, const StopRule& rule)
    : system_(system), exchange_(exchange), rule_(rule), worth_measuring_(target(0)) {
  if (rule_.hidden) next_look_ = first_look;
  if (rule_.least > 0) next_look_ = rule_.least;
}

bool StopTest::is_worth_measuring(double change, int done) {
  largest_change_ = std::max(largest_change_, or_infinity(change));
  return (target(done) > 0 && change <= worth_measuring_) || (done == next_look_ && looks(change, done));
}

// To measure restarts the momentum of the Jacobi solvers, to ask the rule does not.
bool StopTest::looks(double change, int done) {
  if (rule_.hidden && change <= StopRule::share_of_hidden * largest_change_)
    hides_ = change < StopRule::share_of_hidden * rule_.hidden();
  if (rule_.least > 0 || hides_) return true;
  next_look_ = 2 * done;
  return false;
}

bool StopTest::may_stop(double change, int done) {
  residual_ = 0;
  for (const double residual : residuals(system_)) residual_ = std::max(residual_, or_infinity(residual));
  residual_ = largest_of_ranks(exchange_.comm(), residual_);
  passed_ = residual_ <= target(done);
  if (passed_ || hides_) return true;
  // A little less than where the two would be in proportion, and never so soon that it is measured in every iteration.
  worth_measuring_ = change * std::min(0.7, 0.9 * target(done) / residual_);
  return done == next_look_ && gives_up(done);
}

bool StopTest::gives_up(int done) {
  next_look_ = std::max(2 * done, first_look);
  if (done < first_look) return false;
  idle_ = looked_ > 0 && residual_ > helps * looked_ ? idle_ + 1 : 0;
  looked_ = residual_;
  return idle_ >= most_idle;
}

}  // namespace unibody
