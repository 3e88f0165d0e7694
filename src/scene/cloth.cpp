// Grid cloths: nodes in rows, linked to their neighbours or covered by membrane triangles.
#include "scene/cloth.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

enum class Diagonals { both, alternating, none };

struct Bending {
  bool dihedral = false;  // angles; else links to the second neighbours
  Spring spring;          // N/m of a link, N m/rad of an angle
};

struct Fabric {
  double youngs_modulus = 0, poissons_ratio = 0, thickness = 0;
  double damping = 0;
};

// A cloth of nx x ny nodes in the x-y plane of its entry, centred. Every cell is two triangles, its diagonal alternating from
// cell to cell, so that no direction is preferred.
struct GridCloth {
  Id nx = 2, ny = 2;
  double width = 1, depth = 1;  // m
  double mass = 0;              // kg, of all
  bool by_area = false;         // a node has the mass of its share of the area; else all have the same
  Diagonals diagonals = Diagonals::both;
  std::optional<Spring> links;
  std::optional<Fabric> membrane;
  std::optional<Bending> bending;

  Id count() const { return nx * ny; }
  Id node(Id i, Id j) const { return i + nx * j; }
  // Squares of 16 x 16 nodes.
  Id patch_of(Id node) const { return node % nx / 16 + node / nx / 16 * ((nx + 15) / 16); }
  bool inside(Id i, Id j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  Vec3 place(Id i, Id j) const {
    return {width * (static_cast<double>(i) / static_cast<double>(nx - 1) - 0.5),
            depth * (static_cast<double>(j) / static_cast<double>(ny - 1) - 0.5), 0};
  }
  double mass_of(Id i, Id j) const {
    if (!by_area) return mass / static_cast<double>(count());
    const double cell = mass / static_cast<double>((nx - 1) * (ny - 1));
    return cell * (i == 0 || i == nx - 1 ? 0.5 : 1) * (j == 0 || j == ny - 1 ? 0.5 : 1);
  }
  static bool rising(Id i, Id j) { return (i + j) % 2 == 0; }  // the cell's diagonal goes from (i, j) to (i + 1, j + 1)
};

// Adds the constraints of one grid that touch a node.
class GridConstraints {
 public:
  GridConstraints(const GridCloth& cloth, Id first, Id node, ConstraintSet& out)
      : cloth_(cloth), first_(first), node_(node), i_(node % cloth.nx), j_(node / cloth.nx), out_(out) {}

  void add() {
    if (cloth_.links) add_links();
    if (cloth_.membrane) add_membranes();
    if (cloth_.bending && cloth_.bending->dihedral) add_angles();
    if (cloth_.bending && !cloth_.bending->dihedral) {
      link_both_ways<BendingLink>(2, 0, cloth_.bending->spring, [](Id i, Id) { return i / 2 % 2; });
      link_both_ways<BendingLink>(0, 2, cloth_.bending->spring, [](Id, Id j) { return 2 + j / 2 % 2; });
    }
  }

 private:
  void add_links() {
    link_both_ways<Distance>(1, 0, *cloth_.links, [](Id i, Id) { return i % 2; });
    link_both_ways<Distance>(0, 1, *cloth_.links, [](Id, Id j) { return 2 + j % 2; });
    if (cloth_.diagonals == Diagonals::none) return;
    link_both_ways<Distance>(1, 1, *cloth_.links, [](Id i, Id) { return 4 + i % 2; });
    link_both_ways<Distance>(-1, 1, *cloth_.links, [](Id i, Id) { return 6 + i % 2; });
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
    if (di != 0 && dj != 0 && cloth_.diagonals == Diagonals::alternating && GridCloth::rising(std::min(i, i + di), j) != (di > 0))
      return;
    Constraint<Link> c;
    c.ids = {first_ + cloth_.node(i, j), first_ + cloth_.node(i + di, j + dj)};
    c.parameters = {(cloth_.place(i, j) - cloth_.place(i + di, j + dj)).norm()};
    c.compliance = {spring.compliance()}, c.damping = spring.damping;
    c.colour = static_cast<std::int32_t>(colour(i, j));
    std::get<ConstraintList<Link>>(out_).push_back(c);
  }

