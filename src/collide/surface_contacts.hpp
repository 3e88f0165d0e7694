// Contacts with the surfaces of flexible bodies: bodies on faces and edges, nodes on faces, edges across edges.
//
// A pair that moves little in the step is taken as it stands, and only where its distance is least with regard to the neighbours
// as well: of a body over a flat cloth one face is a contact, not the edges and faces around. A pair that moves by more than its
// size is followed along the step (continuous.hpp) and touches where and how it first will. Velocities are those at the start of
// the step: what is turned aside within it may pass through what it was not heading for.
//
// Sides: two points that have passed each other in the last step, which an unconverged solve may let happen, are told to go back.
// Where they were follows from positions and velocities alone: a step ends with x += h v. Closed surfaces say themselves what is
// inside, however it got there: it is pushed out, at the speed of any penetration.
//
// Nodes touch bodies as the particles that they are (narrowphase.hpp); what is here is what lies between them.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "collide/approach.hpp"
#include "collide/contacts.hpp"
#include "collide/continuous.hpp"
#include "collide/narrowphase.hpp"
#include "collide/surfaces.hpp"
#include "collide/triangle_contacts.hpp"
#include "collide/triangle_distance.hpp"

namespace unibody {

// How far a direction may lean towards a neighbour, as a sine, and still count as least: without it a box that lies flat would
// lose contacts by a turn in the last bit.
constexpr double lean_of_boxes = 0.05, lean_of_points = 1e-9;

// Hits may be reported so much before the two touch.
inline ContinuousSettings continuous(double radii) { return {radii, std::min(1e-6, 0.01 * radii) + 1e-3 * radii, 200}; }

// Whether the weights of a face's nodes belong to one node alone. A segment has its second node twice: all of the weight goes
// to the first of the two.
bool is_one_node(const Vec3& weights);
Vec3 without_twin(const SurfaceFace& face, Vec3 weights);

class SurfaceCollider {
 public:
  // Adds to `contacts`.
  SurfaceCollider(const World& world, const Surfaces& surfaces, const CollideSettings& settings,
                  std::vector<SurfaceContact>& contacts)
      : world_(world), surfaces_(surfaces), settings_(settings), out_(contacts) {}

  void body_face(const Proxy& body, std::int32_t face);
  void node_face(Slot node, std::int32_t face);
  void edge_edge(std::int32_t first, std::int32_t second);

  // Puts the contacts in the order of their keys, each once.
  void finish();

 private:
  // Two points, one a side: means of the ends, those of the first side with positive weights.
  struct Pair {
    std::array<Slot, 4> slots{-1, -1, -1, -1};
    std::array<double, 4> weights{};
    double radii = 0;      // m, of both sides
    double spin = 0;       // m, what a turning end adds to the margin
    bool edges = false;    // two on each side
    bool turns = false;    // end 0 is a round body, touched off its centre
    bool within = false;   // both points lie inside their surfaces, so that a change of sides shows
    bool inside = false;   // of a closed surface: the points belong on the other sides
    bool watched = false;  // it is fast, and its motion leads past
    bool meets = false;    // ends without weight belong to the key
  };
  // Where a body or node is: at a share of the step; at the time that is looked at.
  Vec3 place(Slot s, double time) const {
    return world_.position[static_cast<std::size_t>(s)] + time * settings_.step * velocity(s);
  }
  Vec3 place(Slot s) const { return place(s, time_); }
  const Vec3& velocity(Slot s) const { return world_.velocity[static_cast<std::size_t>(s)]; }
  double radius(Slot node) const { return world_.properties[static_cast<std::size_t>(node)].shape.size.x(); }
  MovingPoint path(Slot s) const { return {place(s, 0), place(s, 1)}; }
  TriangleNodes places(const SurfaceFace& face, double time) const {
    return {place(face.nodes[0], time), place(face.nodes[1], time), place(face.nodes[2], time)};
  }
  Vec3 velocity_on(const SurfaceFace& face, const Vec3& weights) const;
  double travel(std::span<const Slot> first, std::span<const Slot> second) const;
  double travel(const Proxy& solid, const SurfaceFace& face) const;

  // These ask about the neighbours of the feature of a face (itself, an edge or a node) that the weights tell.
  bool owns(const SurfaceFace& face, const Vec3& weights) const;
  bool is_nearest(const SurfaceFace& face, const Vec3& weights, const Vec3& direction, double lean) const;
  bool is_ridge(const SurfaceEdge& edge, const Vec3& direction) const;
  bool is_inwards(const SurfaceFace& face, const Vec3& weights, const Vec3& direction) const;
  bool is_own(Slot point, const SurfaceFace& face) const;
  bool stand_out(const SurfaceEdge& first, const SurfaceEdge& second, const Vec3& towards) const;
  bool may_be_inside(const SurfaceEdge& first, const SurfaceEdge& second) const;

