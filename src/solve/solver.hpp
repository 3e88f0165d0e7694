// Solvers: each takes a System and makes its multipliers satisfy one stage's rows. One file a solver, one signature, one table.
#pragma once

#include <functional>
#include <memory_resource>
#include <string>
#include <string_view>
#include <vector>

#include "constraints/attachment_batch.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/rolling_batch.hpp"
#include "constraints/solver_settings.hpp"
#include "constraints/surface_batch.hpp"
#include "constraints/system.hpp"
#include "joints/joint_batch.hpp"
#include "partition/cut.hpp"

namespace unibody {

class ConstraintBatches;

// Everything one step's solve works on. Bodies: homes, guests, statics, and one body that is nobody, for empty lanes.
struct System {
  explicit System(std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : bodies(memory),
        moving(memory),
        inertia(memory),
        isotropic(memory),
        gyroscopic(memory),
        wrenches(memory),
        impulses(memory),
        contacts(memory),
        rolling(memory),
        surface(memory),
        attachment_rows(memory),
        places(memory),
        moved_places(memory),
        counts(memory),
        counted(memory) {}

  std::size_t homes = 0;
  std::size_t first_static = 0;  // slot from which on bodies are static: pinned nodes, guests too, stand before it
  std::pmr::vector<SolverBody> bodies;
  std::pmr::vector<SolverBody> moving;       // with whose velocities bodies move, where they end with others; else empty
  std::pmr::vector<InverseInertia> inertia;  // of each body that is not isotropic; empty where all are
  std::pmr::vector<std::uint8_t> isotropic;  // of each body: SolverBody::inverse_inertia says it all
  std::pmr::vector<Vec3> gyroscopic;         // kg m^2/s, like `inertia`: momentum that the predicted spin leaves out
  std::pmr::vector<Wrench> wrenches;         // of each body; zero between sweeps; empty where nothing touches
  std::pmr::vector<Vec4d> impulses;          // N s; the same of constraints beside contacts, which turn nothing; may be empty
  ContactBatch contacts;
  RollingBatch rolling;  // of these contacts
  SurfaceBatch surface;
  bool any_surface = false;  // some rank has contacts of surfaces
  AttachmentBatch attachment_rows;
  AttachmentBatch* attachments = nullptr;    // where the scene has any, in stages that have them
  JointBatch* joints = nullptr;              // the same
  bool any_tree = false;                     // some of the scene's joints are solved as trees
  ConstraintBatches* constraints = nullptr;  // those beside the contacts, in stages that have them
  std::pmr::vector<Vec4d> places;  // of each body at the start of the step, and c_b / m_b; empty where contacts are all there is
  std::pmr::vector<Vec4d> moved_places;                // x + h v of each body, kept by sweeps of constraints; else empty
  std::pmr::vector<std::int32_t> counts;               // n_b of each body: its constraints of all kinds; empty for Gauss-Seidel
  double step = 0.016;                                 // s
  double stabilisation = -1;                           // see StepStart
  Acceleration acceleration = Acceleration::nesterov;  // of this stage: not automatic
  bool rotates = true;                                 // some body can turn: torques count
  std::pmr::vector<std::uint8_t> counted;              // of each manifold: this rank counts it in sums over all manifolds
  std::function<void()> before_iteration;  // re-evaluates the gaps at the present velocities; empty where they are frozen

  StepStart start() const { return {places, step, moved_places, stabilisation}; }

  // Home bodies: u += W (wrench, impulse), and their moved_places follow. Clears both. Guests follow by the next exchange.
  void apply_wrenches();

  // Brings moved_places up to date with the velocities, of bodies from `first` on. (Velocity level: nothing moves them.)
  void move_places(std::size_t first = 0);

 private:
  template <bool rotates>
  void apply();
  void turn(std::size_t i, Vec4d torque);  // u += W torque of home body i
};

struct SolveReport {
  int iterations = 0;
  int restarts = 0;     // of the momentum
  double residual = 0;  // m, the solver's own running residual in its last iteration; 0 where it was not asked to stop by it
  bool converged = false;
};

// Runs at most `iterations` iterations, fewer if every row changes by less than `tolerance` (m; 0: never stop early).
// Starts from the multipliers in the batch, whose impulses must have been applied. On return guests are up to date.
using SolveFunction = SolveReport (*)(System&, const Cut&, int iterations, double tolerance);

SolveReport accelerated_jacobi(System&, const Cut&, int iterations, double tolerance);
SolveReport jacobi(System&, const Cut&, int iterations, double tolerance);
SolveReport gauss_seidel(System&, const Cut&, int iterations, double tolerance);

// How two stages divide a step: SolverSettings says more of both.
struct Split {
  double velocity_share;  // of the iterations, the velocity stage's
  double leak;            // of the position stage's multipliers, kept by the velocity stage
  double swelling = 0;    // of g h: the coherent speed at which a pile may swell before nothing leaks; 0: any
};

struct Solver {
  std::string_view name;
  SolveFunction solve;             // null: `newton`, of which each step is a reference_step
  bool sweeps_by_colour;           // the batch is laid out by colour rather than in key order
  Split (*split)(int iterations);  // where the settings leave it to the solver
};

// The solver of that name; the scene reader has checked that there is one.
const Solver& find_solver(std::string_view name);

}  // namespace unibody
