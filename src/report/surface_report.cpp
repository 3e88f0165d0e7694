#include "report/surface_report.hpp"

#include <algorithm>

#include "collide/crossings.hpp"
#include "core/checked.hpp"

namespace unibody {

std::int64_t count_crossings(MPI_Comm comm, const World& world, const Surfaces& surfaces) {
  std::vector<Face> faces;
  for (const SurfaceFace& f : surfaces.faces)
    if (!f.is_segment()) faces.push_back(f.nodes);
  std::vector<Edge> edges;
  std::vector<std::uint8_t> counted;  // with its first node, whose home knows all faces around
  for (const SurfaceEdge& e : surfaces.edges) edges.push_back(e.nodes), counted.push_back(world.is_home(e.nodes[0]));
  std::int64_t count = 0;
  for (const Crossing& c : find_crossings(world.position, faces, edges, counted)) {
    const Slot edge = edges[static_cast<std::size_t>(c.edge)][0], face = faces[static_cast<std::size_t>(c.face)][0];
    const std::int32_t group = surfaces.contact_group(world, edge);
    count += group < 0 || group != surfaces.contact_group(world, face);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, comm));
  return count;
}

}  // namespace unibody
