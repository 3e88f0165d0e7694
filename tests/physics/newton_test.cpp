// Runs by the solver `newton`: conservation, energy, the statics of one huge step, and the air.
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>

#include "solve/elastic_bench.hpp"
#include "solve/elastic_problem.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds::newton_test {

namespace {

constexpr double young = 1e5, poisson = 0.3;
const std::string law = "density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3";
const std::string by_newton = "solver: {name: newton}\n";

// 1 m x 0.2 m x 0.2 m, held at one end.
Scene beam(const std::string& cells, double step, double gravity, const std::string& more = "") {
  std::ostringstream head;
  head << "gravity: [0, 0, " << gravity << "]\ntime: {frame: " << step << "}\n";
  return scene_from_text(
      head.str() + by_newton +
      block_text("[1, 0.2, 0.2]", cells,
                 "position: [0.5, 0, 0]\n    " + law + "\n    pins: [{within: {min: [0, -1, -1], max: [0, 1, 1]}}]" + more));
}

ElasticMesh mesh_at_rest(const Experiment& run) {
  run.simulation->make_constraints();
  return mesh_of(run.simulation->ties.constraints, run.simulation->world.position, lame(young, poisson));
}

}  // namespace

// Implicit Euler takes angular momentum from what turns: its elastic forces have no moment about the places at the end of the
// step, so that L changes by h sum m v x v_l, and by nothing else.
TEST(Newton, AFreeBlockKeepsItsMomentumAndGainsNoEnergy) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\n" + by_newton +
      block_text("[0.3, 0.2, 0.2]", "[3, 2, 2]", law + "\n    velocity: [1, 2, -1]\n    angular_velocity: [3, 8, 5]")));
  const ElasticMesh mesh = mesh_at_rest(run);
  samples::Random random(3);
  for (Vec3& x : run.world().position) x += random.vector(-0.01, 0.01);
  const auto energy = [&] { return run.kinetic_energy() + mesh.energy(run.world().position); };
  const Vec3 momentum = run.momentum();
  const double start = energy();
  double before = start;
  for (int k = 0; k < 100; ++k) {
    const std::vector<Vec3> old = run.world().velocity;
    const Vec3 angular = run.angular_momentum();
    run.step();
    Vec3 turned = Vec3::Zero();
    for (std::size_t i = 0; i < old.size(); ++i)
      turned += run.h() * run.world().properties[i].mass * run.world().velocity[i].cross(old[i]);
    EXPECT_LT((run.angular_momentum() - angular - turned).norm(), 1e-10 * angular.norm()) << k;
    EXPECT_TRUE(run.last.converged) << k;
    EXPECT_LE(energy(), before) << k;
    before = energy();
  }
  EXPECT_LT(before, 0.99 * start);
  EXPECT_LT((run.momentum() - momentum).norm(), 1e-10 * momentum.norm());
}

// The forces of an independent law balance weight and load at each node that moves, and a second step moves nothing.
TEST(Newton, OneHugeStepIsTheStaticEquilibrium) {
  for (const double gravity : {-0.1, -3.0}) {
    Experiment run(
        beam("[8, 2, 2]", 1e4, gravity, "\n    loads: [{within: {min: [1, -1, -1], max: [1, 1, 1]}, force: [5, 10, 0]}]"));
    const ElasticMesh mesh = mesh_at_rest(run);
    run.step();
    EXPECT_TRUE(run.last.converged);
    EXPECT_LT(run.last.residual, 1e-12);
    EXPECT_LT(run.last.iterations, 20);
    const World& world = run.world();
    const std::vector<Vec3> force = mesh.forces(world.position), places = world.position;
    double lowest = 0, weight = 0;
    for (std::size_t i = 0; i < world.size(); ++i) weight -= world.properties[i].mass * gravity;
    for (std::size_t i = 0; i < world.size(); ++i) {
      lowest = std::min(lowest, world.position[i].z());
      const BodyProperties of = world.properties[i];
      if (of.motion != Motion::dynamic) continue;
      EXPECT_LT((force[i] + of.force + of.mass * run.scene->gravity).norm(), 1e-8 * (weight + 11)) << i;
    }
    EXPECT_LT(lowest, gravity == -3 ? -0.4 : -0.1);
    run.step();
    for (std::size_t i = 0; i < world.size(); ++i) EXPECT_LT((world.position[i] - places[i]).norm(), 1e-8) << i;
  }
}

