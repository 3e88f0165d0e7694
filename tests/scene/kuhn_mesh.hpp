// A block of cells that are all split alike, in six tetrahedra around one diagonal (Kuhn), as the text of a Gmsh file: the mesh
// of figures that an independent code computed.
#pragma once

#include <algorithm>
#include <array>
#include <sstream>
#include <string>

#include "core/types.hpp"

namespace unibody {

// About the origin; nodes in order, the first axis fastest.
inline std::string kuhn_mesh(const Vec3& size, const std::array<int, 3>& cells) {
  const auto node = [&](const std::array<int, 3>& c) { return 1 + c[0] + (cells[0] + 1) * (c[1] + (cells[1] + 1) * c[2]); };
  std::ostringstream nodes, tets;
  nodes.precision(17);
  int count = 0;
  for (int k = 0; k <= cells[2]; ++k)
    for (int j = 0; j <= cells[1]; ++j)
      for (int i = 0; i <= cells[0]; ++i) {
        nodes << node({i, j, k});
        const std::array<int, 3> at{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) nodes << ' ' << size[static_cast<Eigen::Index>(a)] * (1.0 * at[a] / cells[a] - 0.5);
        nodes << '\n';
        if (i == cells[0] || j == cells[1] || k == cells[2]) continue;
        std::array<std::size_t, 3> path{0, 1, 2};
        do {
          std::array<int, 3> corner = at;
          tets << ++count << " 4 2 1 1 " << node(corner);
          for (const std::size_t axis : path) ++corner[axis], tets << ' ' << node(corner);
          tets << '\n';
        } while (std::next_permutation(path.begin(), path.end()));
      }
  std::ostringstream text;
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n"
       << (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1) << '\n'
       << nodes.str() << "$EndNodes\n$Elements\n"
       << count << '\n'
       << tets.str() << "$EndElements\n";
  return text.str();
}

}  // namespace unibody
