// The sections `cloths`, `threads` and `solids`: flexible bodies of particles and the constraints between them.
#pragma once

#include "constraints/constraint_types.hpp"
#include "scene/body_entry.hpp"

namespace unibody {

void read_cloths(const Value& list, Scene& scene);
void read_threads(const Value& list, Scene& scene);
void read_solids(const Value& list, Scene& scene);

// All keys that an entry of these may have.
const Keys& cloth_keys();
const Keys& thread_keys();
const Keys& solid_keys();

// What they have in common: the particles, where they are and how they start.
struct Nodes {
  BodyTemplate particle;  // of the contact radius; its mass is set by node
  std::string name;
  int line = 0;  // of the entry in the file
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  // The node at this place in the entry's frame.
  Body at(const Vec3& place, double mass) const;
};

// A spring law as the file gives it: stiffness (of the row's own unit; absent: stiff) and damping rho (s).
struct Spring {
  double stiffness = 0;  // 0: stiff
  double damping = 0;
  double compliance() const { return stiffness > 0 ? 1 / stiffness : 0; }
};
// The keys stiffness and damping of a map.
Spring read_spring(const KeyedMap& map);
std::vector<Key> spring_keys(const char* unit, const char* of_what);

// The keys that cloths, threads and solids have, and those of their surfaces, of which a thread has the first alone.
Keys node_keys(const char* name, const char* about, const char* pinned_node);
Key self_collision_key();
Key drag_key();
Key pressure_key(const char* about);
Nodes read_nodes(const KeyedMap& entry, double radius, const Scene& scene);

// Adds the nodes as bodies first .. first + count - 1, with their constraints; returns the first id.
Id add_flexible(Scene& scene, const Nodes& nodes, Id count, std::function<Body(Id)> make,
                std::function<void(Id first, Id node, ConstraintSet& out)> touching,
                std::function<Id(Id node)> patch = patch_by_number);

Key pins_key(const char* node);
// Reads `pins` of a flexible body whose nodes are bodies first .. first + count - 1, the last ones so far, where the entry has
// it: a list of {node: ..., to: body, release: s} or {near: [x, y, z], ...}. `number(value)` reads a node as the entry names it.
void read_pins(const KeyedMap& entry, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number);

// What lies between the nodes of a cloth or solid, whatever it was made from: pure functions, nodes numbered from 0, places (m)
// in the entry's frame.
struct MeshShape {
  Id count = 0;
  std::function<Vec3(Id node)> place;
  std::function<double(Id node)> mass;                                  // kg
  std::function<void(Id first, Id node, ConstraintSet& out)> touching;  // ids from `first` on
  std::function<Id(Id node)> patch = patch_by_number;                   // what a partition moves as one
  std::function<Id(const Value&)> number;                               // of a node as pins name it
  Id triangle_count = 0;                                                // to be touched and drawn
  bool closed = false;                                                  // they bound a solid
  std::function<std::array<Id, 3>(Id triangle)> triangle;
  std::function<void(Id node, std::vector<std::array<Id, 3>>& out)> triangles_of;  // those at a node
  Id tetrahedron_count = 0;                                                        // of a solid, for the output
  std::function<std::array<Id, 4>(Id tetrahedron)> tetrahedron;
  std::string note;  // what a person should know of what was read; may be empty
};

// A box (m, world axes) that says which nodes are meant, by where they are at the start.
struct Part {
  Vec3 lower, upper;
  bool holds(const Vec3& x) const;
};
Part read_part(const Value& value, const Scene& scene);
Key within_key(const Without& without, const char* about);

// Adds the surface of a shape whose nodes are bodies from `first` on, with the entry's self_collision and drag.
void add_surface(const KeyedMap& entry, Scene& scene, const std::string& name, Id first, const MeshShape& shape);

}  // namespace unibody
