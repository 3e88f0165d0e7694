// Worlds of surfaces and bodies for the tests of their contacts, without a scene.
#pragma once

#include <memory>
#include <set>

#include "collide/bodies.hpp"
#include "collide/surfaces.hpp"

namespace unibody::samples {

using Cells = std::vector<std::array<Id, 3>>;  // of node numbers; of segments the last two are equal

struct SurfaceWorld {
  std::vector<Surface> surfaces;
  std::vector<Body> bodies;
  World world;
  CollideSettings settings;
  std::unique_ptr<Surfaces> known;

  SurfaceWorld() { settings.friction = {0.5}; }
  SurfaceWorld(const SurfaceWorld&) = delete;
  SurfaceWorld& operator=(const SurfaceWorld&) = delete;

  Id add(Body body) {
    body.id = static_cast<Id>(bodies.size());
    bodies.push_back(body);
    return body.id;
  }
  // Returns the id of the first node.
  Id add_surface(const std::vector<Vec3>& nodes, const Cells& cells, double radius, bool self_collision = false) {
    const auto first = static_cast<Id>(bodies.size());
    for (const Vec3& x : nodes) {
      Body node = body(0, ShapeKind::particle, Vec3(radius, 0, 0), x);
      node.properties.group = static_cast<std::int32_t>(surfaces.size());
      add(node);
    }
    Surface s;
    s.corners = !cells.empty() && cells[0][1] == cells[0][2] ? 2 : 3;
    s.count = static_cast<Id>(cells.size()), s.first_node = first, s.node_count = static_cast<Id>(nodes.size());
    s.cell = [first, cells](Id k) {
      const auto& c = cells[static_cast<std::size_t>(k)];
      return std::array<Id, 3>{first + c[0], first + c[1], first + c[2]};
    };
    s.cells_of = [first, cells](Id node, Cells& out) {
      for (const auto& c : cells)
        if (std::find(c.begin(), c.end(), node - first) != c.end()) out.push_back({first + c[0], first + c[1], first + c[2]});
    };
    s.self_collision = self_collision;
    surfaces.push_back(std::move(s));
    return first;
  }
  // A box of 2 x 2 x 2 cells a side, closed, about the origin; returns the id of its first node.
  Id add_closed_box(const Vec3& half, double radius, const Vec3& position, const Mat3& turn) {
    std::vector<Vec3> nodes;
    std::array<Id, 27> number;
    for (Id k = 0; k < 27; ++k) {
      const Vec3 at(static_cast<double>(k % 3) - 1, static_cast<double>(k / 3 % 3) - 1, static_cast<double>(k / 9) - 1);
      number[static_cast<std::size_t>(k)] = at.isZero() ? -1 : static_cast<Id>(nodes.size());
      if (!at.isZero()) nodes.emplace_back(position + turn * at.cwiseProduct(half));
    }
    Cells cells;
    const std::array<Id, 3> stride{1, 3, 9};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (Id side = 0; side < 2; ++side)
        for (Id quad = 0; quad < 4; ++quad) {
          const Id u = stride[(axis + 1) % 3], v = stride[(axis + 2) % 3];
          const Id corner = 2 * side * stride[axis] + quad % 2 * u + quad / 2 * v;
          std::array<Id, 4> loop{corner, corner + u, corner + u + v, corner + v};  // counterclockwise from the positive side
          for (Id& k : loop) k = number[static_cast<std::size_t>(k)];
          if (side == 0) std::swap(loop[1], loop[3]);
          cells.push_back({loop[0], loop[1], loop[2]}), cells.push_back({loop[0], loop[2], loop[3]});
        }
    const Id first = add_surface(nodes, cells, radius);
    surfaces.back().closed = true;
    return first;
  }
  Body& operator[](Id id) { return bodies[static_cast<std::size_t>(id)]; }

  template <class IsGuest>
  void build(IsGuest is_guest) {
    world = world_of(bodies, is_guest);
    known = std::make_unique<Surfaces>(surfaces);
    known->build(world);
  }
  void build() {
    build([](Id) { return false; });
  }

  Contacts contacts() {
    build();
    Contacts c;
    Collider().collide(world, settings, c, known.get());
    return c;
  }

  // By ids, as all slots are homes in ascending order where there are no statics.
  Vec3 place(Slot s) const { return world.position[static_cast<std::size_t>(s)]; }
  Vec3 point(const SurfaceContact& c, double sign) const {  // of the first side (1) or the second (-1)
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k)
      if (c.slots[k] >= 0 && sign * c.weights[k] > 0) sum += std::abs(c.weights[k]) * place(c.slots[k]);
    return sum;
  }
};

// A sheet of nx x ny nodes in the plane z = 0, centred; cells are cut along alternating diagonals.
struct Sheet {
  std::vector<Vec3> nodes;
  Cells cells;
};
inline Sheet sheet(Id nx, Id ny, double width, double depth) {
  Sheet s;
  for (Id j = 0; j < ny; ++j)
    for (Id i = 0; i < nx; ++i)
      s.nodes.emplace_back(width * (double(i) / double(nx - 1) - 0.5), depth * (double(j) / double(ny - 1) - 0.5), 0);
  for (Id j = 0; j + 1 < ny; ++j)
    for (Id i = 0; i + 1 < nx; ++i) {
      const Id a = i + nx * j, b = a + 1, c = b + nx, d = a + nx;
      if ((i + j) % 2 == 0)
        s.cells.push_back({a, b, c}), s.cells.push_back({a, c, d});
      else
        s.cells.push_back({a, b, d}), s.cells.push_back({b, c, d});
    }
  return s;
}

inline Sheet chain(const std::vector<Vec3>& nodes) {
  Sheet s{nodes, {}};
  for (Id k = 0; k + 1 < static_cast<Id>(nodes.size()); ++k) s.cells.push_back({k, k + 1, k + 1});
  return s;
}

// Triangles without common nodes; some of them without area.
inline Sheet soup(Random& random, int triangles, const Vec3& centre, double spread, double size) {
  Sheet s;
  for (Id k = 0; k < triangles; ++k) {
    const Vec3 at = centre + random.vector(-spread, spread);
    std::array<Vec3, 3> x;
    for (Vec3& p : x) p = at + random.vector(-size, size);
    if (k % 7 == 5) x[2] = x[1];
    if (k % 7 == 6) x[2] = 0.5 * (x[0] + x[1]);
    s.nodes.insert(s.nodes.end(), x.begin(), x.end());
    s.cells.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  return s;
}

}  // namespace unibody::samples
