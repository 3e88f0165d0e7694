// The surface of a flexible body, as the scene makes it: cells between its nodes.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "core/time_value.hpp"
#include "core/types.hpp"

namespace unibody {

// What lies between the nodes of a flexible body, to be touched and drawn: the triangles of a cloth or the segments of a thread.
struct Surface {
  std::string name;  // of the entry; may be empty
  int corners = 3;   // 2: segments
  Id count = 0;
  std::function<std::array<Id, 3>(Id k)> cell;  // the bodies at the corners, the first `corners` of the three; a pure function

  Id first_node = 0, node_count = 0;
  // Adds the cells at a node, counterclockwise; of a segment the last two nodes are equal. A pure function.
  std::function<void(Id node, std::vector<std::array<Id, 3>>& out)> cells_of = nullptr;
  // The bodies at the corners of a solid's tetrahedra, for the output, positively oriented at rest.
  Id tetrahedron_count = 0;
  std::function<std::array<Id, 4>(Id k)> tetrahedron = nullptr;
  // For the output: Young's modulus (Pa) and Poisson's ratio of a solid's tetrahedron k, of a membrane's triangle k, or of a
  // thread's segment k, whose ratio counts as 0. The function is null for cloths of links and for threads that cannot stretch.
  std::function<std::array<double, 2>(Id k)> elasticity = nullptr;
  std::string energy_volume;    // of a solid: rest or current, the volume that weighs the energy of its strains
  bool self_collision = false;  // cells touch others of the same surface
  bool closed = false;          // around a solid: cells are counterclockwise from outside, and what is inside belongs outside
  double drag = 0;              // 1, coefficient of the air's resistance to a triangle's motion along its normal
  TimeValue pressure;           // Pa, pushes each triangle along its normal: counterclockwise corners, of a solid outwards
};

}  // namespace unibody
