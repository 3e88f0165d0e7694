// Blocks of tetrahedra: each cell of a lattice is split in five, one between four of its corners and one at each of the other
// four. A corner is of the first kind where its three numbers add up to an odd one: neighbouring cells are mirror images of each
// other, so that their faces match, and a block of even numbers of cells is its own mirror image in all three directions. (Cells
// that are all split alike around one diagonal bend sideways under a straight load.) Everything is a pure function of a node's
// number.
#include <algorithm>

#include "scene/solid_shape.hpp"

namespace unibody {

namespace {

using Cell = std::array<Id, 3>;

constexpr Id tetrahedra_of_cell = 5;  // the first between the odd corners, then one at each even corner

bool is_odd(const Cell& c) { return (c[0] + c[1] + c[2]) % 2 != 0; }

struct Block {
  Vec3 size = Vec3::Ones();  // m
  Cell cells{1, 1, 1};
  SolidLaw law;

  Id nodes(std::size_t axis) const { return cells[axis] + 1; }
  Id count() const { return nodes(0) * nodes(1) * nodes(2); }
  Id node(const Cell& c) const { return c[0] + nodes(0) * (c[1] + nodes(1) * c[2]); }
  Cell cell_of(Id node) const { return {node % nodes(0), node / nodes(0) % nodes(1), node / (nodes(0) * nodes(1))}; }
  Vec3 place(const Cell& c) const {
    Vec3 x;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      x[axis] = size[axis] * (static_cast<double>(c[k]) / static_cast<double>(cells[k]) - 0.5);
    }
    return x;
  }
  bool has_cell(const Cell& c) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (c[k] < 0 || c[k] >= cells[k]) return false;
    return true;
  }

  // Corners of a cell's tetrahedron, positively oriented.
  static std::array<Cell, 4> corners(const Cell& cell, Id tetrahedron) {
    std::array<std::array<Cell, 4>, 2> kinds;  // the even and the odd corners
    std::array<std::size_t, 2> count{};
    for (Id k = 0; k < 2; ++k)
      for (Id j = 0; j < 2; ++j)
        for (Id i = 0; i < 2; ++i) {
          const Cell c{cell[0] + i, cell[1] + j, cell[2] + k};
          const std::size_t kind = is_odd(c) ? 1 : 0;
          kinds[kind][count[kind]++] = c;
        }
    std::array<Cell, 4> at = kinds[1];
    if (tetrahedron > 0) {
      const Cell corner = kinds[0][static_cast<std::size_t>(tetrahedron - 1)];
      at.fill(corner);
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis + 1][axis] += corner[axis] == cell[axis] ? 1 : -1;
    }
    if (is_odd(cell)) std::swap(at[2], at[3]);  // the mirror image of an even cell
    return at;
  }

  Id tetrahedron_count() const { return cells[0] * cells[1] * cells[2] * tetrahedra_of_cell; }
  // Nodes of tetrahedron t: those of cell after cell, the first axis fastest.
  std::array<Id, 4> tetrahedron(Id t) const {
    const Id c = t / tetrahedra_of_cell;
    const Cell cell{c % cells[0], c / cells[0] % cells[1], c / (cells[0] * cells[1])};
    const auto at = corners(cell, t % tetrahedra_of_cell);
    return {node(at[0]), node(at[1]), node(at[2]), node(at[3])};
  }

  // Calls f(cell, corner) for each cell that has this node, corner: where in the cell it is, 0 or 1 along each axis.
  template <typename F>
  void for_each_cell_at(const Cell& node, F&& f) const {
    for (Id k = 1; k >= 0; --k)
      for (Id j = 1; j >= 0; --j)
        for (Id i = 1; i >= 0; --i)
          if (const Cell cell{node[0] - i, node[1] - j, node[2] - k}; has_cell(cell)) f(cell, Cell{i, j, k});
  }

  // A node has an eighth of the mass of each of its cells. With a quarter of the mass of each of its tetrahedra, as nodes of a
  // mesh have, odd corners would have five times the mass of even ones, and Gauss-Seidel would leave more undone.
  double mass_of(const Cell& node) const {
    Id cells_at = 0;
    for_each_cell_at(node, [&](const Cell&, const Cell&) { ++cells_at; });
    return law.density * size.prod() / static_cast<double>(8 * cells[0] * cells[1] * cells[2]) * static_cast<double>(cells_at);
  }
};

void add_constraints(const Block& block, Id first, Id node, ConstraintSet& out) {
  block.for_each_cell_at(block.cell_of(node), [&](const Cell& cell, const Cell&) {
    const Id parity = cell[0] % 2 + 2 * (cell[1] % 2) + 4 * (cell[2] % 2);
    for (Id t = 0; t < tetrahedra_of_cell; ++t) {
      const auto at = Block::corners(cell, t);
      std::array<Id, 4> ids;
      for (std::size_t e = 0; e < 4; ++e) ids[e] = block.node(at[e]);
      if (std::find(ids.begin(), ids.end(), node) == ids.end()) continue;
      std::array<Vec3, 4> places;
      for (std::size_t e = 0; e < 4; ++e) places[e] = block.place(at[e]), ids[e] += first;
      add_tetrahedron(block.law, places, ids, static_cast<std::int32_t>(8 * t + parity), out);
    }
  });
}

// The triangles of the surface: those of side 0 (low) of axis 0, then of side 1, then of axis 1 ... Two a cell's face, split
// along the diagonal between its odd corners.
class BlockSurface {
 public:
  explicit BlockSurface(const Block& block) : block_(block) {}

