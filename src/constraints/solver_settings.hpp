// Solver settings, as the scene's `solver` section gives them. Defaults hold for every scene: none must be tuned for stability.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace unibody {

// position: constraints hold at the end of the step (the paper's scheme). velocity: the time stepping of Anitescu and Hart
// (2004), with which the paper compares it (its figure 8): constraints are linear about the start of the step.
enum class Level { position, velocity };
inline constexpr std::array<std::string_view, 2> level_names{"position", "velocity"};

// ellipse: the disc where friction depends on the direction; not one that a scene asks for.
enum class FrictionModel { disc, cone, saxce, box, none, postprocess, ellipse };
inline constexpr std::array<std::string_view, 6> friction_model_names{"disc", "cone", "saxce", "box", "none", "postprocess"};

enum class Gap { frozen, reevaluated };
inline constexpr std::array<std::string_view, 2> gap_names{"frozen", "reevaluated"};

enum class Stages { automatic, two, together, position };
inline constexpr std::array<std::string_view, 4> stages_names{"auto", "two", "together", "position"};

// How sweeps are extrapolated: optimized, the optimized gradient method of Kim and Fessler (2016), which takes the step itself
// further as well; nesterov, the paper's, and Gauss-Seidel's; automatic: optimized in stages of accelerated_jacobi whose rows are
// all linear, or of links, at the scaling that bounds them (momentum.hpp); none: the plain method.
enum class Acceleration { automatic, optimized, nesterov, none };
inline constexpr std::array<std::string_view, 4> acceleration_names{"auto", "optimized", "nesterov", "none"};

// What the Jacobi solvers divide the steps of cloths, threads and solids by at each body: directions, by how far its constraints
// together may push it along one (direction_sum.hpp); count, the paper's, by their number.
enum class MassSharing { directions, count };
inline constexpr std::array<std::string_view, 2> mass_sharing_names{"directions", "count"};

enum class Order { coloured, sequential };
inline constexpr std::array<std::string_view, 2> order_names{"coloured", "sequential"};

// How constraints beside contacts are solved: incremental, robust, off implicit Euler by the turning of the gradients within a
// step; total, implicit Euler exactly where it converges.
// With auto, the tetrahedra of solids are solved in the total form where all of them are so soft that it is known to converge
// (scene/stiffness.hpp), except in steps in which their edges move too far. All other constraints are solved incrementally.
enum class Form { automatic, incremental, total };
inline constexpr std::array<std::string_view, 3> form_names{"auto", "incremental", "total"};

// The share of an edge by which its ends may move against each other within a step of the total form. A block of 1e5 Pa that
// spins by .64 rad a step converges with every solver, and by .96 with Gauss-Seidel alone; a cube thrown against what holds it
// converges at .41 and with none at .90.
inline constexpr double most_edge_motion = 0.5;

// How the joints' own rows are solved: iterative, each joint's as one block; direct, those of each tree of joints as one block.
enum class JointSolve { iterative, direct };
inline constexpr std::array<std::string_view, 2> joint_solve_names{"iterative", "direct"};

// The solvers there are, the default first; solver.cpp has the table.
std::vector<std::string> solver_names();

// The share of the old multipliers from which a position stage starts. What iterations leave undone is made up by the force of
// the step before; that force lags by a h / (1 - a) behind the motion, which takes as much from the damping h of the implicit
// step: a third leaves three quarters of it, 1/2 nothing.
//
// With more iterations less is left undone, and the old force does harm: its direction is that before the link turned, and with a
// third of it a cloth that folds gains energy at 400 iterations and more. Where the scene sets no share, a step therefore starts
// from automatic_share up to iterations_of_share iterations, and from a share that falls as 1 / iterations beyond them.
inline constexpr double automatic_share = 1.0 / 3;
inline constexpr int iterations_of_share = 50;

// With the optimized acceleration a link starts with no larger a geometric stiffness than this: h lambda (c_a / m_a + c_b / m_b)
// / l, lambda in N s, c the shares of mass. Across a link its impulse is explicit, aimed before the ends moved. At a node of a
// chain all of this adds up, at one of a cloth 2/3, and an explicit step bears 4: with 4 a loaded chain, and with 32 and more a
// cloth of 100 x 100 nodes swings up. A third of the old multipliers has up to 47 there, more than 4 in a twentieth of the links.
inline constexpr double most_geometric_stiffness = 2;

// Where a link has more than this, a third of the old multipliers given, "auto" keeps to Nesterov's momentum, without that bound:
// with loads of many times the nodes' own weight, which old multipliers carry on, and where large cloths fall far from converged.
inline constexpr double tight_links = 40;

// The share of the velocity level, whose correction of the positions is softer: there 1 / (1 + stabilisation) leaves nothing.
inline constexpr double automatic_velocity_share = 0.5;

