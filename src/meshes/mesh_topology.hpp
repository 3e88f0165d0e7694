// What belongs to what in a triangle mesh: edges, their triangles, boundaries; and the faults that a mesh may have.
//
// Nodes and triangles are numbered from 0 here and in all messages. Holes are legal, and so is a node at which two parts of a
// surface meet without a common edge.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

struct MeshEdge {
  std::array<std::int32_t, 2> nodes;      // ascending
  std::array<std::int32_t, 2> triangles;  // ascending; the second is -1 on a boundary
  std::array<std::int32_t, 2> opposite;   // the third node of each triangle, for bending; the second is -1 on a boundary

  bool is_boundary() const { return triangles[1] < 0; }
};

struct MeshTopology {
  std::vector<MeshEdge> edges;         // each once, ascending (nodes[0], nodes[1])
  std::vector<std::int32_t> boundary;  // those that have one triangle, ascending
  std::int32_t components = 0;         // parts that share no node
};

// Throws InputError "origin: found v, expected e" on the first of: a node that isn't there, a triangle with a node twice, a
// triangle twice (in whatever order of nodes), an edge of three or more triangles.
MeshTopology mesh_topology(const TriangleMesh& mesh, const std::string& origin);

// Turns triangles over until neighbours agree about which side is out; in each part that hangs together by edges, the first
// triangle keeps its side. Returns how many were turned. Throws InputError where no choice agrees, as on a Moebius strip.
std::int64_t orient_triangles(TriangleMesh& mesh, const MeshTopology& topology, const std::string& origin);

// Throws InputError on the first of: the faults that mesh_topology() finds, a triangle whose height is below 1e-8 of its longest
// edge, two neighbours that disagree about which side is out, a node of no triangle.
void check_mesh(const TriangleMesh& mesh, const std::string& origin);

}  // namespace unibody
