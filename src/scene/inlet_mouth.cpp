#include "scene/inlet_mouth.hpp"

#include <algorithm>
#include <cmath>

#include "meshes/surface_file.hpp"
#include "scene/mesh_keys.hpp"
#include "scene/outlets.hpp"
#include "scene/shape_files.hpp"

namespace unibody {

namespace {

const Keys& disc_keys() {
  static const Keys table{
      "inlet_disc", "A disc square to z.", {keys::number("radius", "m", positive, needed, "radius of the disc")}};
  return table;
}

const Keys& mesh_keys() {
  static const Keys table{
      "inlet_mesh",
      "A surface of triangles from a file, or those of its triangles that face one way.",
      {keys::text("file", "an OBJ, STL, PLY, glTF or DAE file", needed,
                  "OBJ, STL, PLY, glTF or DAE file, its path from the scene's folder"),
       keys::scale(), keys::up(),
       keys::direction("facing", "all triangles",
                       "triangles alone whose normals, out of where they turn counterclockwise, are near it"),
       keys::number("within", "degrees", {0, 180}, 10, "how near: the largest angle between the two"),
       keys::number("offset", "m", any_number, 0, "how far from the surface, along its normals, centres are drawn")}};
  return table;
}

Vec3 normal_of(const std::array<Vec3, 3>& at) { return (at[1] - at[0]).cross(at[2] - at[0]); }  // twice the area long

// A triangle of three nodes of its own for each that faces the right way, moved by the offset.
TriangleMesh chosen_triangles(const KeyedMap& map, const TriangleMesh& mesh) {
  const double offset = map.number("offset"), least = std::cos(map.number("within") * M_PI / 180);
  const Vec3 facing = map.has("facing") ? map.direction("facing") : Vec3(Vec3::Zero());
  TriangleMesh chosen;
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = mesh.nodes[static_cast<std::size_t>(triangle[k])];
    const Vec3 normal = normal_of(at);
    const double size = normal.norm();
    if (!(size > 0) || (map.has("facing") && normal.dot(facing) < least * size)) continue;
    const auto first = static_cast<std::int32_t>(chosen.nodes.size());
    for (const Vec3& corner : at) chosen.nodes.push_back(corner + offset / size * normal);
    chosen.triangles.push_back({first, first + 1, first + 2});
  }
  return chosen;
}

void read_face(const Value& value, const Scene& scene, InletMouth& mouth) {
  const KeyedMap map(value, mesh_keys());
  if (!map.has("facing")) map.none_of({"within"}, "without `facing`");
  TriangleMesh mesh = read_surface(surface_path(map.need("file"), scene), true);
  read_mesh_scale(map).apply(mesh.nodes);
  auto face = std::make_shared<InletMouth::Face>();
  face->mesh = chosen_triangles(map, mesh);
  if (face->mesh.triangles.empty())
    map.has("facing") ? map.need("facing").fail_expected("the direction of a triangle's normal, or a larger `within`")
                      : map.need("file").fail_expected("a surface with an area");
  mouth.low = mouth.high = face->mesh.nodes[0];
  for (const Vec3& node : face->mesh.nodes) mouth.low = mouth.low.cwiseMin(node), mouth.high = mouth.high.cwiseMax(node);
  double area = 0;
  for (std::size_t k = 0; k < face->mesh.triangles.size(); ++k) {
    const auto* at = &face->mesh.nodes[3 * k];
    face->areas_up_to.push_back(area += 0.5 * normal_of({at[0], at[1], at[2]}).norm());
  }
  mouth.face = std::move(face);
}

}  // namespace

Vec3 InletMouth::Face::draw(double u, double v, double w) const {
  const auto found = std::ranges::upper_bound(areas_up_to, u * areas_up_to.back());
  const auto k = std::min<std::size_t>(static_cast<std::size_t>(found - areas_up_to.begin()), areas_up_to.size() - 1);
  const Vec3* at = &mesh.nodes[3 * k];
  const double side = std::sqrt(v);  // of the smaller triangle at the first corner in which it is: evenly by area
  return at[0] + side * ((1 - w) * (at[1] - at[0]) + w * (at[2] - at[0]));
}

Vec3 InletMouth::draw(BodyRandom& random) const {
  const double u = random.next(), v = random.next(), w = random.next();
  if (face) return face->draw(u, v, w);
  if (radius == 0) return low + Vec3((high - low).array() * Vec3(u, v, w).array());
  const double r = radius * std::sqrt(u), angle = 2 * M_PI * v;
  return {r * std::cos(angle), r * std::sin(angle), 0};
}

std::vector<Key> inlet_mouth_keys() {
  return {keys::map("box", corners_keys, "a map with low and high", "a disc or mesh",
                    "box, in the entry's axes, in which their centres are drawn"),
          keys::map("disc", disc_keys, "a map with radius", "a box or mesh",
                    "disc about the entry's position in which their centres are drawn"),
          keys::map("mesh", mesh_keys, "a map with file", "a box or disc",
                    "surface, in the entry's axes, on which their centres are drawn, evenly by its area")};
}

InletMouth read_inlet_mouth(const KeyedMap& inlet, const Scene& scene) {
  inlet.only_one_of({"box", "disc", "mesh"});
  const Value *box = inlet.find("box"), *disc = inlet.find("disc"), *mesh = inlet.find("mesh");
  if (!box && !disc && !mesh)
    inlet.value().fail_missing("box", "a map with low and high, disc: one with radius, or mesh: one with file");
  InletMouth mouth;
  if (box) {
    std::tie(mouth.low, mouth.high) = read_corners(*box, scene.planar);
    if (scene.planar && (mouth.low.y() != 0 || mouth.high.y() != 0))
      box->fail("a box that leaves the plane", "0 as the second of three numbers (m; planar scene)");
    return mouth;
  }
  if (scene.planar) (disc ? disc : mesh)->fail_expected("a box (planar scene)");
  if (disc) {
    mouth.radius = KeyedMap(*disc, disc_keys()).number("radius");
    mouth.low = {-mouth.radius, -mouth.radius, 0}, mouth.high = -mouth.low;
  } else {
    read_face(*mesh, scene, mouth);
  }
  return mouth;
}

}  // namespace unibody