  // Corners of triangle t (0, 1) of the cell (i, j), counterclockwise seen from above.
  std::array<Id, 3> corners(Id i, Id j, int t) const {
    const Id a = cloth_.node(i, j), b = cloth_.node(i + 1, j), c = cloth_.node(i + 1, j + 1), d = cloth_.node(i, j + 1);
    if (GridCloth::rising(i, j)) return t == 0 ? std::array{a, b, c} : std::array{a, c, d};
    return t == 0 ? std::array{a, b, d} : std::array{b, c, d};
  }
  Vec3 place(Id node) const { return cloth_.place(node % cloth_.nx, node / cloth_.nx); }
  bool cell_inside(Id i, Id j) const { return i >= 0 && j >= 0 && i < cloth_.nx - 1 && j < cloth_.ny - 1; }

  void add_membranes() {
    const Fabric& fabric = *cloth_.membrane;
    for (Id j = j_ - 1; j <= j_; ++j)
      for (Id i = i_ - 1; i <= i_; ++i)
        for (int t = 0; t < 2 && cell_inside(i, j); ++t) {
          const auto at = corners(i, j, t);
          if (std::find(at.begin(), at.end(), node_) == at.end()) continue;
          Constraint<Membrane> c;
          c.ids = {first_ + at[0], first_ + at[1], first_ + at[2]};
          c.parameters = Membrane::at_rest(place(at[0]), place(at[1]), place(at[2]));
          const double area = 0.5 * (place(at[1]) - place(at[0])).cross(place(at[2]) - place(at[0])).norm();
          c.compliance =
              Membrane::compliance(fabric.youngs_modulus, fabric.poissons_ratio, area, fabric.thickness, c.parameters[3]);
          c.damping = fabric.damping;
          c.colour = static_cast<std::int32_t>(4 * t + 2 * (j % 2) + i % 2);
          std::get<ConstraintList<Membrane>>(out_).push_back(c);
        }
  }

  // The two triangles at an edge p q, with the corners opposite: p, q, r and q, p, s counterclockwise.
  void angle(Id p, Id q, Id r, Id s, Id colour) {
    if (node_ != p && node_ != q && node_ != r && node_ != s) return;
    const Spring& spring = cloth_.bending->spring;
    Constraint<Dihedral> c;
    c.ids = {first_ + p, first_ + q, first_ + r, first_ + s};
    const double length = (place(p) - place(q)).norm();
    c.parameters = {0, length};
    c.compliance = {length * length * spring.compliance()}, c.damping = spring.damping;
    c.colour = static_cast<std::int32_t>(colour);
    std::get<ConstraintList<Dihedral>>(out_).push_back(c);
  }

