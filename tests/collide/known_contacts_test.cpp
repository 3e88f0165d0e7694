// The contacts that KnownContacts hands out are those that collide_parts() finds, both when they are computed and when they are
// reused.
#include "collide/known_contacts.hpp"

#include <gtest/gtest.h>

#include "collide/bodies.hpp"
#include "world/shape_library.hpp"

namespace unibody::samples::known_contacts_test {

namespace {

constexpr double edge = 0.5;  // m

// A floor of two triangles about the origin.
std::uint32_t floor_mesh(bool two_sided) {
  const std::vector<Vec3> nodes{{-edge, -edge, 0}, {edge, -edge, 0}, {edge, edge, 0}, {-edge, edge, 0}};
  const std::vector<std::array<std::int32_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
  shape_library().meshes.push_back(make_mesh_shape(nodes, triangles, 0, two_sided));
  return static_cast<std::uint32_t>(shape_library().meshes.size() - 1);
}

// Bodies near and below the origin, over a floor at 0 and a plane at -0.1 m.
World crowd(bool two_sided) {
  Random random(7);
  std::vector<Body> bodies;
  for (Id id = 0; id < 16; ++id) {
    const Vec3 place = random.vector(-0.15, 0.15);
    if (id % 3 == 0)
      bodies.push_back(sphere(id, random(0.03, 0.06), place));
    else
      bodies.push_back(box(id, random.vector(0.02, 0.06), place, random.turn()));
  }
  bodies.push_back(body(16, ShapeKind::mesh, Vec3(edge, edge, 0), Vec3::Zero(), Motion::fixed));
  bodies.back().properties.shape.data = floor_mesh(two_sided);
  bodies.push_back(plane(17, {0, 0, -0.1}));
  return world_of(bodies);
}

std::vector<Proxy> proxies_of(const World& world, const CollideSettings& settings) {
  std::vector<Proxy> proxies;
  for (std::size_t i = 0; i < world.size(); ++i) proxies.push_back(make_proxy(world, i, settings));
  return proxies;
}

void expect_same(const PairManifold& a, const PairManifold& b) {
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.part_a, b.part_a);
  EXPECT_EQ(a.part_b, b.part_b);
  EXPECT_EQ(a.triangle == nullptr, b.triangle == nullptr);
  if (a.triangle && b.triangle) {
    EXPECT_EQ(a.triangle->nodes, b.triangle->nodes);
    EXPECT_EQ(a.triangle->normal, b.triangle->normal);
  }
  ASSERT_EQ(a.count, b.count);
  for (int k = 0; k < a.count; ++k) {
    EXPECT_EQ(a.points[k].position, b.points[k].position);
    EXPECT_EQ(a.points[k].gap, b.points[k].gap);
    EXPECT_EQ(a.points[k].feature, b.points[k].feature);
  }
}

}  // namespace

// Triangles of a mesh of two sides are made for a body while it is looked at, and must outlive that.
TEST(KnownContacts, AreThoseOfTheSearch) {
  for (const bool two_sided : {false, true}) {
    CollideSettings settings;
    settings.margin = 0.01;
    const World world = crowd(two_sided);
    const std::vector<Proxy> proxies = proxies_of(world, settings);
    KnownContacts known(proxies);
    int contacts = 0, on_mesh = 0;
    for (const int time : {1, 2})
      for (std::size_t i = 0; i < proxies.size(); ++i)
        for (std::size_t j = i + 1; j < proxies.size(); ++j) {
          if (!proxies[i].dynamic) continue;
          std::vector<PairManifold> found;
          std::deque<MeshSurface::Triangle> triangles;
          collide_parts(proxies[i], proxies[j], settings, [&](const PairManifold& m) {
            found.push_back(m);
            if (m.triangle) found.back().triangle = &triangles.emplace_back(*m.triangle);
          });
          std::size_t k = 0;
          known.each(proxies[i], proxies[j], settings, [&](const PairManifold& m) {
            ASSERT_LT(k, found.size());
            SCOPED_TRACE(time);
            expect_same(m, found[k++]);
            ++contacts, on_mesh += m.triangle != nullptr;
          });
          EXPECT_EQ(k, found.size());
        }
    EXPECT_GT(contacts, 20);
    EXPECT_GT(on_mesh, 5);
  }
}

// The contacts of a body that is not among the whole ones are computed again each time, since the body may have moved.
TEST(KnownContacts, AreNotKeptOfBodiesThatAreElsewhere) {
  CollideSettings settings;
  const World world = world_of({sphere(0, 0.1, Vec3::Zero()), sphere(1, 0.1, Vec3(0.15, 0, 0))});
  const std::vector<Proxy> proxies = proxies_of(world, settings);
  KnownContacts known(proxies);
  Proxy part = proxies[1];
  for (const double x : {0.15, 0.17, 0.19}) {
    part.position.x() = x;
    double gap = 0;
    known.each(proxies[0], part, settings, [&](const PairManifold& m) { gap = m.points[0].gap; });
    EXPECT_NEAR(gap, x - 0.2, 1e-12);
  }
}

}  // namespace unibody::samples::known_contacts_test
