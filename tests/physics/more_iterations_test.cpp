// More iterations leave less error, also where cloths touch: the old force of a link, aimed before it turned, does not grow.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "scene/scene.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::more_iterations_test {

namespace {

struct Errors {
  double penetration = 0, residual = 0;  // m, means of the steps in which the cloth lies on the ball
  double deepest = 0, most_energy = 0;   // m, J
};

// A cloth of 51 x 51 nodes drapes a ball.
Errors errors_of(const char* solver, int iterations) {
  Experiment run(read_scene(UNIBODY_SOURCE_DIR "/scenes/cloth_on_sphere.yaml",
                            {{"solver.name", solver}, {"solver.iterations", std::to_string(iterations)}}));
  Errors errors;
  constexpr int steps = 60, first = 25;
  for (int k = 0; k < steps; ++k) {
    run.step();
    const double now = run.penetration();
    errors.deepest = std::max(errors.deepest, now), errors.most_energy = std::max(errors.most_energy, run.energy());
    if (k < first) continue;
    errors.penetration += now / (steps - first), errors.residual += run.last.residual / (steps - first);
  }
  return errors;
}

}  // namespace

TEST(MoreIterations, LeaveLessErrorInADrapedCloth) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const Errors few = errors_of(solver, 50), many = errors_of(solver, 400);
    EXPECT_LT(many.penetration, few.penetration) << solver;
    EXPECT_LT(many.residual, few.residual) << solver;
    EXPECT_LT(many.deepest, 0.02) << solver;           // a node's radius
    EXPECT_LE(many.most_energy, 9.8 * 1.0) << solver;  // of 1 kg that falls from 1 m
  }
}

}  // namespace unibody::small_worlds::more_iterations_test
