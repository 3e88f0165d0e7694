// Contacts of surfaces as they stand, against closed forms and against distances in wider numbers, feature by feature.
#include "collide/surface_contacts.hpp"

#include <gtest/gtest.h>

#include <map>

#include "collide/reference_distance.hpp"
#include "collide/surface_world.hpp"
#include "collide/triangle_crossing.hpp"

namespace unibody::surface_contacts_test {
namespace {

using namespace samples;

Wide<Long> w(const Vec3& x) { return wide<Long>(x); }

// What holds of every contact of bodies that move little: keys ascend, weights are those of two points, which lie apart by the
// gap and the radii along the normal, and a turning body is touched in the surface's own point.
void expect_consistent(const SurfaceWorld& s, const Contacts& contacts) {
  for (std::size_t i = 0; i < contacts.surface.size(); ++i) {
    const SurfaceContact& c = contacts.surface[i];
    if (i > 0) {
      ASSERT_TRUE(contacts.surface[i - 1].before(c)) << "a key twice";
    }
    double first = 0, second = 0, radii = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (c.slots[k] < 0) {
        ASSERT_EQ(c.ids[k], -1);
        ASSERT_EQ(c.weights[k], 0);
        continue;
      }
      ASSERT_EQ(c.ids[k], s.world.id[static_cast<std::size_t>(c.slots[k])]);
      (c.weights[k] > 0 ? first : second) += c.weights[k];
    }
    ASSERT_NEAR(first, 1, 1e-14);
    ASSERT_NEAR(second, -1, 1e-14);
    ASSERT_NEAR(c.normal.norm(), 1, 1e-14);
    const Shape& shape = s.world.properties[static_cast<std::size_t>(c.slots[0])].shape;
    const int last = c.slots[3] >= 0 ? 3 : c.slots[2] >= 0 ? 2 : 1;
    radii = s.world.properties[static_cast<std::size_t>(c.slots[static_cast<std::size_t>(last)])].shape.size.x();
    const Vec3 on_surface = s.point(c, -1);
    if (shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::box) {
      ASSERT_LT((s.point(c, 1) + c.arm - on_surface).norm(), 1e-13);
    } else {
      ASSERT_EQ(c.arm, Vec3(Vec3::Zero()));
    }
    if (shape.kind == ShapeKind::box) continue;
    radii += shape.size.x();
    ASSERT_LT((s.point(c, 1) - on_surface - (c.gap + radii) * c.normal).norm(), 1e-13);
  }
}

double least_gap(const Contacts& contacts) {
  double least = HUGE_VAL;
  for (const SurfaceContact& c : contacts.surface) least = std::min(least, c.gap);
  for (const ContactPoint& p : contacts.points) least = std::min(least, p.gap);
  return least;
}

// A sheet whose nodes are shifted within its plane, turned at random.
struct TurnedSheet {
  SurfaceWorld s;
  Vec3 origin;
  Mat3 turn;
  Sheet flat;
  static constexpr double thickness = 0.01;

  explicit TurnedSheet(std::uint64_t seed) {
    Random random(seed);
    origin = random.vector(-1, 1), turn = random.turn().toRotationMatrix();
    flat = sheet(6, 5, 1, 0.8);
    Sheet turned = flat;
    for (std::size_t k = 0; k < flat.nodes.size(); ++k) {
      flat.nodes[k] += Vec3(random(-.04, .04), random(-.04, .04), 0);
      turned.nodes[k] = origin + turn * flat.nodes[k];
    }
    s.add_surface(turned.nodes, turned.cells, thickness / 2);
  }
};

}  // namespace

