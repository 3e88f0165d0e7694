#include "scene/robot_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "meshes/assimp_surface.hpp"
#include "meshes/mesh_file.hpp"
#include "meshes/surface_file.hpp"
#include "world/compound_mass.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

// package://NAME/REST is NAME/REST in the folder of packages, or in the nearest folder above the file's that has it.
std::string mesh_path(const RobotShape& shape, const RobotFiles& files) {
  namespace fs = std::filesystem;
  constexpr std::string_view package = "package://", scheme = "file://";
  const fs::path folder = fs::path(files.robot).parent_path();
  std::string name = shape.file;
  fs::path path;
  std::error_code error;
  if (name.starts_with(package)) {
    name.erase(0, package.size());
    path = (files.packages.empty() ? folder : files.packages) / name;
    if (files.packages.empty())
      for (fs::path up = fs::absolute(folder, error); !fs::is_regular_file(path, error) && up != up.root_path();
           up = up.parent_path())
        path = up / name;
  } else {
    if (name.starts_with(scheme)) name.erase(0, scheme.size());
    path = folder / name;
  }
  if (!fs::is_regular_file(path, error))
    fail_at(files.robot, shape.line, "mesh " + quote(shape.file) + ", which isn't at " + path.string(),
            !files.packages.empty() || !shape.file.starts_with(package)
                ? "a file that is there"
                : "a file that is there (packages: the folder of packages)");
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".obj" && ending != ".stl" && ending != ".ply" && !is_for_assimp(ending))
    fail_at(files.robot, shape.line, "mesh " + quote(shape.file), "an OBJ, STL, PLY, glTF or DAE file");
  return path.string();
}

Compound::Part hull_of(const RobotShape& shape, const Pose& pose, const RobotFiles& files) {
  std::vector<Vec3> points = shape.points;
  if (shape.kind == RobotShape::Kind::mesh) {
    points = read_surface(mesh_path(shape, files), true).nodes;
    for (Vec3& x : points) x = x.cwiseProduct(shape.size);
  }
  try {
    Hull hull = make_hull(points);
    const Vec3 centre = hull.centre;
    return {shape_library().add(std::move(hull)), pose * centre, pose.turn};
  } catch (const std::invalid_argument& fault) {
    fail_at(files.robot, shape.line, "mesh " + quote(shape.file) + " of " + fault.what(), "a mesh that spans a solid");
  }
}

Compound::Part part_of(const RobotShape& shape, const Pose& pose, const RobotFiles& files) {
  const Vec3& size = shape.size;
  switch (shape.kind) {
    case RobotShape::Kind::box:
      return {{ShapeKind::box, 0.5 * size}, pose.at, pose.turn};
    case RobotShape::Kind::sphere:
      return {{ShapeKind::sphere, Vec3(size.x(), 0, 0)}, pose.at, pose.turn};
    case RobotShape::Kind::cylinder:
      return {{ShapeKind::cylinder, Vec3(size.x(), size.x(), 0.5 * size.y())}, pose.at, pose.turn};
    case RobotShape::Kind::capsule:
      return {{ShapeKind::capsule, Vec3(size.x(), size.x(), 0.5 * size.y() + size.x())}, pose.at, pose.turn};
    default:
      return hull_of(shape, pose, files);
  }
}

}  // namespace

void RobotBody::add_mass(double m, const Vec3& centre, const Mat3& inertia) {
  mass += m, first += m * centre;
  about += inertia + m * (centre.squaredNorm() * Mat3::Identity() - centre * centre.transpose());
}

void RobotBody::add_link(const RobotLink& link, const Pose& in_body, const RobotFiles& files) {
  if (link.mass > 0) {
    const Pose centre = in_body * link.centre;
    const Mat3 turn = centre.turn.toRotationMatrix();
    add_mass(link.mass, centre.at, turn * link.inertia * turn.transpose());
  }
  for (const RobotShape& shape : link.shapes) {
    const Compound::Part part = part_of(shape, in_body * shape.pose, files);
    if (shape.touches) parts.push_back(part);
    const double density = shape.mass > 0 ? shape.mass / volume(part.shape) : shape.density;
    if (!(density > 0)) continue;
    const CompoundMass of = compound_mass({&part, 1}, {&density, 1}, Overlap::twice);
    add_mass(of.mass, of.centre, of.mass * (of.second.trace() * Mat3::Identity() - of.second));
  }
}

void RobotBody::take_share(double share, RobotBody& from) {
  mass = share * from.mass, first = share * from.first, about = share * from.about;
  from.mass -= mass, from.first -= first, from.about -= about;
}

bool is_of_a_solid(const Mat3& inertia) {
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  return 2 * moments.maxCoeff() <= moments.sum() * (1 + 1e-9);
}

Compound solid_of(const RobotBody& body) {
  const Vec3 centre = body.first / body.mass;
  const Mat3 inertia = body.about - body.mass * (centre.squaredNorm() * Mat3::Identity() - centre * centre.transpose());
  const Mat3 second = 0.5 * inertia.trace() * Mat3::Identity() - inertia;
  std::vector<Compound::Part> parts = body.parts;
  if (parts.empty()) {
    const double radius = std::sqrt(2.5 * inertia.trace() / (3 * body.mass));
    parts.push_back({{ShapeKind::sphere, Vec3(radius, 0, 0)}, centre, Quat::Identity()});
  }
  double volume_of_all = 0;
  for (const Compound::Part& part : parts) volume_of_all += volume(part.shape);
  return make_compound(parts, moments_of(volume_of_all, centre, second / body.mass));
}

}  // namespace unibody
