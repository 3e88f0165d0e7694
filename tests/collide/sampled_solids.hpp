// Solids of every kind of shape, as patches that can be sampled and convex pieces that say how deep inside a point is. A new kind
// in the list of shapes has to say here what its surface is.
#pragma once

#include "collide/bodies.hpp"
#include "collide/sampled_surface.hpp"
#include "world/shape_library.hpp"

namespace unibody::samples {

constexpr double fineness = 1e-3;  // m, of samples where they matter

// A convex piece of a solid, or a triangle of a mesh.
struct Piece {
  Patches surface;
  std::function<double(const Vec3&)> depth;  // m, of a point inside, from the definition of the shape; negative outside
  Vec3 axis = Vec3::Zero();                  // m, of a capsule, as long as its radius
};

// A solid as sampled, in its own axes or in place.
struct Solid {
  Patches surface;
  std::vector<Piece> pieces;                    // which fill it; of a mesh its triangles; none of a half space
  std::function<bool(const Vec3&)> holds = {};  // of a mesh

  void add(const Piece& piece) {
    pieces.push_back(piece);
    surface.insert(surface.end(), piece.surface.begin(), piece.surface.end());
  }
};

// Hills over the x-y plane.
inline double height_of_nodes(double x, double y) { return 0.08 * std::sin(4 * x) * std::cos(3 * y); }
constexpr int cells_of_hills = 6;
constexpr double width_of_hills = 1.2;  // m

// m, of the triangles between: cells are cut from their lowest node to their highest.
inline double height_of_hills(double x, double y) {
  const double i = (x / width_of_hills + 0.5) * cells_of_hills, j = (y / width_of_hills + 0.5) * cells_of_hills;
  const double u = i - std::floor(i), v = j - std::floor(j), step = width_of_hills / cells_of_hills;
  const auto at = [&](int k, int l) {
    return height_of_nodes(step * (std::floor(i) + k) - width_of_hills / 2, step * (std::floor(j) + l) - width_of_hills / 2);
  };
  return at(0, 0) +
         (u > v ? u * (at(1, 0) - at(0, 0)) + v * (at(1, 1) - at(1, 0)) : v * (at(0, 1) - at(0, 0)) + u * (at(1, 1) - at(0, 1)));
}

inline MeshSurface hills() {
  std::vector<Vec3> nodes;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int j = 0; j <= cells_of_hills; ++j)
    for (int i = 0; i <= cells_of_hills; ++i) {
      const double x = width_of_hills * (double(i) / cells_of_hills - 0.5),
                   y = width_of_hills * (double(j) / cells_of_hills - 0.5);
      nodes.emplace_back(x, y, height_of_nodes(x, y));
    }
  for (int j = 0; j < cells_of_hills; ++j)
    for (int i = 0; i < cells_of_hills; ++i) {
      const int a = i + (cells_of_hills + 1) * j, b = a + 1, c = a + cells_of_hills + 1, d = c + 1;
      triangles.push_back({a, b, d}), triangles.push_back({a, d, c});
    }
  return make_mesh_shape(nodes, triangles, 1);
}

// A closed L: two blocks of the plane x-y, with a reentrant edge.
inline const std::array<std::pair<Vec3, Vec3>, 2> blocks{{{{-.3, -.3, -.15}, {.3, 0, .15}}, {{-.3, 0, -.15}, {0, .3, .15}}}};
inline MeshSurface ell() {
  const double x[6] = {-.3, .3, .3, 0, 0, -.3}, y[6] = {-.3, -.3, 0, 0, .3, .3};
  std::vector<Vec3> nodes;
  for (const double z : {-.15, .15})
    for (int k = 0; k < 6; ++k) nodes.emplace_back(x[k], y[k], z);
  std::vector<std::array<std::int32_t, 3>> triangles{{6, 7, 8}, {6, 8, 9}, {6, 9, 10}, {6, 10, 11}};
  for (int k = 0; k < 4; ++k) triangles.push_back({0, k + 2, k + 1});
  for (int k = 0; k < 6; ++k) {
    const int l = (k + 1) % 6;
    triangles.push_back({k, l, 6 + l}), triangles.push_back({k, 6 + l, 6 + k});
  }
  return make_mesh_shape(nodes, triangles);
}

inline bool is_hills(const Shape& s) { return s.kind == ShapeKind::mesh && shape_library().meshes[s.data].nodes.size() > 12; }

