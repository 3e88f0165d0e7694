// Contacts of every pair of kinds of shapes against samples of their surfaces, at random places where they nearly touch or
// overlap a little. A new kind in the list has to say here what its surface is.
#include <gtest/gtest.h>

#include "collide/bodies.hpp"
#include "collide/sampled_surface.hpp"
#include "collide/surface_world.hpp"
#include "world/shape_library.hpp"

namespace unibody::testing {

namespace {

constexpr double fineness = 1e-3;  // m, of samples where they matter

// A solid as sampled, in its own axes or in place.
struct Solid {
  Patches surface;
  std::vector<Patches> pieces;                  // convex, which fill it; none of a mesh or a half space
  std::function<bool(const Vec3&)> holds = {};  // of a mesh

  void add(const Patches& piece) {
    pieces.push_back(piece);
    surface.insert(surface.end(), piece.begin(), piece.end());
  }
};

// Hills over the x-y plane.
double height(double x, double y) { return 0.08 * std::sin(4 * x) * std::cos(3 * y); }
constexpr int cells = 6;
constexpr double width = 1.2;  // m

// m, of the triangles between: cells are cut from their lowest node to their highest.
double height_of_hills(double x, double y) {
  const double i = (x / width + 0.5) * cells, j = (y / width + 0.5) * cells;
  const double u = i - std::floor(i), v = j - std::floor(j), step = width / cells;
  const auto at = [&](int k, int l) {
    return height(step * (std::floor(i) + k) - width / 2, step * (std::floor(j) + l) - width / 2);
  };
  return at(0, 0) +
         (u > v ? u * (at(1, 0) - at(0, 0)) + v * (at(1, 1) - at(1, 0)) : v * (at(0, 1) - at(0, 0)) + u * (at(1, 1) - at(0, 1)));
}

MeshSurface hills() {
  std::vector<Vec3> nodes;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = width * (double(i) / cells - 0.5), y = width * (double(j) / cells - 0.5);
      nodes.emplace_back(x, y, height(x, y));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = i + (cells + 1) * j, b = a + 1, c = a + cells + 1, d = c + 1;
      triangles.push_back({a, b, d}), triangles.push_back({a, d, c});
    }
  return make_mesh_shape(nodes, triangles, 1);
}

// A closed L: two blocks of the plane x-y, with a reentrant edge.
const std::array<std::pair<Vec3, Vec3>, 2> blocks{{{{-.3, -.3, -.15}, {.3, 0, .15}}, {{-.3, 0, -.15}, {0, .3, .15}}}};
MeshSurface ell() {
  const double x[6] = {-.3, .3, .3, 0, 0, -.3}, y[6] = {-.3, -.3, 0, 0, .3, .3};
  std::vector<Vec3> nodes;
  for (const double z : {-.15, .15})
    for (int k = 0; k < 6; ++k) nodes.emplace_back(x[k], y[k], z);
  std::vector<std::array<std::int32_t, 3>> triangles{{6, 7, 8}, {6, 8, 9}, {6, 9, 10}, {6, 10, 11}};
  for (int k = 0; k < 4; ++k) triangles.push_back({0, k + 2, k + 1});
  for (int k = 0; k < 4; ++k) {
    const int l = (k + 1) % 6;
    triangles.push_back({k, l, 6 + l}), triangles.push_back({k, 6 + l, 6 + k});
  }
  return make_mesh_shape(nodes, triangles);
}

bool is_hills(const Shape& s) { return s.kind == ShapeKind::mesh && shape_library().meshes[s.data].nodes.size() > 12; }

Shape hull_of(const std::vector<Vec3>& points) { return shape_library().add(make_hull(points)); }
Shape tee() {
  const Quat lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  const Compound::Part parts[] = {{{ShapeKind::box, {.3, .08, .06}}, Vec3(0, 0, .2), Quat::Identity()},
                                  {{ShapeKind::cylinder, {.07, .07, .2}}, Vec3(.05, 0, 0), Quat::Identity()},
                                  {{ShapeKind::capsule, {.06, .06, .25}}, Vec3(0, .1, -.2), lying}};
  return shape_library().add(make_compound(parts));
}

std::vector<Shape> examples_of(ShapeKind kind) {
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

Patches box_of(const Vec3& h) {
  Patches faces;
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 n = h[k] * Vec3::Unit(k), a = h[(k + 1) % 3] * Vec3::Unit((k + 1) % 3),
                 b = h[(k + 2) % 3] * Vec3::Unit((k + 2) % 3);
      faces.push_back(quad(side * n - a - b, 2 * a, 2 * b));
    }
  return faces;
}

// In its own axes; in the x-z plane where that is where all happens.
Solid solid_of(const Shape& s, bool planar) {
  const double r = s.size.x(), h = s.size.z(), half_pi = std::numbers::pi / 2;
  Solid result;
  switch (s.kind) {
    case ShapeKind::sphere:
    case ShapeKind::particle:
    case ShapeKind::disc:
      result.add(planar ? Patches{ring(r)} : Patches{dome(r, 0, 0, 2 * half_pi)});
      break;
    case ShapeKind::box:
      result.add(planar ? Patches{quad({-r, 0, -h}, {2 * r, 0, 0}, Vec3::Zero()), quad({-r, 0, h}, {2 * r, 0, 0}, Vec3::Zero()),
                                  quad({-r, 0, -h}, {0, 0, 2 * h}, Vec3::Zero()), quad({r, 0, -h}, {0, 0, 2 * h}, Vec3::Zero())}
                        : box_of(s.size));
      break;
    case ShapeKind::plane:
      result.surface = {planar ? quad({-1, 0, 0}, {2, 0, 0}, Vec3::Zero()) : quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})};
      result.holds = [](const Vec3& x) { return x.z() < 0; };
      break;
    case ShapeKind::capsule:
      result.add({tube(r, r - h, h - r), dome(r, h - r, 0, half_pi), dome(r, r - h, half_pi, 2 * half_pi)});
      break;
    case ShapeKind::cylinder:
      result.add({tube(r, -h, h), lid(r, -h), lid(r, h)});
      break;
    case ShapeKind::hull: {
      const Hull& hull = shape_library().hulls[s.data];
      Patches faces;
      for (const Hull::Face& f : hull.faces)
        for (std::uint32_t k = 2; k < f.count; ++k) {
          const auto corner = [&](std::uint32_t i) { return hull.corners[hull.face_corners[f.first + i]]; };
          faces.push_back(triangle(corner(0), corner(k - 1), corner(k)));
        }
      result.add(faces);
      break;
    }
    case ShapeKind::compound:
      for (const Compound::Part& part : shape_library().compounds[s.data].parts)
        result.add(moved(solid_of(part.shape, planar).surface, part.place, part.turn.toRotationMatrix()));
      break;
    case ShapeKind::mesh: {
      const MeshSurface& mesh = shape_library().meshes[s.data];
      for (const auto& t : mesh.triangles) {
        const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t.nodes[k])]; };
        result.surface.push_back(triangle(node(0), node(1), node(2)));
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
  std::vector<Cloud> clouds;  // of convex pieces, of a mesh its triangles

  Placed(const Shape& shape, const Vec3& place, const Quat& turn, bool planar) {
    body.properties.shape = shape;
    body.properties.motion = shape.kind == ShapeKind::plane || shape.kind == ShapeKind::mesh ? Motion::fixed : Motion::dynamic;
    body.state.position = place, body.state.orientation = turn;
    const Solid own = solid_of(shape, planar);
    const Mat3 rotation = turn.toRotationMatrix();
    solid.surface = moved(own.surface, place, rotation);
    for (const Patches& piece : own.pieces) clouds.emplace_back(moved(piece, place, rotation));
    if (shape.kind == ShapeKind::mesh)
      for (const Patch& p : solid.surface) clouds.emplace_back(Patches{p});
    if (own.holds) solid.holds = [=, f = own.holds](const Vec3& x) { return f(rotation.transpose() * (x - place)); };
  }
  ShapeKind kind() const { return body.properties.shape.kind; }
};