TEST(Newton, ItsImpulsesAreThoseOfTheLaw) {
  Experiment run(beam("[4, 1, 1]", 0.016, -9.8));
  run.steps(3);
  std::size_t count = 0;
  for_each_type(run.simulation->ties.constraints, [&]<class C>(auto, const ConstraintList<C>& list) {
    const auto& impulses = run.simulation->history.of<ConstraintBatch<C>>();
    ASSERT_EQ(impulses.size(), list.size());
    for (std::size_t i = 0; i < list.size(); ++i, ++count) {
      std::array<Vec4d, C::parameter_names.size()> parameters;
      std::array<Vec3x4, C::stencil> x;
      for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(list[i].parameters[p]);
      for (std::size_t e = 0; e < x.size(); ++e) {
        const Vec3& at = run.world().position[static_cast<std::size_t>(list[i].ids[e])];
        x[e] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())};
      }
      Rows<C::stencil, C::rows> rows;
      C::evaluate(parameters, x, rows);
      for (std::size_t k = 0; k < C::rows; ++k)
        EXPECT_NEAR(impulses[i][k], -0.016 * rows.value[k][0] / list[i].compliance[k], 1e-9) << i << ' ' << k;
    }
  });
  EXPECT_EQ(count, 20u);
}

// A beam of an even number of cells across, held at one end, sags straight down under its own weight: sideways it moves by
// nothing but round-off, whatever Poisson's ratio and its length in cells. (Cells split alike around one diagonal bent it by 14.7
// % of the sag.)
TEST(Newton, ABeamOfABlockBendsStraight) {
  for (const char* cells : {"[8, 2, 2]", "[9, 2, 2]", "[16, 4, 4]", "[8, 4, 2]"})
    for (const char* ratio : {"0", "0.3", "0.49"}) {
      Experiment run(scene_from_text(
          "time: {frame: 1.0e4}\nsolver: {name: newton}\nsolids:\n  - block: {size: [1, 0.2, 0.2], cells: " + std::string(cells) +
          "}\n    density: 1000\n    youngs_modulus: 1.0e7\n    poissons_ratio: " + ratio +
          "\n    thickness: 0.001\n    pins: [{within: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}]\n"));
      const std::vector<Vec3> start = run.world().position;
      run.step();
      ASSERT_TRUE(run.last.converged);
      Vec3 tip = Vec3::Zero();
      for (std::size_t i = 0; i < start.size(); ++i)
        if (start[i].x() > 0.49) tip += run.world().position[i] - start[i];
      EXPECT_LT(tip.z(), 0) << cells << ' ' << ratio;
      EXPECT_LT(std::abs(tip.y()), 1e-9 * std::abs(tip.z())) << cells << ' ' << ratio;
    }
}

// Too few iterations for a huge step: said, with how far the nodes still are from where they belong.
TEST(Newton, SaysWhereItDoesNotConverge) {
  Experiment run(beam("[8, 2, 2]", 1e4, -3));
  run.simulation->detect();
  ReferenceSettings settings;
  settings.iterations = 3;
  const ReferenceStep step = reference_step(run.world(), run.simulation->ties.constraints, run.scene->gravity, run.h(), settings);
  EXPECT_FALSE(step.converged);
  EXPECT_GT(run.h() * step.correction, 1e-3);
  EXPECT_EQ(step.reason, "DIVERGED_MAX_IT");
}

// The air's impulse is part of the prediction: the total form of an iterative solver converges to the same steps.
TEST(Newton, TheAirIsThatOfTheIterativeSolvers) {
  std::vector<Vec3> places;
  for (const bool newton : {true, false}) {
    Scene scene = scene_from_text(
        "wind: [0, 3, 1]\ncloths:\n  - grid: {size: [1, 1], nodes: [6, 6]}\n    mass: 0.5\n    thickness: 0.01\n    drag: 1\n    "
        "links: {stiffness: 500, damping: 0.01}\n    pins: [{node: [0, 0]}, {node: [5, 0]}]\n");
    scene.solver.tolerance = 0, scene.time.frame = 0.004;
    if (newton)
      scene.solver.name = "newton";
    else
      scene.solver.form = Form::total, scene.solver.iterations = 3000;
    Experiment run(std::move(scene));
    run.steps(10);
    if (newton) {
      EXPECT_TRUE(run.last.converged);
      places = run.world().position;
    } else {
      for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LT((run.world().position[i] - places[i]).norm(), 1e-9) << i;
    }
  }
}

