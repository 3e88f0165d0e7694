#include "step/mesh_guard.hpp"

#include <algorithm>
#include <vector>

#include "core/checked.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr double least_motion = 0.01;  // of half a body's size: what moves less is where its contacts left it
constexpr double kept = 0.1;           // of half a body's size: how near to a triangle its centre may come
constexpr int most_passages = 16;

// A triangle that a centre would pass through.
struct Passage {
  double share = 2;                      // of the way
  Vec3 normal = Vec3::Zero();            // unit, to the side from which the centre comes
  double height_before = 0, height = 0;  // m, of the centre over the triangle, at the start and at the end
};

// Whether a point of a triangle's plane is in the triangle or on its border.
bool is_in(const MeshSurface& mesh, const MeshSurface::Triangle& t, const Vec3& point) {
  constexpr double rounding = 1e-9;
  const auto node = [&](std::size_t k) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(t.nodes[k % 3])]; };
  const double area = (node(1) - node(0)).cross(node(2) - node(0)).norm();
  for (std::size_t k = 0; k < 3; ++k)
    if (t.normal.dot((node(k + 1) - node(k)).cross(point - node(k))) < -rounding * area) return false;
  return true;
}

Passage first_passage(const MeshSurface& mesh, const Vec3& from, const Vec3& to) {
  std::vector<std::int32_t> near;
  mesh.find(from.cwiseMin(to), from.cwiseMax(to), near);
  Passage first;
  for (const std::int32_t k : near) {
    const MeshSurface::Triangle& t = mesh.triangles[static_cast<std::size_t>(k)];
    const Vec3& node = mesh.nodes[static_cast<std::size_t>(t.nodes[0])];
    const double before = t.normal.dot(from - node), after = t.normal.dot(to - node);
    if (!((before > 0 && after <= 0) || (mesh.two_sided && before < 0 && after >= 0))) continue;
    const double share = before / (before - after), side = before > 0 ? 1 : -1;
    if (share < first.share && is_in(mesh, t, from + share * (to - from)))
      first = {share, side * t.normal, side * before, side * after};
  }
  return first;
}

// Where a centre that goes from `from` to `to` ends (m, in the mesh's frame), in front of all triangles.
Vec3 held_place(const MeshSurface& mesh, const Vec3& from, Vec3 to, double half_size) {
  for (int round = 0; round < most_passages; ++round) {
    const Passage passage = first_passage(mesh, from, to);
    if (passage.share > 1) return to;
    to += (std::min(kept * half_size, 0.5 * passage.height_before) - passage.height) * passage.normal;
  }
  return from;
}

bool may_touch(const RankState& state, std::size_t body, std::size_t mesh) {
  const World& world = state.world;
  const std::int32_t group = world.properties[body].group;
  if (group >= 0 && group == world.properties[mesh].group) return false;
  return state.search.settings.may_touch(world.id[body], world.id[mesh]);
}

bool is_compound(const World& world, std::size_t body) { return world.properties[body].shape.kind == ShapeKind::compound; }

}  // namespace

MeshGuard::MeshGuard(const RankState& state) {
  const World& world = state.world;
  for (std::size_t i = world.first_static(); i < world.size(); ++i)
    if (world.properties[i].shape.kind == ShapeKind::mesh)
      meshes_.push_back({i, world.position[i], world.orientation_of(i).toRotationMatrix()});
  if (meshes_.empty()) return;
  const auto homes = static_cast<std::ptrdiff_t>(world.homes);
  places_.assign(world.position.begin(), world.position.begin() + homes);
  for (std::size_t i = 0; i < world.homes && turns_.empty(); ++i)
    if (is_compound(world, i)) turns_.assign(world.orientation.begin(), world.orientation.begin() + homes);
}

std::vector<MeshGuard::Centre> MeshGuard::centres_of(const World& world, std::size_t body) const {
  const Shape& shape = world.properties[body].shape;
  const Vec3 &from = places_[body], &to = world.position[body];
  if (!is_compound(world, body)) return {{from, to, 0.5 * smallest_size(shape)}};
  std::vector<Centre> centres;
  for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
    centres.push_back(
        {from + turns_[body] * part.place, to + world.orientation[body] * part.place, 0.5 * smallest_size(part.shape)});
  return centres;
}

Vec3 MeshGuard::change_before(const Mesh& mesh, const World& world, std::size_t body, const std::vector<Centre>& centres) const {
  const MeshSurface& surface = shape_library().meshes[world.properties[mesh.slot].shape.data];
  const Vec3 image = world.period.shift(world.period.nearest(places_[body], mesh.centre));  // of a periodic scene's mesh
  const Mat3 turn = world.orientation_of(mesh.slot).toRotationMatrix();
  Vec3 change = Vec3::Zero();
  for (std::size_t round = 0; round < (centres.size() > 1 ? 4 : 1); ++round) {
    const Vec3 before = change;
    for (const Centre& centre : centres) {
      const Vec3 from = mesh.turn.transpose() * (centre.from - image - mesh.centre);
      const Vec3 to = turn.transpose() * (centre.to + change - image - world.position[mesh.slot]);
      if (!((to - from).norm() > least_motion * centre.half_size)) continue;
      const Vec3 place = held_place(surface, from, to, centre.half_size);
      if (place != to) change += turn * (place - to);
    }
    if (change == before) break;
  }
  return change;
}

std::int64_t MeshGuard::hold(RankState& state) const {
  if (meshes_.empty()) return 0;
  World& world = state.world;
  std::int64_t held = 0;
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (state.has_surfaces() && state.search.surfaces.is_interior(static_cast<Slot>(i))) continue;
    std::vector<Centre> centres = centres_of(world, i);
    Vec3 change = Vec3::Zero();
    for (const Mesh& mesh : meshes_) {
      if (!may_touch(state, i, mesh.slot)) continue;
      const Vec3 more = change_before(mesh, world, i, centres);
      for (Centre& centre : centres) centre.to += more;
      change += more;
    }
    if (change.isZero(0)) continue;
    ++held;
    world.position[i] += change, world.velocity[i] += change / state.step();
  }
  if (!state.is_alone()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_INT64_T, MPI_SUM, state.comm()));
  return held;
}

}  // namespace unibody