struct Trial {
  const Placed &a, &b;  // b may be a plane or a mesh
  bool planar;
  Contacts found;

  // m: what a face may separate less and still give the normal (convex_pairs.cpp), and the samples' error.
  double error(double gap) const {
    const double size = std::min(smallest_size(a.body.properties.shape), smallest_size(b.body.properties.shape));
    return 5e-4 * size + 0.02 * std::abs(gap) + 2 * Cloud::shortfall + fineness;
  }
  double least_gap() const {
    double least = HUGE_VAL;
    for (const ContactPoint& c : found.points) least = std::min(least, c.gap);
    return least;
  }
  std::vector<Vec3> normals() const {
    std::vector<Vec3> result;
    for (const Manifold& m : found.manifolds) result.push_back(m.normal);
    return result;
  }
  bool are_apart(const Cloud& x, const Cloud& y, double limit) const {
    for (const Vec3& n : normals())
      if (sampled_separation(x, y, n) > limit) return true;
    return any_separates(x, y, limit, fineness);
  }
  // Two boxes that are apart say how far across the best of 15 axes, which is less where two corners are nearest.
  bool is_of_axes(const Cloud& x, const Cloud& y) const {
    const double gap = least_gap();
    const auto is_box = [](const Cloud& c) { return c.points.cols() == 6 * 4; };
    const auto is_said = [&](const Vec3& n) { return std::abs(sampled_separation(x, y, n) - gap) < 1e-9; };
    const std::vector<Vec3> all = normals();
    return gap > 0 && is_box(x) && is_box(y) && std::any_of(all.begin(), all.end(), is_said);
  }
  // The least gap is that of the two pieces that are least apart: all others have a direction that separates them by as much, and
  // these have none that does by more.
  void expect_gap_of_pieces() const {
    const double gap = least_gap();
    bool is_attained = false;
    for (const Cloud& x : a.clouds)
      for (const Cloud& y : b.clouds) {
        if ((x.middle - y.middle).norm() - x.radius - y.radius > gap + error(gap)) continue;
        EXPECT_TRUE(are_apart(x, y, gap - fineness)) << "a gap of " << gap << " is too large";
        is_attained = is_attained || is_of_axes(x, y) || !are_apart(x, y, gap + error(gap) - fineness);
      }
    EXPECT_TRUE(is_attained) << "a gap of " << gap << " is too small";
  }
  void expect_gap_over_plane() const {
    const Vec3 up = b.body.state.orientation * Vec3::UnitZ();
    double lowest = HUGE_VAL;
    for (const Cloud& x : a.clouds)
      lowest = std::min(lowest, (up.transpose() * x.points).minCoeff() - up.dot(b.body.state.position));
    EXPECT_LE(least_gap(), lowest + 1e-12);
    EXPECT_GE(least_gap(), lowest - Cloud::shortfall);
    for (const Vec3& n : normals()) EXPECT_LT((n - up).norm(), 1e-12);
  }
  // Somewhere the body is as deep as its samples inside are away from the surface.
  void expect_depth_in_mesh() const {
    double deepest = 0;
    for (const Vec3& x : spread_points(a.solid.surface, 0.02))
      if (b.solid.holds(x)) deepest = std::max(deepest, sampled_distance(b.solid.surface, x, fineness));
    if (deepest == 0) return;
    EXPECT_LE(least_gap(), -deepest * (1 - worst_share) + fineness);
  }
  // Of points with the least gap one lies half way between two that are on the surfaces: others may be on the planes of faces
  // that meet in an edge.
  void expect_point_on_surfaces() const {
    for (const Cloud& x : a.clouds)
      for (const Cloud& y : b.clouds)
        if (is_of_axes(x, y)) return;
    double nearest = HUGE_VAL;
    for (const Manifold& m : found.manifolds)
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        const ContactPoint& c = found.points[k];
        if (c.gap > least_gap() + 1e-9) continue;
        const Vec3 half = 0.5 * c.gap * m.normal;
        const double on_b = b.kind() == ShapeKind::plane ? 0 : sampled_distance(b.solid.surface, c.position - half, fineness);
        nearest = std::min(nearest, std::max(on_b, sampled_distance(a.solid.surface, c.position + half, fineness)));
      }
    EXPECT_LT(nearest, error(least_gap())) << least_gap();
  }
};