inline Shape hull_of(const std::vector<Vec3>& points) { return shape_library().add(make_hull(points)); }
inline Shape tee() {
  const Quat lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  const Compound::Part parts[] = {{{ShapeKind::box, {.3, .08, .06}}, Vec3(0, 0, .2), Quat::Identity()},
                                  {{ShapeKind::cylinder, {.07, .07, .2}}, Vec3(.05, 0, 0), Quat::Identity()},
                                  {{ShapeKind::capsule, {.06, .06, .25}}, Vec3(0, .1, -.2), lying}};
  return shape_library().add(make_compound(parts));
}

inline std::vector<Shape> examples_of(ShapeKind kind) {
  static const std::vector<Shape> hulls{hull_of({{.3, 0, 0}, {-.3, 0, 0}, {0, .2, 0}, {0, -.2, 0}, {0, 0, .4}, {0, 0, -.2}}),
                                        hull_of({{0, 0, 0}, {.4, 0, 0}, {0, .3, 0}, {0, 0, .5}, {.4, 0, .5}, {0, .3, .5}})};
  static const std::vector<Shape> tees{tee()}, meshes{shape_library().add(hills()), shape_library().add(ell())};
  switch (kind) {
    case ShapeKind::sphere:
      return {{kind, {.2, 0, 0}}};
    case ShapeKind::box:
      return {{kind, {.2, .3, .15}}};
    case ShapeKind::plane:
      return {{kind, Vec3::Zero()}};
    case ShapeKind::disc:
      return {{kind, {.2, 0, 0}}};
    case ShapeKind::particle:
      return {{kind, {.05, 0, 0}}};
    case ShapeKind::capsule:
      return {{kind, {.1, .1, .35}}};
    case ShapeKind::cylinder:
      return {{kind, {.2, .2, .3}}};
    case ShapeKind::hull:
      return hulls;
    case ShapeKind::compound:
      return tees;
    case ShapeKind::mesh:
      return meshes;
  }
  return {};
}

inline Patches box_of(const Vec3& h) {
  Patches faces;
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 n = h[k] * Vec3::Unit(k), a = h[(k + 1) % 3] * Vec3::Unit((k + 1) % 3),
                 b = h[(k + 2) % 3] * Vec3::Unit((k + 2) % 3);
      faces.push_back(quad(side * n - a - b, 2 * a, 2 * b));
    }
  return faces;
}

// m, of a point inside a convex solid of these triangles about the origin.
inline double depth_in(const std::vector<std::array<Vec3, 3>>& faces, const Vec3& x) {
  double least = HUGE_VAL;
  for (const auto& [p, q, r] : faces) {
    const Vec3 n = (q - p).cross(r - p).normalized();
    least = std::min(least, std::copysign(1.0, n.dot(p)) * n.dot(p - x));
  }
  return least;
}

inline Piece piece_of_hull(const Hull& hull) {
  std::vector<std::array<Vec3, 3>> faces;
  for (const Hull::Face& f : hull.faces) {
    const auto corner = [&](std::uint32_t i) { return hull.corners[hull.face_corners[f.first + i]]; };
    for (std::uint32_t k = 2; k < f.count; ++k) faces.push_back({corner(0), corner(k - 1), corner(k)});
  }
  Piece piece;
  for (const auto& [p, q, r] : faces) piece.surface.push_back(triangle(p, q, r));
  piece.depth = [=](const Vec3& x) { return depth_in(faces, x); };
  return piece;
}

inline Piece moved(const Piece& piece, const Vec3& place, const Mat3& turn) {
  Piece result{moved(piece.surface, place, turn), {}, turn * piece.axis};
  if (piece.depth) result.depth = [=, f = piece.depth](const Vec3& x) { return f(turn.transpose() * (x - place)); };
  return result;
}

