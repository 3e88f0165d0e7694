// A surface of triangles that does not move by itself: terrain, or the inside of a drum. Touched from the side to which its
// triangles turn counterclockwise; behind them it is solid: all the way where the surface says what that is (it is closed, or a
// height field), else near them. A surface whose triangles do not agree about that has two sides: a body is held on the one where
// it is, and nothing is behind.
#pragma once

#include <array>
#include <span>
#include <string>

#include "world/shapes.hpp"

namespace unibody {

struct MeshSurface {
  struct Triangle {
    std::array<std::int32_t, 3> nodes;
    std::array<std::int32_t, 3> across;  // the third node of the triangle over edge i (from node i to i + 1); -1: none
    std::array<bool, 3> speaks_for_edge, speaks_for_node;  // so that what is shared is touched once
    Vec3 normal;                                           // unit, outwards
    std::int32_t patch = 0;  // of a two-sided mesh: triangles that hang together by edges, and agree about their two sides

    // Edge i becomes edge 2 - i.
    void turn_over();
  };
  // A triangle at an edge (from its node `place` to the next) over which two others go on into each other.
  struct Branching {
    std::int32_t triangle, place;
    std::array<std::int32_t, 2> across;  // the third nodes of these two
  };
  std::vector<Vec3> nodes;  // m
  std::vector<Triangle> triangles;
  // The nodes to which edges lead from node i, each with the patch of the edge: ring[ring_begin[i]] up to ring_begin[i + 1].
  struct RingNode {
    std::int32_t patch, node;
    auto operator<=>(const RingNode&) const = default;
  };
  std::vector<RingNode> ring;
  std::vector<std::size_t> ring_begin;
  std::vector<Branching> branchings;  // ascending (triangle, place); such a triangle does not speak for that edge
  Vec3 size = Vec3::Zero();           // m, the largest of each coordinate
  double radius = 0;                  // m, of the sphere about the origin that holds it
  bool is_solid = false;              // all the way behind its triangles
  bool two_sided = false;
  bool sides_by_bodies = false;    // which side is touched waits for where bodies start (step/mesh_sides.hpp)
  std::string name;                // of the file, for messages
  std::string note;                // where it was mended: what a person should know of that
  std::vector<Vec3> node_normals;  // means by angle of the triangles' (Baerentzen & Aanaes 2005); 0 on a border

  // Adds the numbers of the triangles whose bounds meet this box (m), ascending.
  void find(const Vec3& low, const Vec3& high, std::vector<std::int32_t>& found) const;

  // Boxes around boxes: of node k of a full binary tree the children are 2 k + 1 and 2 k + 2.
  struct Branch {
    Vec3 low, high;
    std::int32_t first, count;  // into order; of a leaf; else count is 0
  };
  std::vector<Branch> tree;
  std::vector<std::int32_t> order;

  // Cells of a grid over a surface without borders, and some way around it: which of them lie all in front of the surface, as far
  // as that was asked. A memory of is_behind() (collide/mesh_side.hpp) that changes no answer.
  struct FrontCells {
    enum class Cell : std::uint8_t { unknown, in_front, other };
    Vec3 low = Vec3::Zero();
    double size = 0;  // m, of a cell
    Eigen::Array3i counts = Eigen::Array3i::Zero();
    std::vector<Cell> cells;  // x runs fastest; empty before the first question, or where the surface has a border
    bool is_made = false;
  };
  mutable FrontCells front_cells;
};

// Turns all triangles over, or makes the surface two-sided.
void turn_over(MeshSurface& mesh);
void touch_from_both(MeshSurface& mesh);

// Nodes and triangles as those of a TriangleMesh without triangles of no area and without any twice. `below`: m, > 0 for a height
// field over the x-y plane, which is solid at least so far below its lowest node. two_sided: so whatever way its triangles turn.
MeshSurface make_mesh_shape(std::span<const Vec3> nodes, std::span<const std::array<std::int32_t, 3>> triangles, double below = 0,
                            bool two_sided = false);

}  // namespace unibody