// One face is the contact, not the edges and nodes around: its point is the centre's foot.
TEST(SurfaceContacts, SphereOverAFlatSheetTouchesOneFace) {
  Random random(1);
  int on_node = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    TurnedSheet t(seed);
    const double radius = std::pow(10, random(-2, 0)), gap = random(-0.2, 0.5) * TurnedSheet::thickness;
    const double side = random(0, 1) < 0.5 ? 1 : -1;
    const Vec3 foot(random(-.35, .35), random(-.25, .25), 0);
    const double height = side * (radius + TurnedSheet::thickness / 2 + gap);
    const Vec3 centre = t.origin + t.turn * (foot + Vec3(0, 0, height));
    const Id ball = t.s.add(sphere(0, radius, centre));
    t.s.settings.margin = TurnedSheet::thickness;
    const Contacts found = t.s.contacts();
    expect_consistent(t.s, found);
    ASSERT_EQ(found.surface.size(), 1u) << seed;
    const SurfaceContact& c = found.surface[0];
    ASSERT_EQ(c.ids[0], ball);
    ASSERT_NEAR(c.gap, gap, 1e-14);
    ASSERT_LT((c.normal - side * t.turn.col(2)).norm(), 1e-12);
    ASSERT_LT((t.s.point(c, -1) - t.origin - t.turn * foot).norm(), 1e-13);
    on_node += !found.manifolds.empty();
  }
  EXPECT_GT(on_node, 10) << "no sphere was over a node as well: large ones should be";
}

// Straight over an edge one of its two faces speaks for it, and straight over a node the node alone, as a particle.
TEST(SurfaceContacts, SphereOverAnEdgeAndOverANode) {
  for (const bool over_node : {false, true})
    for (const double side : {1.0, -1.0}) {
      SurfaceWorld s;
      const Sheet flat = sheet(5, 5, 1, 1);  // nodes at whole quarters: exact
      s.add_surface(flat.nodes, flat.cells, 0.0625);
      s.settings.margin = 0.02;  // less than what nodes beside are away
      s.add(sphere(0, 0.125, Vec3(over_node ? 0.25 : 0.125, 0, side * 0.1875)));
      const Contacts found = s.contacts();
      expect_consistent(s, found);
      EXPECT_EQ(found.surface.size(), over_node ? 0u : 1u);
      EXPECT_EQ(found.manifolds.size(), over_node ? 1u : 0u);
      if (over_node) continue;
      EXPECT_EQ(found.surface[0].gap, 0);
      EXPECT_EQ(found.surface[0].slots[3], -1) << "an edge has two ends";
      EXPECT_EQ(found.surface[0].normal, side * Vec3::UnitZ());
    }
}

// Two faces that meet at an edge along y, each risen by an angle: in the valley a sphere touches both, at (c sin(90 - angle));
// on the ridge it touches the edge.
TEST(SurfaceContacts, SphereInAFoldAndOnIt) {
  for (const double degrees : {5.0, 30.0, 60.0}) {
    const double angle = degrees / 180 * M_PI, c = std::cos(angle), r = 0.005;
    for (const bool valley : {true, false}) {
      SurfaceWorld s;
      s.add_surface({{0, -1, 0}, {0, 1, 0}, {c, 0, std::sin(angle)}, {-c, 0, std::sin(angle)}}, {{0, 2, 1}, {0, 1, 3}}, r);
      s.settings.margin = 0.01;
      const double height = 0.1;
      s.add(sphere(0, height * (valley ? c : 1) - r, Vec3(0, 0.1, valley ? height : -height)));
      const Contacts found = s.contacts();
      expect_consistent(s, found);
      ASSERT_EQ(found.surface.size(), valley ? 2u : 1u) << degrees;
      for (const SurfaceContact& contact : found.surface) {
        EXPECT_NEAR(contact.gap, 0, 1e-15);
        EXPECT_NEAR(contact.normal.z(), valley ? c : -1, 1e-14);
        EXPECT_NEAR(std::abs(contact.normal.x()), valley ? std::sin(angle) : 0, 1e-14);
      }
    }
  }
}