  Vec3 apart(const Pair& pair, double time) const;
  Vec3 parting(const Pair& pair) const;
  bool has_passed(const Pair& pair, const Vec3& between) const;
  double margin(const Pair& pair, const Vec3& normal) const;
  void point_face(Pair pair, const SurfaceFace& face, double fast);
  // These return whether they have said what the pair does, and where it passes by, also whether another face says it. `near`: at
  // the time that is looked at. The arms are from where the bodies are at the start of the step: angular momentum is kept.
  bool stand_on_face(Pair pair, const SurfaceFace& face, const TrianglePoint& near);
  bool stand_across(Pair pair, const SurfaceEdge& first, const SurfaceEdge& second, const SegmentPoints& near);
  // The share of the step at which what moves little in it passes by, or nearly touches, what it does not touch (approach.hpp);
  // 0: it may touch. What passes a face within a surface comes to its neighbour: the caller takes it as it stands.
  double passes_face(Pair pair, const SurfaceFace& face, const TrianglePoint& near) const;
  double passes_edge(Pair pair, const SegmentPoints& near) const;
  TrianglePoint nearest_on(const SurfaceFace& face, Slot point, double time) const;
  SegmentPoints nearest_of_edges(const Pair& pair, double time) const;
  Vec3 normal_in_one_place(const Pair& pair, const SurfaceFace& face) const;
  bool add_standing(const Pair& pair, const SurfaceFace* face = nullptr);
  void add_meeting(Pair pair, double time);
  void add(const Pair& pair, const Vec3& arm, const Vec3& normal, double gap, std::uint32_t feature, double beyond = 0);
  std::size_t flat_neighbours(const SurfaceFace& face, double time, std::array<Vec3, 3>& out) const;

  // A solid and a face: where they are when they first touch if it is fast, else where they are now.
  struct Approach {
    Pair pair;
    double time = 0;  // share of the step
    double reach;     // m, within which what is found may be a contact
    Vec3 centre;      // m, of the solid then
  };
  double passes_solid(const Proxy& solid, const SurfaceFace& face, const Approach& approach) const;
  using FirstTouch = double (SurfaceCollider::*)(const Proxy& solid, const SurfaceFace& face, double radius) const;
  Approach approach(const Proxy& solid, const SurfaceFace& face, FirstTouch first) const;
  bool stand_by_box(Approach& near, const Proxy& box, const SurfaceFace& face);
  bool stand_by_solid(Approach& near, const Proxy& solid, const SurfaceFace& face, std::uint32_t first_feature);
  // Where the solid passes the face by, stand(approach) looks for contacts at the time when the two are nearest to each other.
  // Where it finds none then, or the two do not pass each other, it looks for them at the start of the step.
  template <class Stand>
  void stand_or_pass(const Proxy& solid, const SurfaceFace& face, Approach& approach, Stand&& stand) {
    const double passes = approach.time > 0 ? 0 : passes_solid(solid, face, approach);
    if (passes > 0) {
      Approach then = approach;
      then.time = time_ = passes, then.centre = centre_of(solid, passes);
      const bool says = stand(then);
      time_ = 0;
      if (says) return;
    }
    stand(approach);
  }
  // Adds a touch of two points, which are `apart` (m) by then, the face's radius left out.
  void add_touch(Approach& approach, const Vec3& weights, const Vec3& arm, const Vec3& normal, double apart,
                 std::uint32_t feature);
  void box_face(const Proxy& box, const SurfaceFace& face);
  void convex_face(const Proxy& body, const SurfaceFace& face, std::uint32_t first_feature);
  double first_touch(const Proxy& box, const SurfaceFace& face, double radius) const;
  double first_touch_of_solid(const Proxy& solid, const SurfaceFace& face, double radius) const;
  class MeshFace;  // surface_meshes.cpp
  void mesh_face(const Proxy& mesh, const SurfaceFace& face);
  void add_if_through(Pair pair, const Proxy& solid, const SurfaceFace& face, std::uint32_t feature);

  Vec3 centre_of(const Proxy& solid, double time) const { return solid.position + time * settings_.step * solid.velocity; }

  const World& world_;
  const Surfaces& surfaces_;
  const CollideSettings& settings_;
  std::vector<SurfaceContact>& out_;
  double time_ = 0;  // share of the step: when places are looked at
};

}  // namespace unibody
