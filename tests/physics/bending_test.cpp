// Bending of cloths by angles between triangles, against plates.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "scene/scene_text.hpp"
#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::bending_test {

namespace {

constexpr double stiffness = 0.02;  // N m/rad, of each inner edge

// A cloth of 9 x 9 nodes whose squares are halved by diagonals, alternating as in grids, or all in one direction; and that,
// sheared until all triangles are equilateral.
enum class Lattice { alternating, one_way, equilateral };

constexpr int cells = 8;
constexpr double spacing = 1.0 / cells;  // m

Eigen::Matrix2d shape_of(Lattice lattice) {
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
  if (lattice == Lattice::equilateral) shape << 1, -0.5, 0, std::sqrt(0.75);
  return shape;
}

std::string mesh_of(Lattice lattice) {
  std::ostringstream text;
  text.precision(17);
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      text << "v " << (shape_of(lattice) * Eigen::Vector2d(spacing * i - 0.5, spacing * j - 0.5)).transpose() << " 0\n";
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = 1 + i + (cells + 1) * j, d = a + cells + 1;
      text << "f " << a << ' ' << a + 1 << ' ' << d + 1 << "\nf " << a << ' ' << d + 1 << ' ' << d << '\n';
    }
  return text.str();
}

bool in_outer_rows(Id node) {
  const Id i = node % (cells + 1), j = node / (cells + 1);
  return std::min({i, j, cells - i, cells - j}) < 2;
}

Scene cloth_of(Lattice lattice) {
  const TextFile mesh(mesh_of(lattice));
  const bool grid = lattice == Lattice::alternating;
  std::ostringstream text;
  text << "gravity: [0, 0, 0]\ncloths:\n  - "
       << (grid ? "grid: {size: [1, 1], nodes: [9, 9]}" : "mesh: " + mesh.path().substr(mesh.path().rfind('/') + 1))
       << "\n    mass: 1\n    thickness: 0.001\n    links: {" << (grid ? "diagonals: alternating, " : "")
       << "stiffness: 10}\n    bending: {model: dihedral, stiffness: " << stiffness << "}\n    pins: [";
  const char* between = "";
  for (Id node = 0; node < (cells + 1) * (cells + 1); ++node) {
    if (!in_outer_rows(node)) continue;
    text << between << "{node: ";
    grid ? text << '[' << node % (cells + 1) << ", " << node / (cells + 1) << "]}" : text << node << '}';
    between = ", ";
  }
  return scene_from_text(text.str() + "]\n");
}

// Energy (J/m^2) of bending within the middle of the cloth, 4 x 4 cells, once the two outer rows of nodes are held on the
// surface z = x . H x / 2, every second one by `out` above it, and the others have come from the surface to equilibrium. Small
// curvatures: the cloth does not stretch.
double energy_per_area(Lattice lattice, const Eigen::Matrix2d& H, double out = 0) {
  Experiment run(cloth_of(lattice));
  World& world = run.world();
  for (std::size_t i = 0; i < world.homes; ++i) {
    Vec3& x = world.position[i];
    x.z() = 0.5 * x.head<2>().dot(H * x.head<2>()) + (in_outer_rows(world.id[i]) && world.id[i] % 2 == 0 ? out : 0);
  }
  run.simulation->detect();
  const ConstraintSet& constraints = run.simulation->ties.constraints;
  const double h = 1;  // s: the slowest wave, of some 60 rad^2/s^2, dies out by that factor in each step
  ReferenceStep step;
  for (int k = 0; k < 6; ++k) advance(world, step = reference_step(world, constraints, Vec3::Zero(), h), h);
  EXPECT_TRUE(step.converged) << step.reason << ' ' << step.residual;

  const double half = 2 * spacing;
  const Eigen::Matrix2d shape = shape_of(lattice), to_square = shape.inverse();
  double energy = 0;
  const auto& angles = std::get<ConstraintList<Dihedral>>(constraints);
  const auto& impulses = std::get<3>(step.multipliers);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const Vec3 middle = 0.5 * (run.position(angles[k].ids[0]) + run.position(angles[k].ids[1]));
    const double beyond = (to_square * middle.head<2>()).lpNorm<Eigen::Infinity>() - half, force = impulses[k][0] / h;
    if (beyond < 1e-3 * spacing) energy += (beyond > -1e-3 * spacing ? 0.5 : 1) * 0.5 * force * force * angles[k].compliance[0];
  }
  return energy / (4 * half * half * shape.determinant());
}

// The curvature of a cylinder whose generators stand at 90 degrees to this direction.
Eigen::Matrix2d cylinder(double curvature, double degrees) {
  const Eigen::Vector2d n(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180));
  return curvature * n * n.transpose();
}

std::vector<Eigen::Matrix2d> curvatures() {
  std::vector<Eigen::Matrix2d> all;
  for (const double degrees : {0.0, 22.5, 45.0, 60.0}) all.push_back(cylinder(1e-3, degrees));
  all.push_back(1e-3 * Eigen::Matrix2d::Identity());
  all.push_back(cylinder(1e-3, 45) - cylinder(1e-3, -45));
  return all;
}

}  // namespace

// Of a surface z = x . H x / 2, edges along x fold by a (Hyy + 2 e), those along y by a (Hxx + 2 e), diagonals by
// a sqrt 2 (-+Hxy - 2 e), where e a is by how much every second node, that with the diagonals, stands out of the surface. In
// equilibrium e = -(Hxx + Hyy) / 8: the cloth is a plate with the energy k / 2 (H : H - (tr H)^2 / 4) per area, whose rigidity
// is 3/4 k and Poisson's ratio -1/3, the same in every direction.
TEST(Bending, AlternatingDiagonalsAreAnIsotropicPlate) {
  for (const Eigen::Matrix2d& H : curvatures()) {
    const double expected = 0.5 * stiffness * (H.squaredNorm() - 0.25 * H.trace() * H.trace());
    const double out = -spacing * spacing * H.trace() / 8;
    EXPECT_NEAR(energy_per_area(Lattice::alternating, H, out), expected, 1e-6 * expected) << H;  // what 6 steps leave
  }
}

// Equilateral triangles: rigidity sqrt(3) / 2 k and ratio -1/3 (H. S. Seung and D. R. Nelson, Phys. Rev. A 38, 1988).
TEST(Bending, EquilateralTrianglesAreAnIsotropicPlate) {
  for (const Eigen::Matrix2d& H : curvatures()) {
    const double expected = stiffness / std::sqrt(3) * (H.squaredNorm() - 0.25 * H.trace() * H.trace());
    EXPECT_NEAR(energy_per_area(Lattice::equilateral, H), expected, 1e-6 * expected) << H;
  }
}

// Diagonals in one direction make every node alike, and the cloth five times stiffer along them than across: edges fold by
// a (Hyy + Hxy), a (Hxx + Hxy) and a sqrt 2 Hxy.
TEST(Bending, DiagonalsInOneDirectionAreBiased) {
  for (const double degrees : {0.0, 45.0, 90.0, 135.0}) {
    const Eigen::Matrix2d H = cylinder(1e-3, degrees);
    const double expected =
        0.5 * stiffness * (std::pow(H(1, 1) + H(0, 1), 2) + std::pow(H(0, 0) + H(0, 1), 2) + 2 * std::pow(H(0, 1), 2));
    EXPECT_NEAR(energy_per_area(Lattice::one_way, H), expected, 1e-6 * expected) << degrees;
  }
}

}  // namespace unibody::small_worlds::bending_test