// Four corners of a box that lies on a face much larger than it, and the same on a sheet of many faces: corners, and edges where
// it crosses edges of the sheet, all at the height of the box.
TEST(SurfaceContacts, BoxThatLiesFlat) {
  const Vec3 half(0.1, 0.2, 0.05);
  for (const double gap : {1e-3, 0.0, -1e-3})
    for (const int nodes : {2, 9}) {
      SurfaceWorld s;
      const Sheet flat = sheet(nodes, nodes, 2, 2);
      s.add_surface(flat.nodes, flat.cells, 0.01);
      s.settings.margin = 0.002;
      const Quat turn(Eigen::AngleAxisd(0.2, Vec3::UnitZ()));
      const Vec3 centre(0.3, -0.31, half.z() + 0.01 + gap);
      s.add(box(0, half, centre, turn));
      const Contacts found = s.contacts();
      expect_consistent(s, found);
      std::set<std::uint32_t> corners;
      for (const SurfaceContact& c : found.surface) {
        EXPECT_NEAR(c.gap, gap, 1e-14);
        EXPECT_LT((c.normal - Vec3::UnitZ()).norm(), 1e-12);
        if (c.feature >= 8) continue;
        EXPECT_TRUE(corners.insert(c.feature).second) << "a corner twice";
        const Vec3 sign(c.feature & 1 ? 1 : -1, c.feature & 2 ? 1 : -1, c.feature & 4 ? 1 : -1);
        const Vec3 corner = turn * sign.cwiseProduct(half) - Vec3(0, 0, 0.01 + gap);
        EXPECT_LT((c.arm - corner).norm(), 1e-13) << c.feature;
      }
      EXPECT_EQ(corners, (std::set<std::uint32_t>{0, 1, 2, 3}));
      EXPECT_EQ(found.surface.size() == 4, nodes == 2);
    }
}

// Two edges that cross at right angles, in quarter and half of their lengths.
TEST(SurfaceContacts, EdgesThatCross) {
  for (const double side : {1.0, -1.0}) {
    SurfaceWorld s;  // two tents, one upside down over the other
    s.add_surface({{-1, 0, 0}, {3, 0, 0}, {1, 1, -1}, {1, -1, -1}}, {{0, 1, 2}, {1, 0, 3}}, 0.01);
    s.add_surface({{0, -1, .05}, {0, 1, .05}, {1, 0, 1}, {-1, 0, 1}}, {{0, 1, 2}, {1, 0, 3}}, 0.02);
    for (Body& b : s.bodies) b.state.position.z() *= side;
    s.settings.margin = 0.03;
    const Contacts found = s.contacts();
    expect_consistent(s, found);
    ASSERT_EQ(found.surface.size(), 1u);
    const SurfaceContact& c = found.surface[0];
    EXPECT_EQ(c.ids, (std::array<Id, 4>{0, 1, 4, 5}));
    EXPECT_EQ(c.weights, (std::array<double, 4>{0.75, 0.25, -0.5, -0.5}));
    EXPECT_NEAR(c.gap, 0.02, 1e-16);
    EXPECT_EQ(c.normal, -side * Vec3::UnitZ());
    EXPECT_EQ(c.feature, 1000u);
  }
}

