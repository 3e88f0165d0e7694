// Grid cloths: nodes in rows, linked to their neighbours or covered by membrane triangles.
#include <algorithm>
#include <cmath>

#include "scene/cloth_shape.hpp"

namespace unibody {

namespace {

// A cloth of nx x ny nodes in the x-y plane of its entry, centred. Every cell is two triangles, its diagonal alternating from
// cell to cell, so that no direction is preferred.
struct GridCloth {
  Id nx = 2, ny = 2;
  double width = 1, depth = 1;  // m
  ClothLaw law;

  Id count() const { return nx * ny; }
  Id node(Id i, Id j) const { return i + nx * j; }
  bool inside(Id i, Id j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  Vec3 place(Id i, Id j) const {
    return {width * (static_cast<double>(i) / static_cast<double>(nx - 1) - 0.5),
            depth * (static_cast<double>(j) / static_cast<double>(ny - 1) - 0.5), 0};
  }
  double mass_of(Id i, Id j) const {
    if (!law.by_area) return law.mass / static_cast<double>(count());
    const double cell = law.mass * width * depth / static_cast<double>((nx - 1) * (ny - 1));
    return cell * (i == 0 || i == nx - 1 ? 0.5 : 1) * (j == 0 || j == ny - 1 ? 0.5 : 1);
  }
  static bool rising(Id i, Id j) { return (i + j) % 2 == 0; }  // the cell's diagonal goes from (i, j) to (i + 1, j + 1)

  // Corners of triangle t (0, 1) of the cell (i, j), counterclockwise seen from above.
  std::array<Id, 3> corners(Id i, Id j, Id t) const {
    const Id a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
    if (rising(i, j)) return t == 0 ? std::array{a, b, c} : std::array{a, c, d};
    return t == 0 ? std::array{a, b, d} : std::array{b, c, d};
  }
};

// Adds the constraints of one grid that touch a node.
class GridConstraints {
 public:
  GridConstraints(const GridCloth& cloth, Id first, Id node, ConstraintSet& out)
      : cloth_(cloth), first_(first), node_(node), i_(node % cloth.nx), j_(node / cloth.nx), out_(out) {}

  void add() {
    if (cloth_.law.links) add_links();
    if (cloth_.law.membrane)
      add_on_triangles<Membrane>([&](const auto&... at) { return membrane_at_rest(*cloth_.law.membrane, at...); });
    if (cloth_.law.area) add_on_triangles<Area>([&](const auto&... at) { return area_at_rest(*cloth_.law.area, at...); });
    if (cloth_.law.bending && cloth_.law.bending->dihedral) add_angles();
    if (cloth_.law.bending && !cloth_.law.bending->dihedral) {
      link_both_ways<BendingLink>(2, 0, cloth_.law.bending->spring, [](Id i, Id) { return i / 2 % 2; });
      link_both_ways<BendingLink>(0, 2, cloth_.law.bending->spring, [](Id, Id j) { return 2 + j / 2 % 2; });
    }
  }

 private:
  void add_links() {
    link_both_ways<Distance>(1, 0, *cloth_.law.links, [](Id i, Id) { return i % 2; });
    link_both_ways<Distance>(0, 1, *cloth_.law.links, [](Id, Id j) { return 2 + j % 2; });
    if (cloth_.law.diagonals == Diagonals::none) return;
    link_both_ways<Distance>(1, 1, *cloth_.law.links, [](Id i, Id) { return 4 + i % 2; });
    link_both_ways<Distance>(-1, 1, *cloth_.law.links, [](Id i, Id) { return 6 + i % 2; });
  }

  // The links from this node by (di, dj), and to it. The colour is a function of where a link starts.
  template <class Link, typename Colour>
  void link_both_ways(Id di, Id dj, const Spring& spring, Colour&& colour) {
    link<Link>(i_, j_, di, dj, spring, colour);
    link<Link>(i_ - di, j_ - dj, di, dj, spring, colour);
  }

  template <class Link, typename Colour>
  void link(Id i, Id j, Id di, Id dj, const Spring& spring, Colour&& colour) {
    if (!cloth_.inside(i, j) || !cloth_.inside(i + di, j + dj)) return;
    if (di != 0 && dj != 0 && cloth_.law.diagonals == Diagonals::alternating &&
        GridCloth::rising(std::min(i, i + di), j) != (di > 0))
      return;
    auto c = link_at_rest<Link>(spring, cloth_.place(i, j), cloth_.place(i + di, j + dj));
    c.ids = {first_ + cloth_.node(i, j), first_ + cloth_.node(i + di, j + dj)};
    c.colour = static_cast<std::int32_t>(colour(i, j));
    std::get<ConstraintList<Link>>(out_).push_back(c);
  }

  Vec3 place(Id node) const { return cloth_.place(node % cloth_.nx, node / cloth_.nx); }
  bool cell_inside(Id i, Id j) const { return i >= 0 && j >= 0 && i < cloth_.nx - 1 && j < cloth_.ny - 1; }

  // One constraint on each triangle at this node. Two cells of a colour have no node in common.
  template <class C, typename AtRest>
  void add_on_triangles(AtRest&& at_rest) {
    for (Id j = j_ - 1; j <= j_; ++j)
      for (Id i = i_ - 1; i <= i_; ++i)
        for (int t = 0; t < 2 && cell_inside(i, j); ++t) {
          const auto at = cloth_.corners(i, j, t);
          if (std::find(at.begin(), at.end(), node_) == at.end()) continue;
          Constraint<C> c = at_rest(place(at[0]), place(at[1]), place(at[2]));
          c.ids = {first_ + at[0], first_ + at[1], first_ + at[2]};
          c.colour = static_cast<std::int32_t>(4 * t + 2 * (j % 2) + i % 2);
          std::get<ConstraintList<C>>(out_).push_back(c);
        }
  }