// Where Gauss-Seidel of the total form converges, it does so to the same steps.
TEST(Newton, GaussSeidelOfTheTotalFormConvergesToItsSteps) {
  for (const std::string law : {"membrane: {youngs_modulus: 1.0e+4, poissons_ratio: 0.3}", "links: {diagonals: none}",
                                "links: {stiffness: 500, damping: 0.01}\n    bending: {model: dihedral, stiffness: 0.01}"}) {
    std::vector<Vec3> places;
    for (const bool newton : {true, false}) {
      Scene scene = scene_from_text("cloths:\n  - grid: {size: [1, 1], nodes: [5, 5]}\n    mass: 0.5\n    thickness: 0.01\n    " +
                                    law + "\n    pins: [{node: [0, 0]}, {node: [4, 4]}]\n    velocity: [0.3, 0.2, 1]\n");
      scene.solver.tolerance = 0, scene.time.frame = 0.004;
      scene.solver.name = newton ? "newton" : "gauss_seidel";
      if (!newton) scene.solver.form = Form::total, scene.solver.iterations = 2000;
      Experiment run(std::move(scene));
      const std::vector<Vec3> start = run.world().position;
      run.steps(5);
      if (newton) {
        EXPECT_TRUE(run.last.converged) << law;
        places = run.world().position;
      }
      for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LT((run.world().position[i] - places[i]).norm(), 1e-8) << law << i;
      EXPECT_GT((run.world().position[12] - start[12]).norm(), 0.01) << law;
    }
  }
}

namespace {

// The lowest mode of small vibrations about rest, by inverse iteration: frequency (rad/s) and shape (of the nodes that move,
// three entries each; largest 1).
struct Mode {
  double omega;
  Eigen::VectorXd shape;
};
Mode lowest_mode(Experiment& run) {
  run.simulation->detect();  // which makes the constraints and holds what is pinned
  const World& world = run.world();
  // At rest and with a step of 1 s the problem's Jacobian is (M + K) / m.
  const ElasticProblem problem(world, run.simulation->ties.constraints, predict_bodies(world, Vec3::Zero(), 1), 1);
  std::vector<PetscInt> rows, columns;
  std::vector<double> values;
  problem.pattern(rows, columns);
  problem.jacobian(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.size())), values);
  Eigen::VectorXd mass(static_cast<Eigen::Index>(problem.size()));
  Eigen::Index n = 0;
  for (std::size_t i = 0; i < world.size(); ++i)
    if (world.properties[i].motion == Motion::dynamic) mass.segment<3>(n).setConstant(world.properties[i].mass), n += 3;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < rows.size(); ++k) entries.emplace_back(rows[k], columns[k], values[k] * mass.mean());
  Eigen::SparseMatrix<double> K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  K.diagonal() -= mass;
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(K);
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 1; i < n; i += 3) shape[i] = 1;         // across, to the y axis: the lowest bending
  for (int k = 0; k < 5000; ++k) {                              // a bar's two bendings may be near each other
    const Eigen::VectorXd momentum = mass.cwiseProduct(shape);  // solve() does not know of aliases
    shape = factor.solve(momentum);
    shape /= shape.lpNorm<Eigen::Infinity>();
    const Eigen::VectorXd force = K * shape, inertia = mass.cwiseProduct(shape);
    const double square = shape.dot(force) / shape.dot(inertia);
    if ((force - square * inertia).norm() < 1e-6 * force.norm()) return {std::sqrt(square), shape};
  }
  ADD_FAILURE() << "no mode found";
  return {0, shape};
}

}  // namespace