// Two soups: nothing between them is nearer than the least gap, nor is that gap made up. All edges are boundaries.
TEST(SurfaceContacts, LeastGapOfTwoSurfacesIsTheirDistance) {
  Random random(2);
  int compared = 0;
  std::map<std::size_t, int> features;
  for (int round = 0; round < 400; ++round) {
    SurfaceWorld s;
    const double size = std::pow(10, random(-1, 0.5));
    const Sheet one = soup(random, 7, Vec3::Zero(), 0.5, size), two = soup(random, 7, random.vector(-2, 2), 0.5, size);
    s.add_surface(one.nodes, one.cells, 0.01), s.add_surface(two.nodes, two.cells, 0.02);
    s.settings.margin = 100;
    Long best = HUGE_VALL;
    bool crossed = false;
    for (const auto& a : one.cells)
      for (const auto& b : two.cells) {
        const auto x = [&](std::size_t k) { return one.nodes[static_cast<std::size_t>(a[k % 3])]; };
        const auto y = [&](std::size_t k) { return two.nodes[static_cast<std::size_t>(b[k % 3])]; };
        for (std::size_t i = 0; i < 3; ++i) {
          best = std::min(best, reference_distance(w(x(i)), w(y(0)), w(y(1)), w(y(2))));
          best = std::min(best, reference_distance(w(y(i)), w(x(0)), w(x(1)), w(x(2))));
          crossed |= edge_crosses_face(x(i), x(i + 1), y(0), y(1), y(2)) || edge_crosses_face(y(i), y(i + 1), x(0), x(1), x(2));
          for (std::size_t j = 0; j < 3; ++j)
            best = std::min(best, reference_distance_of_segments(w(x(i)), w(x(i + 1)), w(y(j)), w(y(j + 1))));
        }
      }
    if (crossed) continue;
    const Contacts found = s.contacts();
    expect_consistent(s, found);
    ASSERT_TRUE(found.manifolds.empty()) << "nodes met as particles";
    ASSERT_NEAR(least_gap(found), root(best) - 0.03, 1e-13) << round;
    ++compared;
    for (const SurfaceContact& c : found.surface)
      if (c.gap == least_gap(found))
        ++features[c.feature == 1000 ? 1000 : static_cast<std::size_t>(std::count_if(c.slots.begin(), c.slots.end(), [](Slot k) {
          return k >= 0;
        }))];
  }
  EXPECT_GT(compared, 200);
  for (const std::size_t kind : {2u, 3u, 4u, 1000u}) EXPECT_GT(features[kind], 5) << "least gaps of this kind: " << kind;
}

// The same for bodies, which meet nodes as particles do and the rest as surfaces.
TEST(SurfaceContacts, LeastGapOfABodyIsItsDistance) {
  Random random(3);
  int spheres = 0, boxes = 0;
  for (int round = 0; round < 1000; ++round) {
    SurfaceWorld s;
    const Sheet one = soup(random, 7, Vec3::Zero(), 0.5, std::pow(10, random(-1, 0.5)));
    s.add_surface(one.nodes, one.cells, 0.01);
    s.settings.margin = 100;
    const bool is_box = round % 2;
    const Vec3 centre = random.vector(-2, 2), half = random.vector(0.05, 0.5);
    const double radius = random(0.01, 0.5);
    const Quat turn = random.turn();
    s.add(is_box ? box(0, half, centre, turn) : sphere(0, radius, centre));
    Long best = HUGE_VALL;
    bool crossed = false;
    const auto corner = [&](int i) {
      return Vec3(centre + turn * Vec3(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]));
    };
    for (const auto& a : one.cells) {
      const auto x = [&](std::size_t k) { return one.nodes[static_cast<std::size_t>(a[k % 3])]; };
      if (!is_box) {
        best = std::min(best, reference_distance(w(centre), w(x(0)), w(x(1)), w(x(2))));
        continue;
      }
      for (int i = 0; i < 8; ++i) {
        best = std::min(best, reference_distance(w(corner(i)), w(x(0)), w(x(1)), w(x(2))));
        for (const int bit : {1, 2, 4}) {
          if (i & bit) continue;
          crossed |= edge_crosses_face(corner(i), corner(i | bit), x(0), x(1), x(2));
          for (std::size_t j = 0; j < 3; ++j)
            best = std::min(best, reference_distance_of_segments(w(corner(i)), w(corner(i | bit)), w(x(j)), w(x(j + 1))));
        }
      }
      for (std::size_t j = 0; j < 3; ++j) {  // a node at a face of the box, an edge through one
        const Vec3 from = turn.inverse() * (x(j) - centre), to = turn.inverse() * (x(j + 1) - centre);
        const double outside = (from.cwiseAbs() - half).cwiseMax(0).norm();
        best = std::min(best, Long(outside) * outside);
        double enter = 0, leave = 1;
        for (Eigen::Index k = 0; k < 3; ++k) {
          const double step = to[k] - from[k], p = (-half[k] - from[k]) / step, q = (half[k] - from[k]) / step;
          enter = std::max(enter, std::min(p, q)), leave = std::min(leave, std::max(p, q));
        }
        crossed |= enter <= leave;
      }
    }
    if (crossed || (!is_box && root(best) < 1e-9)) continue;
    const Contacts found = s.contacts();
    expect_consistent(s, found);
    ASSERT_NEAR(least_gap(found), root(best) - (is_box ? 0 : radius) - 0.01, 1e-13) << round;
    ++(is_box ? boxes : spheres);
  }
  EXPECT_GT(spheres, 300);
  EXPECT_GT(boxes, 200);
}

