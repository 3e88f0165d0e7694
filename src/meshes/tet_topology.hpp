// What hangs together in a mesh of tetrahedra, its boundary, and the faults that it may have.
//
// Nodes and tets are numbered from 0 here and in all messages. Parts that share no node are legal: they move as bodies of their
// own. So are parts that share a node or an edge alone, without a face.
#pragma once

#include "meshes/tet_mesh.hpp"

namespace unibody {

// The face opposite to each node of a tet, counterclockwise from the outside.
inline constexpr std::array<std::array<std::size_t, 3>, 4> tet_faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// The volume of a tet (m^3), positive where it is positively oriented.
double tet_volume(const TetMesh& mesh, std::size_t tet);

// Turns inverted tets over, by a swap of their last two nodes; returns how many. Throws InputError "origin: found v, expected e"
// on a node that isn't there.
std::int64_t orient_tets(TetMesh& mesh, const std::string& origin);

// Throws InputError on the first of: a node that isn't there, a tet with a node twice, a tet twice (in whatever order of nodes),
// a face of three or more tets, a place that isn't finite, a tet whose volume is below 1e-12 of its longest edge cubed (inverted
// tets are), two tets on the same side of their face.
void check_tets(const TetMesh& mesh, const std::string& origin);

// Drops the nodes of no tet (Gmsh writes the points of the geometry too); the others keep their order. Returns how many.
std::int64_t drop_unused_nodes(TetMesh& mesh);

// The faces of one tet only, counterclockwise from the outside, in order of (tet, opposite node).
std::vector<std::array<std::int32_t, 3>> boundary_of(const TetMesh& mesh);

}  // namespace unibody