// What "auto" comes to by the size of the smallest dynamic body (its least extent), so that a scene made smaller does the same.
inline constexpr double automatic_tolerance = 2e-5;            // of that size in a step of a whole frame, see plan.cpp;
inline constexpr double constrained_tolerance = 5e-5;          // of bodies with constraints beside contacts
inline constexpr double automatic_share_of_fall = 0.04;        // of g h^2: the tolerance is no more than this
inline constexpr double automatic_margin = 0.2;                // of that size,
inline constexpr double most_automatic_margin = 0.002;         // m, but no more than this
inline constexpr double automatic_toss = 1.0 / 3;              // of that size: how high what recovers may be thrown,
inline constexpr double most_automatic_recovery_speed = 0.25;  // m/s, but no faster than this, which is also that without gravity

// Accuracies that have a name, and the first of them for scenes that ask for none: by it their frames are judged.
struct NamedAccuracy {
  std::string_view name;
  double share;
};
inline constexpr std::array<NamedAccuracy, 3> named_accuracies{{{"film", 1e-2}, {"engineering", 1e-3}, {"reference", 1e-5}}};
inline constexpr double default_accuracy = named_accuracies[0].share;

// Where the scene does not say how many iterations a step may take: so many. A scene whose frames cost little (plan.cpp) may take
// more, and one with an accuracy: up to as many. A step that converges stops before.
inline constexpr int default_iterations = 50, most_automatic_iterations = 1000;

// The error of a step over its natural residual is taken to be no less than this, when the residual is found at which a stage
// stops: contacts of bodies in motion have 2 to 4, and as long as no sample has told of more, this is what is known.
inline constexpr double least_error_ratio = 3;

struct SolverSettings {
  std::string name = "accelerated_jacobi";  // one of solver_names()
  std::optional<int> iterations;            // most of a step, over both stages; >= 1 (two stages: >= 2); open: see above
  // The share of the smallest moving body's size, (0, 1], by which a frame may be off; open: the iterations are all that is
  // asked for. See docs/accuracy.md.
  std::optional<double> accuracy;
  // What is left open is decided by plan() (step/plan.hpp).
  std::optional<double> tolerance;  // m, natural residual at which a stage stops; 0: never; open: by the smallest body's size
  Acceleration acceleration = Acceleration::automatic;
  MassSharing mass_sharing = MassSharing::directions;
  Level level = Level::position;
  double stabilisation = 0.4;  // velocity level: gamma, share of an error of position that a step takes out; [0, 1]
  // two: a velocity stage with leak, then a position stage that only adds to it: least penetration at few iterations.
  // together: the position stage works on both stages' multipliers together: converges to the step's exact solution.
  // position: the position stage alone. auto: two, but position for Jacobi solvers in scenes with constraints beside contacts,
  // which have no part in a velocity stage: all iterations are theirs then, and bodies in contact penetrate less as well.
  Stages stages = Stages::automatic;
  // The share of the iterations that the velocity stage does where there are two stages (two or together), in (0, 1); open: by
  // solver and iterations. The more they are, the sooner what stands comes to rest; the others take out what is left of
  // penetration.
  std::optional<double> velocity_share;
  // Share of the old multipliers from which the position stage starts, [0, 1/2]: of constraints other than contacts, and of
  // contacts where it is the only stage. Open: automatic_share (less of many iterations), but nothing of
  // tetrahedra and of what touches them. Velocity level: [0, 1], of its one stage.
  std::optional<double> warm_start;
  Form form = Form::automatic;
  JointSolve joints = JointSolve::iterative;
  bool coarse = false;  // the position stage starts with Newton's method on a coarse level (step/coarse_level.hpp)
  // Share of the position stage's multipliers fed to the velocity stage of the next step, where that of this one has not
  // converged; [0, 1], open: by solver and iterations.
  std::optional<double> leak;
  FrictionModel friction = FrictionModel::disc;
  Gap gap = Gap::frozen;          // frozen: linear in the step; reevaluated: every iteration
  Order order = Order::coloured;  // gauss_seidel only; sequential: one rank only
  double scaling = 1;             // factor on the constraint count n_b of the Jacobi solvers; (0, 1]
  // The time constant (s) with which a position stage takes penetration out; 0: it takes all of it out in one step. Where the
  // scene leaves it open, it is the length of a frame for contacts of bodies, and 0 for contacts of the faces and edges of
  // surfaces.
  std::optional<double> recovery_time;
  std::optional<double> recovery_speed;  // m/s, bound on the speed at which penetration is taken out; 0: unbounded; open: by size
  std::optional<double> margin;  // m, contacts are made at gaps below this plus what bodies can travel in the step; open: by size
};

}  // namespace unibody
