#include "step/mesh_sides.hpp"

#include <algorithm>
#include <cmath>

#include "collide/mesh_side.hpp"
#include "core/checked.hpp"
#include "step/build.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

struct Place {
  std::size_t mesh;
  Vec3 position;
  Quat orientation;
};

// Bodies on either side of a mesh, over all of its places.
struct Count {
  std::int64_t behind = 0, in_front = 0;
};

// How deep the centre lies (m) of a body that is all behind: less what bodies that touch the surface may overlap with it.
double whole_depth(const Shape& shape) { return shape.kind == ShapeKind::particle ? 0 : 0.45 * smallest_size(shape); }

void count(const Place& place, const Vec3& x, const Shape& shape, Count& result) {
  MeshPlace at;
  const Vec3 local = place.orientation.conjugate() * (x - place.position);
  if (!find_place(shape_library().meshes[place.mesh], local, HUGE_VAL, at)) return;
  if (at.depth > whole_depth(shape))
    ++result.behind;
  else
    ++result.in_front;
}

}  // namespace

void decide_mesh_sides(MPI_Comm comm, const Scene& scene, std::vector<std::string>& notes) {
  std::deque<MeshSurface>& meshes = shape_library().meshes;
  if (std::none_of(meshes.begin(), meshes.end(), [](const MeshSurface& m) { return m.sides_by_bodies; })) return;
  const World world = build_world(comm, scene);
  std::vector<Place> places;
  for (std::size_t i = world.homes; i < world.size(); ++i) {
    const Shape& shape = world.properties[i].shape;
    if (shape.kind == ShapeKind::mesh && meshes[shape.data].sides_by_bodies)
      places.push_back({shape.data, world.position[i], world.orientation_of(i)});
  }
  std::vector<Count> counts(meshes.size());
  for (std::size_t i = 0; i < world.homes; ++i)
    for (const Place& place : places) count(place, world.position[i], world.properties[i].shape, counts[place.mesh]);
  static_assert(sizeof(Count) == 2 * sizeof(std::int64_t));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(2 * counts.size()), MPI_INT64_T, MPI_SUM, comm));
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    MeshSurface& mesh = meshes[k];
    if (!mesh.sides_by_bodies || counts[k].behind == 0) continue;
    const std::string all = std::to_string(counts[k].behind + counts[k].in_front);
    std::string note =
        mesh.name + ": " + std::to_string(counts[k].behind) + " of " + all + " bodies start behind its triangles: ";
    if (counts[k].in_front == 0) {
      turn_over(mesh);
      note += "touched from there (sides: back)";
    } else {
      touch_from_both(mesh);
      note += "touched from both sides (sides: both)";
    }
    notes.push_back(note);
  }
}

}  // namespace unibody
