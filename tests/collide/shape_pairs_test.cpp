// Contacts of every pair of kinds of shapes against samples of their surfaces, at random places where they nearly touch or
// overlap a little. A new kind in the list has to say here what its surface is.
#include <gtest/gtest.h>

#include <span>

#include "collide/sampled_solids.hpp"

namespace unibody::samples::shape_pairs_test {

namespace {

// Two bodies, and what is found between them.
struct Trial {
  const Placed &a, &b;  // b may be a plane or a mesh
  bool planar;
  Contacts found;

  // m, with the samples' error.
  double error(double gap) const {
    return std::min(face_loss(a.body.properties.shape, gap), face_loss(b.body.properties.shape, gap)) + 2 * Cloud::shortfall +
           fineness;
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
  // m, how far an octagon in a cylinder's cap, which is what meets a triangle, lies within the rim.
  static double rim_loss(const Shape& shape) {
    double radius = 0;
    if (shape.kind == ShapeKind::cylinder) radius = shape.size.x();
    if (shape.kind == ShapeKind::compound)
      for (const Compound::Part& part : shape_library().compounds[shape.data].parts)
        radius = std::max(radius, part.shape.kind == ShapeKind::cylinder ? part.shape.size.x() : 0);
    return radius * (1 - std::cos(std::numbers::pi / 8));
  }
  // Somewhere the body is as deep as its samples inside are away from the surface.
  void expect_depth_in_mesh() const {
    double deepest = 0;
    for (const Vec3& x : spread_points(a.solid.surface, 0.02))
      if (b.solid.holds(x)) deepest = std::max(deepest, sampled_distance(b.solid.surface, x, fineness));
    if (deepest == 0) return;
    EXPECT_LE(least_gap(), -deepest * (1 - worst_share) + fineness + rim_loss(a.body.properties.shape));
  }
  std::span<const ContactPoint> points_of(const Manifold& m) const { return std::span(found.points).subspan(m.first, m.count); }
  double least_gap(const Manifold& m) const {
    double least = HUGE_VAL;
    for (const ContactPoint& c : points_of(m)) least = std::min(least, c.gap);
    return least;
  }
  // Whether a triangle with this normal has no sample of the body over it that is deeper than the manifold says.
  bool is_height_over_triangle(const Manifold& m, const std::vector<Vec3>& samples) const {
    return std::any_of(b.solid.pieces.begin(), b.solid.pieces.end(), [&](const Piece& t) {
      const Vec3 p = t.surface[0].at(0, 0), q = t.surface[0].at(1, 0), r = t.surface[0].at(1, 1);
      if ((q - p).cross(r - p).normalized().dot(m.normal) < 1 - 1e-9) return false;
      return std::none_of(samples.begin(), samples.end(), [&](const Vec3& x) {
        const auto is_left = [&](const Vec3& from, const Vec3& to) { return (to - from).cross(x - from).dot(m.normal) >= 0; };
        return is_left(p, q) && is_left(q, r) && is_left(r, p) && m.normal.dot(x - p) < least_gap(m) - 1e-9;
      });
    });
  }
  // Moved along its normal by the depth, two pieces are apart, and by no more: which with the least gap says that the normal is
  // the way out. A triangle of a mesh that the body stands in speaks for what is over it.
  void expect_normals_separate() const {
    std::vector<Vec3> samples;
    if (b.kind() == ShapeKind::mesh) samples = spread_points(a.solid.surface, 0.02);
    for (const Manifold& m : found.manifolds) {
      const double least = least_gap(m);
      double nearest = HUGE_VAL;
      for (const Cloud& x : a.clouds)
        for (const Cloud& y : b.clouds) nearest = std::min(nearest, std::abs(sampled_separation(x, y, m.normal) - least));
      if (nearest < error(least) || b.kind() == ShapeKind::plane) continue;
      EXPECT_TRUE(b.kind() == ShapeKind::mesh && is_height_over_triangle(m, samples)) << least << " is off by " << nearest;
    }
  }
  void expect_on_surface(const Placed& body, const Vec3& x, const Vec3& outwards, const ContactPoint& c) const {
    if (body.kind() == ShapeKind::plane) return;
    double tolerance = error(c.gap) + within_side(body, outwards);
    if (is_nearest_points(c.feature)) tolerance += beside(body.body.properties.shape, c.gap);
    EXPECT_TRUE(is_on_surface(body, x, outwards, tolerance)) << "gap " << c.gap;
  }
  // So that no gap is smaller, and none larger, than what is between the surfaces there.
  void expect_points_on_surfaces() const {
    for (const Manifold& m : found.manifolds)
      for (const ContactPoint& c : points_of(m)) {
        expect_on_surface(a, c.position + 0.5 * c.gap * m.normal, -m.normal, c);
        expect_on_surface(b, c.position - 0.5 * c.gap * m.normal, m.normal, c);
      }
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

void run(const Shape& shape_a, const Shape& shape_b, bool planar, int number, Random& random) {
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
  place += (number == 2 ? random(0.03, 0.08) : random(-0.02, 0.03)) * way;
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
  trial.expect_normals_separate();
  trial.expect_points_on_surfaces();

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
            for (int k = 0; k < 3; ++k) {
              SCOPED_TRACE(std::string(shape_names[std::size_t(first)]) + " and " +
                           std::string(shape_names[std::size_t(second)]) + (planar ? ", planar, " : ", ") + std::to_string(k));
              run(a, b, planar, k, random);
            }
      }
    }
}

}  // namespace unibody::samples::shape_pairs_test