// In its own axes; in the x-z plane where that is where all happens.
inline Solid solid_of(const Shape& s, bool planar) {
  const double r = s.size.x(), h = s.size.z(), half_pi = std::numbers::pi / 2;
  Solid result;
  switch (s.kind) {
    case ShapeKind::sphere:
    case ShapeKind::particle:
    case ShapeKind::disc:
      result.add({planar ? Patches{ring(r)} : Patches{dome(r, 0, 0, 2 * half_pi)}, [=](const Vec3& x) { return r - x.norm(); }});
      break;
    case ShapeKind::box:
      result.add({planar ? Patches{quad({-r, 0, -h}, {2 * r, 0, 0}, Vec3::Zero()), quad({-r, 0, h}, {2 * r, 0, 0}, Vec3::Zero()),
                                   quad({-r, 0, -h}, {0, 0, 2 * h}, Vec3::Zero()), quad({r, 0, -h}, {0, 0, 2 * h}, Vec3::Zero())}
                         : box_of(s.size),
                  [=](const Vec3& x) {
                    const Vec3 from_faces = s.size - x.cwiseAbs();
                    return planar ? std::min(from_faces.x(), from_faces.z()) : from_faces.minCoeff();
                  }});
      break;
    case ShapeKind::plane:
      result.surface = {planar ? quad({-1, 0, 0}, {2, 0, 0}, Vec3::Zero()) : quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})};
      result.holds = [](const Vec3& x) { return x.z() < 0; };
      break;
    case ShapeKind::capsule:
      result.add({{tube(r, r - h, h - r), dome(r, h - r, 0, half_pi), dome(r, r - h, half_pi, 2 * half_pi)},
                  [=](const Vec3& x) { return r - (x - Vec3(0, 0, std::clamp(x.z(), r - h, h - r))).norm(); },
                  r * Vec3::UnitZ()});
      break;
    case ShapeKind::cylinder:
      result.add({{tube(r, -h, h), lid(r, -h), lid(r, h)},
                  [=](const Vec3& x) { return std::min(r - std::hypot(x.x(), x.y()), h - std::abs(x.z())); }});
      break;
    case ShapeKind::hull:
      result.add(piece_of_hull(shape_library().hulls[s.data]));
      break;
    case ShapeKind::compound:
      for (const Compound::Part& part : shape_library().compounds[s.data].parts)
        result.add(moved(solid_of(part.shape, planar).pieces[0], part.place, part.turn.toRotationMatrix()));
      break;
    case ShapeKind::mesh: {
      const MeshSurface& mesh = shape_library().meshes[s.data];
      for (const auto& t : mesh.triangles) {
        const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t.nodes[k])]; };
        result.add({{triangle(node(0), node(1), node(2))}, {}});
      }
      result.holds = is_hills(s) ? [](const Vec3& x) { return x.z() < height_of_hills(x.x(), x.y()); } : [](const Vec3& x) {
        return std::any_of(blocks.begin(), blocks.end(), [&](const auto& block) {
          return (x.array() > block.first.array()).all() && (x.array() < block.second.array()).all();
        });
      };
      break;
    }
  }
  return result;
}

// A body, and what is sampled of it where it stands.
struct Placed {
  Body body;
  Solid solid;
  std::vector<Cloud> clouds;  // of its pieces

  Placed(const Shape& shape, const Vec3& place, const Quat& turn, bool planar) {
    body.properties.shape = shape;
    body.properties.motion = shape.kind == ShapeKind::plane || shape.kind == ShapeKind::mesh ? Motion::fixed : Motion::dynamic;
    body.state.position = place, body.state.orientation = turn;
    const Solid own = solid_of(shape, planar);
    const Mat3 rotation = turn.toRotationMatrix();
    solid.surface = moved(own.surface, place, rotation);
    for (const Piece& piece : own.pieces) {
      solid.pieces.push_back(moved(piece, place, rotation));
      clouds.emplace_back(solid.pieces.back().surface);
    }
    if (own.holds) solid.holds = [=, f = own.holds](const Vec3& x) { return f(rotation.transpose() * (x - place)); };
  }
  ShapeKind kind() const { return body.properties.shape.kind; }
};

// m, what a face may separate less than the nearest points do and still give the normal (convex_pairs.cpp).
inline double face_loss(const Shape& shape, double distance) { return 5e-4 * smallest_size(shape) + 0.02 * std::abs(distance); }
// m, how far beside each other the nearest points may be then, across that normal.
inline double beside(const Shape& shape, double distance) {
  return std::sqrt(2 * std::abs(distance) * face_loss(shape, distance));
}
inline bool is_nearest_points(std::uint32_t feature) { return (feature & 1u << 16) != 0; }

// m, by which a point below the axis of a capsule that slants lies within its side: its gap counts the radius along the normal.
inline double within_side(const Placed& body, const Vec3& normal) {
  double most = 0;
  for (const Piece& piece : body.solid.pieces) most = std::max(most, piece.axis.norm() - piece.axis.cross(normal).norm());
  return most;
}

// Whether a point lies on the surface, and on a side of a piece that looks in this direction.
inline bool is_on_surface(const Placed& body, const Vec3& x, const Vec3& outwards, double tolerance) {
  if (sampled_distance(body.solid.surface, x, fineness) > tolerance) return false;
  return std::any_of(body.solid.pieces.begin(), body.solid.pieces.end(), [&](const Piece& piece) {
    if (!piece.depth) return true;
    if (std::abs(piece.depth(x)) > tolerance) return false;
    for (double t = fineness; t < 1; t *= 1.5)
      if (piece.depth(x + t * outwards) > tolerance) return false;
    return true;
  });
}

}  // namespace unibody::samples