// A node near its own cloth's faces touches those it is not a corner of, if the cloth collides with itself.
TEST(SurfaceContacts, OfOneSurfaceOnlyWhereItCollidesWithItself) {
  for (const bool itself : {false, true}) {
    SurfaceWorld s;  // a strip folded back over itself
    s.add_surface({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {1.1, 0.5, 0.05}, {.6, 0.4, 0.03}, {.5, 0.6, 0.03}},
                  {{0, 2, 1}, {1, 2, 3}, {3, 2, 4}, {4, 5, 6}}, 0.01, itself);
    s.settings.margin = 0.02;
    const Contacts found = s.contacts();
    expect_consistent(s, found);
    EXPECT_TRUE(found.manifolds.empty());
    if (!itself) {
      EXPECT_TRUE(found.surface.empty());
      continue;
    }
    ASSERT_EQ(found.surface.size(), 2u);
    for (const SurfaceContact& c : found.surface) {
      EXPECT_NEAR(c.gap, 0.01, 1e-15);
      EXPECT_EQ(c.normal, Vec3(Vec3::UnitZ()));
    }
    EXPECT_EQ(found.surface[0].ids[0], 5);
    EXPECT_EQ(found.surface[1].ids[0], 6);
  }
}

// Degenerate faces and nodes at one place: whatever is found is finite.
TEST(SurfaceContacts, DegenerateShapesGiveFiniteContacts) {
  Random random(4);
  std::size_t found = 0;
  for (int round = 0; round < 300; ++round) {
    SurfaceWorld s;
    for (int k = 0; k < 2; ++k) {
      Sheet grains;  // on a coarse lattice, so that much coincides and is parallel
      for (int n = 0; n < 12; ++n) grains.nodes.push_back(0.01 * Vec3(random.vector(-1.4, 1.4).array().round()));
      for (int n = 0; n < 8; ++n) {
        std::array<Id, 3> cell;
        for (Id& id : cell) id = static_cast<Id>(random(0, 12));
        if (cell[0] != cell[1] && cell[1] != cell[2] && cell[0] != cell[2]) grains.cells.push_back(cell);
      }
      s.add_surface(grains.nodes, grains.cells, 0.01, true);
    }
    s.add(sphere(0, 0.01, 0.01 * Vec3(random.vector(-1.4, 1.4).array().round())));
    s.add(box(0, Vec3::Constant(0.01), 0.01 * Vec3(random.vector(-1.4, 1.4).array().round())));
    for (Body& b : s.bodies) b.state.velocity = Vec3(random.vector(-1.4, 1.4).array().round());
    s.settings.has_past = round % 2;
    const Contacts contacts = s.contacts();
    found += contacts.surface.size();
    for (const SurfaceContact& c : contacts.surface) {
      ASSERT_TRUE(c.normal.allFinite() && c.arm.allFinite() && std::isfinite(c.gap) && std::isfinite(c.beyond)) << round;
      ASSERT_NEAR(c.normal.norm(), 1, 1e-12);
      double sum = 0;
      for (const double weight : c.weights) sum += weight;
      ASSERT_NEAR(sum, 0, 1e-14);
    }
    for (std::size_t i = 1; i < contacts.surface.size(); ++i)
      ASSERT_TRUE(contacts.surface[i - 1].before(contacts.surface[i])) << "a key twice";
  }
  EXPECT_GT(found, 5000u);
}

}  // namespace unibody::surface_contacts_test