  Id triangle_count() const {
    Id n = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) n += 4 * faces(axis);
    return n;
  }

  std::array<Id, 3> triangle(Id t) const {
    std::size_t axis = 0;
    for (; t >= 4 * faces(axis); ++axis) t -= 4 * faces(axis);
    const Id side = t / (2 * faces(axis)), face = t / 2 % faces(axis);
    const Id along = block_.cells[(axis + 1) % 3];
    return corners(axis, side, face % along, face / along, t % 2);
  }

  void at(Id node, std::vector<std::array<Id, 3>>& out) const {
    const Cell at = block_.cell_of(node);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (Id side = 0; side < 2; ++side) {
        if (at[axis] != side * block_.cells[axis]) continue;
        const Id i0 = at[(axis + 1) % 3], j0 = at[(axis + 2) % 3];
        for (Id j = std::max<Id>(0, j0 - 1); j <= std::min(j0, block_.cells[(axis + 2) % 3] - 1); ++j)
          for (Id i = std::max<Id>(0, i0 - 1); i <= std::min(i0, block_.cells[(axis + 1) % 3] - 1); ++i)
            for (Id t = 0; t < 2; ++t)
              if (const auto n = corners(axis, side, i, j, t); std::find(n.begin(), n.end(), node) != n.end()) out.push_back(n);
      }
  }

 private:
  Id faces(std::size_t axis) const { return block_.cells[(axis + 1) % 3] * block_.cells[(axis + 2) % 3]; }  // of one side

  // Triangle t (0, 1) of a cell's face, counterclockwise from outside.
  std::array<Id, 3> corners(std::size_t axis, Id side, Id i, Id j, Id t) const {
    const auto corner = [&](Id di, Id dj) {
      Cell c{};
      c[axis] = side * block_.cells[axis], c[(axis + 1) % 3] = i + di, c[(axis + 2) % 3] = j + dj;
      return c;
    };
    const auto node = [&](Id di, Id dj) { return block_.node(corner(di, dj)); };
    std::array<Id, 3> n{};
    if (is_odd(corner(0, 0)))
      n = t == 0 ? std::array{node(0, 0), node(1, 0), node(1, 1)} : std::array{node(0, 0), node(1, 1), node(0, 1)};
    else
      n = t == 0 ? std::array{node(0, 0), node(1, 0), node(0, 1)} : std::array{node(1, 0), node(1, 1), node(0, 1)};
    if (side == 0) std::swap(n[1], n[2]);
    return n;
  }

  const Block& block_;
};

void read_block(const Value& value, Block& block) {
  const KeyedMap map(value, block_keys());
  block.size = map.vector("size");
  block.cells = map.integers<3>("cells");
}

Id read_node(const Block& block, const Value& value) {
  if (value.kind != Value::Kind::list || value.entries.size() != 3) value.fail_expected("a node [i, j, k] of the block");
  Cell at;
  for (std::size_t k = 0; k < 3; ++k) at[k] = value.entries[k].integer(0, block.cells[k]);
  return block.node(at);
}

// What an odd number of cells does along an axis; of five and more it is less than a thousandth.
std::string note_of(const Value& value, const Block& block) {
  if (std::none_of(block.cells.begin(), block.cells.end(), [](Id n) { return n == 1 || n == 3; })) return {};
  return value.key +
         ": along an axis of 1 or 3 cells a block is not its own mirror image: under a load across such an axis it bends to "
         "the side too, by up to 21 % (1 cell) or 1 % (3 cells) of its sag; of an even number of cells it does not";
}

// 8 x 8 x 8 nodes.
Id patch_of(const Block& block, Id node) {
  const Cell at = block.cell_of(node);
  return at[0] / 8 + (block.cells[0] / 8 + 1) * (at[1] / 8 + (block.cells[1] / 8 + 1) * (at[2] / 8));
}

}  // namespace

const Keys& block_keys() {
  static const Keys table{"block",
                          "A block of cells of five tetrahedra each, its middle at the solid's position.",
                          {keys::numbers("size", 3, "m", positive, needed, "lengths of the edges along x, y and z"),
                           keys::integers("cells", 3, 1, 100'000, needed,
                                          "cells along each edge; with an even number the block is its own mirror image there")}};
  return table;
}

MeshShape block_solid(const Value& value, const SolidLaw& law) {
  Block block;
  read_block(value, block);
  block.law = law;
  MeshShape shape;
  shape.note = note_of(value, block);
  shape.count = block.count();
  shape.place = [block](Id k) { return block.place(block.cell_of(k)); };
  shape.mass = [block](Id k) { return block.mass_of(block.cell_of(k)); };
  shape.touching = [block](Id first, Id node, ConstraintSet& out) { add_constraints(block, first, node, out); };
  shape.patch = [block](Id node) { return patch_of(block, node); };
  shape.number = [block](const Value& node) { return read_node(block, node); };
  shape.triangle_count = BlockSurface(block).triangle_count();
  shape.triangle = [block](Id t) { return BlockSurface(block).triangle(t); };
  shape.triangles_of = [block](Id node, std::vector<std::array<Id, 3>>& out) { BlockSurface(block).at(node, out); };
  shape.tetrahedron_count = block.tetrahedron_count();
  shape.tetrahedron = [block](Id t) { return block.tetrahedron(t); };
  return shape;
}

}  // namespace unibody