  // Of the edge from p to q of a cell's triangle: the third corner.
  Id opposite(Id i, Id j, Id p, Id q) const {
    for (int t = 0; t < 2; ++t) {
      const auto at = corners(i, j, t);
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

const Value& need(const Value& map, const char* key, const std::string& expected) {
  const Value* value = map.find(key);
  if (!value) map.fail_missing(key, expected);
  return *value;
}

void read_grid(const Value& grid, GridCloth& cloth) {
  grid.map({"size", "nodes"});
  const auto size = need(grid, "size", "a list of 2 numbers > 0 (m)").numbers(2, positive, "m");
  const Value& nodes = need(grid, "nodes", "a list of 2 integers >= 2");
  if (nodes.kind != Value::Kind::list || nodes.entries.size() != 2) nodes.fail_expected("a list of 2 integers >= 2");
  cloth.width = size[0], cloth.depth = size[1];
  cloth.nx = nodes.entries[0].integer(2, 1'000'000), cloth.ny = nodes.entries[1].integer(2, 1'000'000);
}

void read_mass(const Value& entry, GridCloth& cloth) {
  const Value *mass = entry.find("mass"), *per_area = entry.find("mass_per_area");
  if (mass && per_area) per_area->fail(per_area->found() + " beside mass " + mass->found(), "only one of mass and mass_per_area");
  if (!mass && !per_area) entry.fail_missing("mass", "a mass (kg) or a mass_per_area (kg/m^2)");
  cloth.by_area = per_area != nullptr;
  cloth.mass = mass ? mass->number(positive, "kg") : per_area->number(positive, "kg/m^2") * cloth.width * cloth.depth;
}

void read_links(const Value& value, GridCloth& cloth) {
  value.map({"diagonals", "stiffness", "damping"});
  cloth.links = read_spring(value, "N/m");
  if (const Value* diagonals = value.find("diagonals"))
    cloth.diagonals = static_cast<Diagonals>(diagonals->choice({"both", "alternating", "none"}));
}

void read_membrane(const Value& value, double thickness, GridCloth& cloth) {
  value.map({"youngs_modulus", "poissons_ratio", "damping"});
  Fabric fabric;
  fabric.youngs_modulus = need(value, "youngs_modulus", "a number > 0 (Pa)").number(positive, "Pa");
  fabric.poissons_ratio = need(value, "poissons_ratio", "a number in (-1, 1)").number({-1, 1, true, true}, "");
  fabric.thickness = thickness;
  if (const Value* damping = value.find("damping")) fabric.damping = damping->number(not_negative, "s");
  cloth.membrane = fabric;
}

void read_bending(const Value& value, GridCloth& cloth) {
  value.map({"model", "stiffness", "damping"});
  Bending bending;
  if (const Value* model = value.find("model")) bending.dihedral = model->choice({"links", "dihedral"}) == 1;
  bending.spring = read_spring(value, bending.dihedral ? "N m/rad" : "N/m");
  cloth.bending = bending;
}

void read_cloth(const Value& entry, Scene& scene) {
  std::vector<std::string> keys = node_keys;
  for (const char* key : {"grid", "mass", "mass_per_area", "thickness", "links", "membrane", "bending"}) keys.emplace_back(key);
  entry.map(keys);
  GridCloth cloth;
  read_grid(need(entry, "grid", "a map with size and nodes"), cloth);
  read_mass(entry, cloth);
  const double thickness = need(entry, "thickness", "a number > 0 (m)").number(positive, "m");
  const Value *links = entry.find("links"), *membrane = entry.find("membrane");
  if (links && membrane) membrane->fail("a membrane beside links", "only one of links and membrane");
  if (links) read_links(*links, cloth);
  if (membrane) read_membrane(*membrane, thickness, cloth);
  if (!links && !membrane) cloth.links = Spring{};
  if (const Value* bending = entry.find("bending")) read_bending(*bending, cloth);

  const Nodes nodes = read_nodes(entry, thickness / 2, scene);
  const Id first = add_flexible(
      scene, nodes, cloth.count(),
      [cloth, nodes](Id k) {
        const Id i = k % cloth.nx, j = k / cloth.nx;
        return nodes.at(cloth.place(i, j), cloth.mass_of(i, j));
      },
      [cloth](Id start, Id node, ConstraintSet& out) { GridConstraints(cloth, start, node, out).add(); },
      [cloth](Id node) { return cloth.patch_of(node); });
  read_pins(entry, scene, first, [&](const Value& node) {
    if (node.kind != Value::Kind::list || node.entries.size() != 2) node.fail_expected("a node [i, j] of the grid");
    return cloth.node(node.entries[0].integer(0, cloth.nx - 1), node.entries[1].integer(0, cloth.ny - 1));
  });
}

}  // namespace

void read_cloths(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("cloths")) read_cloth(entry, scene);
}

}  // namespace unibody
