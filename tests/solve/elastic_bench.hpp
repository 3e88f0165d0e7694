// Elastic solids for the tests of Newton's method: blocks from scene text, and the St. Venant-Kirchhoff law as textbooks have it.
#pragma once

#include <Eigen/Dense>

#include "collide/bodies.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds {

struct Lame {
  double lambda, mu;  // Pa
};
inline Lame lame(double youngs_modulus, double poissons_ratio) {
  return {youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio)),
          youngs_modulus / (2 * (1 + poissons_ratio))};
}

// First Piola-Kirchhoff stress (Pa) and energy per volume of rest (J/m^3).
inline Eigen::Matrix3d stress(const Eigen::Matrix3d& F, const Lame& law) {
  const Eigen::Matrix3d E = 0.5 * (F.transpose() * F - Eigen::Matrix3d::Identity());
  return F * (law.lambda * E.trace() * Eigen::Matrix3d::Identity() + 2 * law.mu * E);
}
inline double energy_density(const Eigen::Matrix3d& F, const Lame& law) {
  const Eigen::Matrix3d E = 0.5 * (F.transpose() * F - Eigen::Matrix3d::Identity());
  return 0.5 * law.lambda * E.trace() * E.trace() + law.mu * E.squaredNorm();
}

// The tetrahedra of a mesh by their corners' ids, with the places at rest of all nodes.
struct ElasticMesh {
  std::vector<std::array<Id, 4>> cells;
  std::vector<Vec3> rest;  // m
  Lame law;

  static Eigen::Matrix3d edges(const std::array<Id, 4>& cell, const std::vector<Vec3>& x) {
    Eigen::Matrix3d D;
    for (int k = 0; k < 3; ++k) D.col(k) = x[static_cast<std::size_t>(cell[k + 1])] - x[static_cast<std::size_t>(cell[0])];
    return D;
  }
  double energy(const std::vector<Vec3>& x) const {
    double sum = 0;
    for (const auto& cell : cells) {
      const Eigen::Matrix3d rest_edges = edges(cell, rest);
      sum += rest_edges.determinant() / 6 * energy_density(edges(cell, x) * rest_edges.inverse(), law);
    }
    return sum;
  }
  std::vector<Vec3> forces(const std::vector<Vec3>& x) const {  // N, on the nodes
    std::vector<Vec3> f(x.size(), Vec3::Zero());
    for (const auto& cell : cells) {
      const Eigen::Matrix3d rest_edges = edges(cell, rest), X = rest_edges.inverse();
      const Eigen::Matrix3d H = -rest_edges.determinant() / 6 * stress(edges(cell, x) * X, law) * X.transpose();
      for (int k = 0; k < 3; ++k) f[static_cast<std::size_t>(cell[k + 1])] += H.col(k);
      f[static_cast<std::size_t>(cell[0])] -= H.rowwise().sum();
    }
    return f;
  }
};

// The mesh of a simulation that is one solid alone, all of whose nodes are home.
inline ElasticMesh mesh_of(const ConstraintSet& constraints, const std::vector<Vec3>& rest, const Lame& law) {
  ElasticMesh mesh{{}, rest, law};
  for (const auto& c : std::get<ConstraintList<Tetrahedron>>(constraints)) mesh.cells.push_back(c.ids);
  return mesh;
}

inline std::string block_text(const std::string& size, const std::string& cells, const std::string& more) {
  return "solids:\n  - block: {size: " + size + ", cells: " + cells + "}\n    thickness: 0.001\n    " + more + "\n";
}

// The law's tetrahedra between nodes of a mesh, as a scene would make them.
inline ConstraintSet constraints_of(const ElasticMesh& mesh, double youngs_modulus, double poissons_ratio, double damping = 0) {
  ConstraintSet set;
  for (const auto& cell : mesh.cells) {
    Constraint<Tetrahedron>& c = std::get<ConstraintList<Tetrahedron>>(set).emplace_back();
    const auto at = [&](std::size_t k) { return mesh.rest[static_cast<std::size_t>(cell[k])]; };
    c.ids = cell, c.damping = damping;
    c.parameters = Tetrahedron::at_rest(at(0), at(1), at(2), at(3));
    const double volume = ElasticMesh::edges(cell, mesh.rest).determinant() / 6;
    c.compliance = Tetrahedron::compliance(youngs_modulus, poissons_ratio, volume, c.parameters[9]);
  }
  return set;
}

}  // namespace unibody::small_worlds