// F7: f1 = 1.8751^2 / (2 pi L^2) sqrt(EI / (rho A)) of a slender bar, without its shear and rotary inertia, which take off some
// 1.7 (h / L)^2 = .2 % here (Timoshenko). Cubes of linear tetrahedra are too stiff, by a term of second order in their size:
// omega^2 is.
TEST(Newton, TheFirstBendingFrequencyConvergesWithOrderTwo) {
  constexpr double side = 0.05, length = 1, density = 1000;
  std::vector<double> square;  // omega^2
  for (const int across : {2, 4, 8}) {
    std::ostringstream cells;
    cells << '[' << 10 * across << ", " << across << ", " << across << ']';
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\n" + by_newton +
        block_text("[1, 0.05, 0.05]", cells.str(),
                   "position: [0.5, 0, 0]\n    density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0\n    pins: "
                   "[{within: {min: [0, -1, -1], max: [0, 1, 1]}}]")));
    square.push_back(std::pow(lowest_mode(run).omega, 2));
  }
  EXPECT_NEAR(std::log2((square[0] - square[1]) / (square[1] - square[2])), 2, 0.2);
  const double slender = 1.8751 * 1.8751 / (length * length) * std::sqrt(young * side * side / 12 / density);
  EXPECT_NEAR(std::sqrt(square[2] + (square[2] - square[1]) / 3) / slender, 1, 0.01);
}

// A step takes a mode w = omega q + i q' to w / (1 + i h omega): it falls by 1 / (1 + (h omega)^2) in energy and turns late.
TEST(Newton, AModeRingsAndFadesAsImplicitEulerHasIt) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\ntime: {frame: 0.1}\n" + by_newton +
      block_text("[1, 0.2, 0.4]", "[5, 2, 2]",
                 "position: [0.5, 0, 0]\n    " + law + "\n    pins: [{within: {min: [0, -1, -1], max: [0, 1, 1]}}]")));
  const Mode mode = lowest_mode(run);
  constexpr double size = 1e-6;  // m; the rest of the law is of second order in it
  World& world = run.simulation->world;
  const std::vector<Vec3> rest = world.position;
  Eigen::Index n = 0;
  std::vector<Eigen::Index> first(world.size(), -1);
  for (std::size_t i = 0; i < world.size(); ++i)
    if (world.properties[i].motion == Motion::dynamic) {
      world.position[i] += size * mode.shape.segment<3>(n);
      first[i] = n, n += 3;
    }
  const double turn = 0.1 * mode.omega;
  ASSERT_GT(turn, 0.1);
  std::complex<double> w = 1;
  for (int k = 0; k < 12; ++k) {
    run.step();
    w /= std::complex<double>(1, turn);
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (first[i] < 0) continue;
      const Vec3 expected = rest[i] + size * w.real() * mode.shape.segment<3>(first[i]);
      EXPECT_LT((world.position[i] - expected).norm(), 1e-4 * size) << k;
    }
  }
}

// A load far below the round-off of the stiffest rows bends the beam in proportion all the same.
TEST(Newton, ASmallLoadIsNotLostInTheFloorOfTheResidual) {
  const auto deflection = [](const char* force) {
    std::ostringstream text;
    text << "gravity: [0, 0, 0]\ntime: {frame: 1.0e+4}\n"
         << by_newton
         << block_text(
                "[1, 0.2, 0.2]", "[8, 2, 2]",
                std::string("position: [0.5, 0, 0]\n    density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.499\n"
                            "    pins: [{within: {min: [0, -1, -1], max: [0, 1, 1]}}]\n    loads: [{within: {min: [1, -1, "
                            "-1], max: [1, 1, 1]}, force: [0, 0, ") +
                    force + "]}]");
    Experiment run(scene_from_text(text.str()));
    run.step();
    EXPECT_TRUE(run.last.converged) << force;
    double lowest = 0;
    for (const Vec3& x : run.world().position) lowest = std::min(lowest, x.z() + 0.1);
    return lowest;
  };
  const double usual = deflection("-0.1");
  EXPECT_LT(usual, -1e-6);
  for (const auto& [force, part] : {std::pair{"-1.0e-3", 1e-2}, {"-1.0e-5", 1e-4}})
    EXPECT_NEAR(deflection(force) / usual, part, 1e-3 * part) << force;
}

// St. Venant-Kirchhoff has equilibria with elements turned inside out: a step that ends in one has not converged.
TEST(Newton, AnInvertedEquilibriumIsNoSolution) {
  Experiment run(beam("[8, 2, 2]", 1e4, -9.8));
  const ElasticMesh mesh = mesh_at_rest(run);
  run.step();
  int inverted = 0;
  for (const auto& cell : mesh.cells) inverted += ElasticMesh::edges(cell, run.world().position).determinant() < 0;
  EXPECT_GT(inverted, 0);
  EXPECT_FALSE(run.last.converged);
}

}  // namespace unibody::small_worlds::newton_test
