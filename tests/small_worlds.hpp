// Small worlds for the tests of physics: a scene from bodies or from text, a simulation of it, and the sums of mechanics.
#pragma once

#include <memory>
#include <string>

#include "solve/free_motion.hpp"
#include "step/build.hpp"
#include "step/simulation.hpp"

namespace unibody::small_worlds {

// Solids of uniform density.
Body ball(double mass, double radius, const Vec3& position);
Body block(double mass, const Vec3& edges, const Vec3& position, const Quat& turn = Quat::Identity());
Body disc(double mass, double radius, const Vec3& position);
Body ground(const Vec3& position = Vec3::Zero(), const Vec3& up = Vec3::UnitZ());

// The same body with so much inertia that no force here turns it: a point mass.
Body without_turning(Body body);

// Adds one body; its id is the number of bodies before it.
Id add(Scene& scene, const Body& body);

// A scene with the solver's defaults, h = 16 ms and one friction coefficient.
Scene scene_with(double friction);

Scene scene_from_text(const std::string& text);

// A simulation on a communicator, with its scene.
class Experiment {
 public:
  explicit Experiment(Scene scene, MPI_Comm comm = MPI_COMM_SELF);
  StepReport step() { return last = simulation->step(); }
  void steps(int n) {
    for (int i = 0; i < n; ++i) step();
  }
  void seconds(double t) { steps(static_cast<int>(t / h() + 0.5)); }
  double h() const { return scene->time.frame / scene->time.substeps; }

  World& world() { return simulation->world; }
  std::size_t slot(Id id) const;  // of a body that is here
  BodyState state(Id id) const { return simulation->world.state(slot(id)); }
  Vec3 position(Id id) const { return state(id).position; }
  Vec3 velocity(Id id) const { return state(id).velocity; }

  // Of the state as it is: the largest penetration (m), and of one pair's contact points the smallest gap.
  double penetration();
  double gap(Id a, Id b);
  double normal_force(Id a, Id b) const;  // N, remembered from the last step

  double energy() const;          // J, kinetic and in the scene's uniform gravity; home bodies
  double kinetic_energy() const;  // J
  Vec3 momentum() const;          // kg m/s
  Vec3 angular_momentum() const;  // kg m^2/s, about the origin
  bool finite() const;

  std::unique_ptr<Scene> scene;
  std::unique_ptr<PhaseClock> clock;
  std::unique_ptr<Simulation> simulation;
  StepReport last;
};

// What a solver works on, made by hand from a world and contacts on one rank, with the predicted velocities.
struct Bench {
  World world;
  Contacts contacts;
  SolverSettings settings;
  double step = 0.016;
  bool planar = false;
  Vec3 gravity = Vec3::Zero();
  PhaseClock clock;
  Halo halo{MPI_COMM_SELF};
  Exchange exchange{halo, clock};
  System system;

  // One group in key order, with the Jacobi scaling.
  void build_for_jacobi();
  // Lays out the contacts with system.counts as it is: for a Jacobi solver, or for Gauss-Seidel where the counts are empty.
  void build(std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups);
  BuildContext context() const;  // of the contacts

  // One group a manifold, in the given order of manifold numbers.
  void build_sequential(std::span<const std::uint32_t> order);
  std::vector<std::int32_t> counts() const;  // pairs at each slot, the body that is nobody last
  void start(const Stage& stage);

 private:
  void predict();
};

}  // namespace unibody::small_worlds