  // The two triangles at an edge p q, with the corners opposite: p, q, r and q, p, s counterclockwise.
  void angle(Id p, Id q, Id r, Id s, Id colour) {
    if (node_ != p && node_ != q && node_ != r && node_ != s) return;
    const Spring& spring = cloth_.law.bending->spring;
    auto c = angle_at_rest(spring, 0, (place(p) - place(q)).norm());
    c.ids = {first_ + p, first_ + q, first_ + r, first_ + s};
    c.colour = static_cast<std::int32_t>(colour);
    std::get<ConstraintList<Dihedral>>(out_).push_back(c);
  }

  // The third corner of the cell's triangle that has the edge from p to q.
  Id opposite(Id i, Id j, Id p, Id q) const {
    for (int t = 0; t < 2; ++t) {
      const auto at = cloth_.corners(i, j, t);
      const bool has_p = std::find(at.begin(), at.end(), p) != at.end(), has_q = std::find(at.begin(), at.end(), q) != at.end();
      if (has_p && has_q)
        for (const Id n : at)
          if (n != p && n != q) return n;
    }
    return -1;
  }

  void add_angles() {
    for (Id j = j_ - 2; j <= j_ + 1; ++j)
      for (Id i = i_ - 2; i <= i_ + 1; ++i) {
        if (cell_inside(i, j)) {  // the diagonal
          const Id a = cloth_.node(i, j), b = cloth_.node(i + 1, j), c = cloth_.node(i + 1, j + 1), d = cloth_.node(i, j + 1);
          if (GridCloth::rising(i, j))
            angle(a, c, d, b, i % 2 + 2 * (j % 2));
          else
            angle(b, d, a, c, i % 2 + 2 * (j % 2));
        }
        if (cell_inside(i, j) && cell_inside(i - 1, j)) {  // the edge along y on the left
          const Id p = cloth_.node(i, j), q = cloth_.node(i, j + 1);
          angle(p, q, opposite(i - 1, j, p, q), opposite(i, j, p, q), 4 + i % 3 + 3 * (j % 2));
        }
        if (cell_inside(i, j) && cell_inside(i, j - 1)) {  // the edge along x below
          const Id p = cloth_.node(i, j), q = cloth_.node(i + 1, j);
          angle(p, q, opposite(i, j, p, q), opposite(i, j - 1, p, q), 10 + j % 3 + 3 * (i % 2));
        }
      }
  }

  const GridCloth& cloth_;
  Id first_, node_, i_, j_;
  ConstraintSet& out_;
};

void read_grid(const Value& grid, GridCloth& cloth) {
  const KeyedMap map(grid, grid_keys());
  const auto size = map.numbers("size");
  const auto nodes = map.integers<2>("nodes");
  cloth.width = size[0], cloth.depth = size[1];
  cloth.nx = nodes[0], cloth.ny = nodes[1];
}

// Nodes along a patch: at most 16, and less of a small cloth, so that there are a thousand patches to cut it evenly by.
Id side_of_patches(Id nodes) { return std::clamp(static_cast<Id>(std::sqrt(static_cast<double>(nodes) / 1000)), Id{1}, Id{16}); }

}  // namespace

const Keys& grid_keys() {
  static const Keys table{"grid",
                          "A flat cloth of nodes in rows, its middle at the cloth's position.",
                          {keys::numbers("size", 2, "m", positive, needed, "widths along x and y"),
                           keys::integers("nodes", 2, 2, 1'000'000, needed, "nodes along x and y")}};
  return table;
}

MeshShape grid_cloth(const Value& grid, const ClothLaw& law) {
  GridCloth cloth;
  read_grid(grid, cloth);
  cloth.law = law;
  MeshShape shape;
  shape.count = cloth.count();
  shape.place = [cloth](Id k) { return cloth.place(k % cloth.nx, k / cloth.nx); };
  shape.mass = [cloth](Id k) { return cloth.mass_of(k % cloth.nx, k / cloth.nx); };
  const Id side = side_of_patches(cloth.count());
  shape.patch = [cloth, side](Id node) {
    return node % cloth.nx / side + node / cloth.nx / side * ((cloth.nx + side - 1) / side);
  };
  shape.touching = [cloth](Id first, Id node, ConstraintSet& out) { GridConstraints(cloth, first, node, out).add(); };
  shape.number = [cloth](const Value& node) {
    if (node.kind != Value::Kind::list || node.entries.size() != 2) node.fail_expected("a node [i, j] of the grid");
    return cloth.node(node.entries[0].integer(0, cloth.nx - 1), node.entries[1].integer(0, cloth.ny - 1));
  };
  shape.triangle_count = 2 * (cloth.nx - 1) * (cloth.ny - 1);
  shape.triangle = [cloth](Id t) {
    const Id cell = t / 2;
    return cloth.corners(cell % (cloth.nx - 1), cell / (cloth.nx - 1), t % 2);
  };
  shape.triangles_of = [cloth](Id node, std::vector<std::array<Id, 3>>& out) {
    const Id i0 = node % cloth.nx, j0 = node / cloth.nx;
    for (Id j = std::max<Id>(0, j0 - 1); j <= std::min(j0, cloth.ny - 2); ++j)
      for (Id i = std::max<Id>(0, i0 - 1); i <= std::min(i0, cloth.nx - 2); ++i)
        for (Id t = 0; t < 2; ++t)
          if (const auto at = cloth.corners(i, j, t); std::find(at.begin(), at.end(), node) != at.end()) out.push_back(at);
  };
  return shape;
}

}  // namespace unibody
