// What one step's solve works on beside the batches of constraints: the bodies, and what the constraints do to them.
//
// A contact is linear in the velocities inside a step (its gap is frozen, or linearised anew before each iteration), so the
// solvers move velocities only: u -> u + W D^T lambda. Bodies: homes, guests, statics, and one body that is nobody, for the empty
// lanes of blocks.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "constraints/solver_body.hpp"

namespace unibody {

// What a pass reads of the step: positions at its start with, as fourth component, c_b / m_b: the inverse mass times the factor
// by which its constraints together may move it further than each alone (Jacobi; see direction_sum.hpp), and the step.
struct StepStart {
  std::span<const Vec4d> places;             // x_l, y_l, z_l (m), c_b / m_b (1/kg)
  double step;                               // s
  std::span<const Vec4d> moved_places = {};  // the same at x_l + h v of the last sweep's velocities; for Jacobi sweeps alone
  double stabilisation = -1;                 // of the velocity level, whose rows are linear about x_l; else negative

  bool is_linear() const { return stabilisation >= 0; }
};

struct SolveState {
  explicit SolveState(std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : bodies(memory),
        moving(memory),
        inertia(memory),
        isotropic(memory),
        gyroscopic(memory),
        wrenches(memory),
        impulses(memory),
        places(memory),
        moved_places(memory),
        counts(memory) {}

  std::size_t homes = 0;
  std::size_t first_static = 0;  // slot from which on bodies are static: pinned nodes, guests too, stand before it
  std::pmr::vector<SolverBody> bodies;
  std::pmr::vector<SolverBody> moving;       // with whose velocities bodies move, where they end with others; else empty
  std::pmr::vector<InverseInertia> inertia;  // of each body that is not isotropic; empty where all are
  std::pmr::vector<std::uint8_t> isotropic;  // of each body: SolverBody::inverse_inertia says it all
  std::pmr::vector<Vec3> gyroscopic;         // kg m^2/s, like `inertia`: momentum that the predicted spin leaves out
  std::pmr::vector<Wrench> wrenches;         // of each body; zero between sweeps; empty where nothing touches
  std::pmr::vector<Vec4d> impulses;          // N s; the same of constraints between centres, which turn nothing; may be empty
  std::pmr::vector<Vec4d> places;  // of each body at the start of the step, and c_b / m_b; empty without constraints of centres
  std::pmr::vector<Vec4d> moved_places;   // x + h v of each body, kept by sweeps of those constraints; else empty
  std::pmr::vector<std::int32_t> counts;  // n_b of each body: its constraints of all kinds; empty for Gauss-Seidel
  double step = 0.016;                    // s
  double stabilisation = -1;              // share of an error that a step takes out (StepStart)
  bool rotates = true;                    // some body can turn: torques count
  bool keeps_places = false;              // in this stage constraints of centres act, which see moved_places

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

}  // namespace unibody
