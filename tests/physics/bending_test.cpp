// Bending of cloths by angles between triangles, against plates and the heavy elastica.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>

#include "scene/scene_text.hpp"
#include "solve/reference_bench.hpp"

namespace unibody::small_worlds {

namespace {

constexpr double stiffness = 0.02;  // N m/rad, of each inner edge

// A square cloth of 9 x 9 nodes, with every triangle's diagonal alternating, as grids have it, or all in one direction, as a
// mesh.
constexpr int cells = 8;
constexpr double spacing = 1.0 / cells;  // m

std::string one_way_mesh() {
  std::ostringstream text;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) text << "v " << spacing * i - 0.5 << ' ' << spacing * j - 0.5 << " 0\n";
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = 1 + i + (cells + 1) * j, d = a + cells + 1;
      text << "f " << a << ' ' << a + 1 << ' ' << d + 1 << "\nf " << a << ' ' << d + 1 << ' ' << d << '\n';
    }
  return text.str();
}

Scene square_cloth(bool alternating) {
  const TextFile mesh(one_way_mesh());
  std::ostringstream text;
  text << "gravity: [0, 0, 0]\ncloths:\n  - "
       << (alternating ? "grid: {size: [1, 1], nodes: [9, 9]}" : "mesh: " + mesh.path().substr(mesh.path().rfind('/') + 1))
       << "\n    mass: 1\n    thickness: 0.001\n    links: {" << (alternating ? "diagonals: alternating, " : "")
       << "stiffness: 10}\n    bending: {model: dihedral, stiffness: " << stiffness << "}\n    pins: [";
  const char* between = "";
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      if (std::min({i, j, cells - i, cells - j}) < 2) {
        text << between << "{node: ";
        alternating ? text << '[' << i << ", " << j << "]}" : text << i + (cells + 1) * j << '}';
        between = ", ";
      }
  return scene_from_text(text.str() + "]\n");
}

// Energy (J/m^2) of bending within the middle of the cloth, 4 x 4 cells, once the two outer rows of nodes are held on the
// surface z = x . H x / 2, every second one by `out` above it, and the others have come from the surface to equilibrium. Small
// curvatures: the cloth does not stretch.
double energy_per_area(bool alternating, const Eigen::Matrix2d& H, double out) {
  Experiment run(square_cloth(alternating));
  World& world = run.world();
  for (std::size_t i = 0; i < world.homes; ++i) {
    Vec3& x = world.position[i];
    const bool pinned = std::max(std::abs(x.x()), std::abs(x.y())) > 0.5 - 1.5 * spacing;
    x.z() = 0.5 * x.head<2>().dot(H * x.head<2>()) + (pinned && world.id[i] % 2 == 0 ? out : 0);  // 9 nodes a row: i + j is even
  }
  run.simulation->detect();
  const ConstraintSet& constraints = run.simulation->constraints;
  const double h = 1;  // s: the slowest wave, of some 60 rad^2/s^2, dies out by that factor in each step
  ReferenceStep step;
  for (int k = 0; k < 6; ++k) advance(world, step = reference_step(world, constraints, Vec3::Zero(), h), h);
  EXPECT_TRUE(step.converged) << step.reason << ' ' << step.residual;

  const double half = 2 * spacing;
  double energy = 0;
  const auto& angles = std::get<ConstraintList<Dihedral>>(constraints);
  const auto& impulses = std::get<3>(step.multipliers);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const Vec3 middle = 0.5 * (run.position(angles[k].ids[0]) + run.position(angles[k].ids[1]));
    const double beyond = std::max(std::abs(middle.x()), std::abs(middle.y())) - half, force = impulses[k][0] / h;
    if (beyond < 1e-3 * spacing) energy += (beyond > -1e-3 * spacing ? 0.5 : 1) * 0.5 * force * force * angles[k].compliance[0];
  }
  return energy / (4 * half * half);
}

// The curvature of a cylinder whose generators stand at 90 degrees to this direction.
Eigen::Matrix2d cylinder(double curvature, double degrees) {
  const Eigen::Vector2d n(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180));
  return curvature * n * n.transpose();
}

}  // namespace

// Of a surface z = x . H x / 2, edges along x fold by a (Hyy + 2 e), those along y by a (Hxx + 2 e), diagonals by
// a sqrt 2 (-+Hxy - 2 e), where e a is by how much every second node, that with the diagonals, stands out of the surface. In
// equilibrium e = -(Hxx + Hyy) / 8: the cloth is a plate with the energy k / 2 (H : H - (tr H)^2 / 4) per area, whose rigidity
// is 3/4 k and Poisson's ratio -1/3, the same in every direction.
TEST(Bending, AlternatingDiagonalsAreAnIsotropicPlate) {
  const double curvature = 1e-3;
  std::vector<Eigen::Matrix2d> all;
  for (const double degrees : {0.0, 22.5, 45.0, 60.0}) all.push_back(cylinder(curvature, degrees));
  all.push_back(curvature * Eigen::Matrix2d::Identity());
  all.push_back(cylinder(curvature, 45) - cylinder(curvature, -45));
  for (const Eigen::Matrix2d& H : all) {
    const double expected = 0.5 * stiffness * (H.squaredNorm() - 0.25 * H.trace() * H.trace());
    const double out = -spacing * spacing * H.trace() / 8;
    EXPECT_NEAR(energy_per_area(true, H, out), expected, 1e-6 * expected) << H;  // (H a)^2 / 100 of stretch
  }
}

// Diagonals in one direction make every node alike, and the cloth five times stiffer along them than across: edges fold by
// a (Hyy + Hxy), a (Hxx + Hxy) and a sqrt 2 Hxy.
TEST(Bending, DiagonalsInOneDirectionAreBiased) {
  for (const double degrees : {0.0, 45.0, 90.0, 135.0}) {
    const Eigen::Matrix2d H = cylinder(1e-3, degrees);
    const double expected =
        0.5 * stiffness * (std::pow(H(1, 1) + H(0, 1), 2) + std::pow(H(0, 0) + H(0, 1), 2) + 2 * std::pow(H(0, 1), 2));
    EXPECT_NEAR(energy_per_area(false, H, 0), expected, 1e-6 * expected) << degrees;
  }
}
}  // namespace unibody::small_worlds
