// The last resort against passing through: after the solve, before bodies move.
//
// What contacts could not hold apart within the iterations, or turned towards each other, would pass through a surface in this
// step. Such pairs are found by continuous tests along the motion to come; the velocities of their ends are drawn together
// towards their common mean, just as far as keeps them apart. Momentum is kept where one pair acts on a body; energy is lost. A
// solve that converges leaves nothing to hold.
//
// Nodes that are held keep their velocities. Where some nodes of a face are held, at different ones, and others free, the pair is
// drawn to the mean of the held ones and may pass still if they turn the face by much.
//
// The surface of a solid is not held: what gets in is pushed out by contacts, and what is out of its place already would be kept
// there. Nodes of a solid are, by others' surfaces.
//
// Round bodies count by their centres, and are kept off by half of their radius, other dynamic solids by corners (boxes by all,
// capsules by the ends of their axes, cylinders and hulls by up to 14, compounds by those of their parts), on the straight way
// that they go while the solid turns; what holds a corner back acts on the solid's centre, and does not turn it. Corners of
// solids that are held are left to contacts: sheets drawn over one would be torn between it and each other. Pairs that were far
// apart for their velocities at the start of the step, and thrown at each other within it, are not looked for: a rank may not
// know of them.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "collide/broadphase.hpp"
#include "collide/collide_settings.hpp"
#include "collide/surfaces.hpp"
#include "constraints/solver_body.hpp"
#include "partition/halo.hpp"
#include "world/world.hpp"

namespace unibody {

class SurfaceGuard {
 public:
  SurfaceGuard(World& world, const Surfaces& surfaces, const CollideSettings& settings, std::pmr::memory_resource* memory);

  struct Held {
    std::int64_t pairs = 0;  // over all rounds and ranks
    std::array<Id, 2> not_held{-1,
                               -1};  // of a pair that will pass through each other yet: after most rounds; the same everywhere
  };

  // Changes the velocities (m/s) of home bodies; the World's are those that the step will end with. Collective.
  Held hold(std::span<SolverBody> bodies, Halo& halo);

 private:
  // The centre of a round body, or a corner of another.
  struct Point {
    Slot slot;
    int corner = -1;             // its number; of a box bit k: on the positive side of axis k
    Vec3 arm = Vec3::Zero();     // m, from the centre
    Vec3 turned = Vec3::Zero();  // m, by which turning moves it in the step
  };
  // A point and a face, or two edges: ends of the two sides one after the other.
  struct Candidate {
    std::array<Slot, 4> ends;
    const Point* point;  // null: edges
  };
  struct Hit {
    std::array<Id, 5> key;  // ids of the ends; 1: two edges, 2 and more: a corner
    Vec3 turning;           // m/s, velocity of the first end by turning
    std::array<Slot, 4> ends;
    std::array<double, 4> weights;  // of the points that meet: those of a side sum to 1
    double share;                   // of the motion against each other that they may keep
  };
  void list_features(std::span<const SolverBody> bodies, Halo& halo);
  void list_points(std::span<const Vec3> spins);
  std::vector<Vec3> spins(std::span<const SolverBody> bodies, Halo& halo);
  void find_pairs();
  void leave_out_distant();
  double kept(Slot s) const;
  Candidate candidate(const IndexPair& pair) const;
  void test(const Candidate& pair);
  Vec3 velocity_of(const Hit& hit, std::size_t end) const;
  Vec3 common_velocity(const Hit& hit) const;
  void draw_together(bool stop);
  std::array<Id, 2> first_pair(MPI_Comm comm) const;
  Bounds path(std::span<const Slot> nodes, std::span<const Vec3> velocity, double more) const;
  Bounds path(const Point& point, std::span<const Vec3> velocity, const Vec3& turned, double more) const;
  double slack(std::span<const Slot> nodes) const;

  World& world_;
  const Surfaces& surfaces_;
  const CollideSettings& settings_;
  std::vector<Vec3> start_;          // m/s, velocities before the solve
  std::vector<std::uint8_t> moved_;  // by slot: in the last round
  double face_size_ = 1;             // m, mean extent
  std::vector<Hit> hits_;
  std::vector<Point> points_;
  std::pmr::vector<Bounds> bounds_;  // of points, then of faces, then of edges
  std::pmr::vector<Role> roles_;
  std::pmr::vector<Filter> filters_;
  Pairs pairs_;
  BroadPhase broad_phase_;
};

}  // namespace unibody
