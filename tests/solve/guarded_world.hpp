// Worlds for the tests of the guard: velocities before and after it, and whether a motion leads through a face or an edge, by
// sampling it densely and not by the guard's own continuous tests.
#pragma once

#include <gtest/gtest.h>

#include "collide/surface_world.hpp"
#include "solve/surface_guard.hpp"

namespace unibody::samples {

// A world with velocities as the solve leaves them, and what the guard makes of them.
struct GuardedWorld : SurfaceWorld {
  static constexpr double h = 0.016;  // s
  std::vector<Vec3> solved, held;     // m/s, by id: before and after the guard
  std::vector<Vec3> before_solve;     // m/s, by id; empty: as after the solve
  std::vector<Id> pinned;
  std::int64_t count = 0;

  GuardedWorld() { settings.step = h; }

  Vec3& velocity(Id id) { return (*this)[id].state.velocity; }
  void move(Id first, Id nodes, const Vec3& v) {
    for (Id id = first; id < first + nodes; ++id) velocity(id) = v;
  }
  void set_mass(Id first, Id nodes, double mass) {
    for (Id id = first; id < first + nodes; ++id) (*this)[id].properties.mass = mass;
  }

  void guard() {
    Halo halo(MPI_COMM_SELF);
    build();
    for (const Id id : pinned) {
      const auto slot = static_cast<std::size_t>(world.find(id));
      BodyProperties properties = world.properties[slot];
      properties.motion = Motion::pinned;
      world.properties.set(slot, properties);
    }
    halo.refresh_guests(world, settings, known.get());
    std::vector<SolverBody> of_solver(world.size() + 1, SolverBody{});
    for (std::size_t i = 0; i < world.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        of_solver[i].v[k] = world.velocity[i][k];
        if (world.has_rotations) of_solver[i].w[k] = world.angular_velocity[i][k];
      }
    for (std::size_t i = 0; i < before_solve.size(); ++i)
      world.velocity[static_cast<std::size_t>(world.find(static_cast<Id>(i)))] = before_solve[i];
    count = SurfaceGuard(world, *known, settings, std::pmr::get_default_resource()).hold(of_solver, halo).pairs;
    solved.resize(bodies.size()), held.resize(bodies.size());
    for (std::size_t i = 0; i < world.size(); ++i) {
      const auto id = static_cast<std::size_t>(world.id[i]);
      solved[id] = bodies[id].state.velocity;
      held[id] = Eigen::Map<const Vec3>(of_solver[i].v);
      EXPECT_EQ(held[id], world.velocity[i]) << "the solver's velocity and the World's, of body " << id;
    }
  }

  // A body's place at the share t of the step, with the velocities before or after the guard.
  Vec3 at(Id id, double t, const std::vector<Vec3>& v) const {
    const auto i = static_cast<std::size_t>(id);
    return bodies[i].state.position + t * h * v[i];
  }
  Vec3 momentum(const std::vector<Vec3>& v) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i].properties.is_dynamic()) sum += bodies[i].properties.mass * v[i];
    return sum;
  }
  double kinetic_energy(const std::vector<Vec3>& v) const {
    double sum = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i].properties.is_dynamic()) sum += 0.5 * bodies[i].properties.mass * v[i].squaredNorm();
    return sum;
  }
};

// Signed volume of a tetrahedron, six times. Four moving points are in a plane where it changes its sign.
inline double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

// Whether the point goes through the face: its side changes from one of many moments to the next while it is over the face, by
// the signs of the three tetrahedra that the way between the two makes with the sides of the face.
inline bool passes_face(const GuardedWorld& w, const std::vector<Vec3>& v, Id point, const std::array<Id, 3>& face) {
  constexpr int samples = 4000;
  double before = 0;
  for (int i = 0; i <= samples; ++i) {
    const double t = static_cast<double>(i) / samples;
    const Vec3 p = w.at(point, t, v), a = w.at(face[0], t, v), b = w.at(face[1], t, v), c = w.at(face[2], t, v);
    const double side = volume(a, b, c, p);
    if (i > 0 && side * before <= 0) {
      const Vec3 n = (b - a).cross(c - a);
      if (n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0) return true;
    }
    before = side;
  }
  return false;
}

// Whether one edge goes through the other: where the four ends come into a plane, each edge's ends are on two sides of the other.
inline bool edges_pass(const GuardedWorld& w, const std::vector<Vec3>& v, const std::array<Id, 2>& e,
                       const std::array<Id, 2>& f) {
  constexpr int samples = 4000;
  double before = 0;
  for (int i = 0; i <= samples; ++i) {
    const double t = static_cast<double>(i) / samples;
    const Vec3 a = w.at(e[0], t, v), b = w.at(e[1], t, v), c = w.at(f[0], t, v), d = w.at(f[1], t, v);
    const double side = volume(a, b, c, d);
    if (i > 0 && side * before <= 0) {
      const Vec3 n = (b - a).cross(d - c);
      const auto of = [&](const Vec3& p, const Vec3& q, const Vec3& x) { return n.dot((q - p).cross(x - p)); };
      if (of(a, b, c) * of(a, b, d) <= 0 && of(c, d, a) * of(c, d, b) <= 0) return true;
    }
    before = side;
  }
  return false;
}

}  // namespace unibody::samples