CollideSettings still(bool planar) {
  CollideSettings s;
  s.margin = 0.1, s.planar = planar;
  return s;
}

// Where a nearly touches b on its way from `place`; false where it passes by.
bool go_near(const Solid& a, const Solid& b, const Mat3& turn_a, const Mat3& turn_b, const Vec3& way, Vec3& place) {
  const Patches of_b = moved(b.surface, Vec3::Zero(), turn_b);
  for (int i = 0; i < 40; ++i) {
    const double distance = sampled_distance(moved(a.surface, place, turn_a), of_b, 4e-3);
    if (distance < 6e-3) return true;
    if (distance > 4) return false;
    place -= 0.9 * distance * way;
  }
  return false;
}

void run(const Shape& shape_a, const Shape& shape_b, bool planar, Random& random) {
  const auto turn = [&] { return planar ? Quat(Eigen::AngleAxisd(random(0, around), Vec3::UnitY())) : random.turn(); };
  const auto flat = [&](Vec3 x) { return planar ? x.y() = 0, x : x; };
  Quat turn_a, turn_b;
  Vec3 way, place;
  do {
    turn_a = turn(), turn_b = turn(), way = flat(random.vector(-1, 1)).normalized();
    if (shape_b.kind == ShapeKind::plane || is_hills(shape_b))
      way = turn_b * flat(Vec3(random(-.5, .5), random(-.5, .5), 1)).normalized();
    place = 1.5 * way + flat(random.vector(-.1, .1));
  } while (!go_near(solid_of(shape_a, planar), solid_of(shape_b, planar), turn_a.toRotationMatrix(), turn_b.toRotationMatrix(),
                    way, place));
  place += random(-0.02, 0.03) * way;
  Placed a(shape_a, place, turn_a, planar), b(shape_b, Vec3::Zero(), turn_b, planar);
  b.body.id = 1;
  Trial trial{a, b, planar, contacts_of(world_of({a.body, b.body}), still(planar))};
  const double apart = sampled_distance(a.solid.surface, b.solid.surface, fineness);
  ASSERT_FALSE(trial.found.points.empty()) << apart;
  EXPECT_LE(trial.least_gap(), apart + trial.error(apart));
  for (const Vec3& n : trial.normals()) EXPECT_NEAR(n.norm(), 1, 1e-12);
  if (b.kind() == ShapeKind::plane)
    trial.expect_gap_over_plane();
  else if (b.kind() == ShapeKind::mesh && apart < 3 * fineness)
    trial.expect_depth_in_mesh();
  else if (!planar)
    trial.expect_gap_of_pieces();
  trial.expect_point_on_surfaces();

  std::swap(a.body.id, b.body.id);
  const Trial back{a, b, planar, contacts_of(world_of({a.body, b.body}), still(planar))};
  EXPECT_NEAR(back.least_gap(), trial.least_gap(), trial.error(trial.least_gap()));
}

bool are_still(ShapeKind kind) { return kind == ShapeKind::plane || kind == ShapeKind::mesh; }

}  // namespace

TEST(ShapePairs, ContactsAreThoseOfSampledSurfaces) {
  Random random(1);
  for (std::size_t i = 0; i < shape_names.size(); ++i)
    for (std::size_t j = i; j < shape_names.size(); ++j) {
      auto first = static_cast<ShapeKind>(i), second = static_cast<ShapeKind>(j);
      if (are_still(first) && are_still(second)) continue;
      if (are_still(first)) std::swap(first, second);
      for (const bool planar : {false, true}) {
        const bool disc = first == ShapeKind::disc || second == ShapeKind::disc;
        if (planar ? std::max(first, second) > ShapeKind::particle : disc) continue;
        for (const Shape& a : examples_of(first))
          for (const Shape& b : examples_of(second))
            for (int k = 0; k < 4; ++k) {
              SCOPED_TRACE(std::string(shape_names[std::size_t(first)]) + " and " +
                           std::string(shape_names[std::size_t(second)]) + (planar ? ", planar, " : ", ") + std::to_string(k));
              run(a, b, planar, random);
            }
      }
    }
}

}  // namespace unibody::testing
