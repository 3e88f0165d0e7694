// Order of convergence of linear tetrahedra: a manufactured solution at large strains.
#include <gtest/gtest.h>

#include <cmath>

#include "solve/elastic_bench.hpp"
#include "solve/elastic_problem.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds::elastic_convergence_test {

namespace {

using Eigen::Matrix3d;

// A smooth displacement without any symmetry, and its gradient: strains up to about 0.15.
constexpr double amplitude = 0.05;  // m
Vec3 displacement(const Vec3& X) {
  return amplitude * Vec3(std::sin(2 * X.x() + X.y()), std::cos(2 * X.y() - X.z()), std::sin(X.x() + 2 * X.z()) * X.y());
}
Matrix3d deformation_gradient(const Vec3& X) {
  const double first = std::cos(2 * X.x() + X.y()), second = std::sin(2 * X.y() - X.z()), third = X.x() + 2 * X.z();
  Matrix3d slope;
  slope << 2 * first, first, 0,  //
      0, -2 * second, second,    //
      std::cos(third) * X.y(), std::sin(third), 2 * std::cos(third) * X.y();
  return Matrix3d::Identity() + amplitude * slope;
}

// N/m^3: minus the divergence of the nominal stress, by differences of order 6.
Vec3 body_force(const Vec3& X, const Lame& law) {
  constexpr double d = 0.01;
  constexpr std::array weights{3.0 / 4, -3.0 / 20, 1.0 / 60};
  Vec3 divergence = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 1; k <= 3; ++k) {
      const Vec3 away = k * d * Vec3::Unit(axis);
      const Matrix3d difference = stress(deformation_gradient(X + away), law) - stress(deformation_gradient(X - away), law);
      divergence += weights[static_cast<std::size_t>(k - 1)] / d * difference.col(axis);
    }
  return -divergence;
}

// f(point's barycentric weights, its volume) at the four points that are exact for squares.
template <typename F>
void for_each_point(double volume, F&& f) {
  const double far = (5 - std::sqrt(5.0)) / 20;
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector4d weights = Eigen::Vector4d::Constant(far);
    weights[k] = 1 - 3 * far;
    f(weights, volume / 4);
  }
}

Vec3 between(const std::array<Id, 4>& cell, const std::vector<Vec3>& x, const Eigen::Vector4d& weights) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 4; ++k) sum += weights[k] * x[static_cast<std::size_t>(cell[static_cast<std::size_t>(k)])];
  return sum;
}

std::vector<Vec3> consistent_loads(const ElasticMesh& mesh) {
  std::vector<Vec3> loads(mesh.rest.size(), Vec3::Zero());
  for (const auto& cell : mesh.cells)
    for_each_point(ElasticMesh::edges(cell, mesh.rest).determinant() / 6, [&](const Eigen::Vector4d& weights, double volume) {
      const Vec3 force = volume * body_force(between(cell, mesh.rest, weights), mesh.law);
      for (int k = 0; k < 4; ++k) loads[static_cast<std::size_t>(cell[static_cast<std::size_t>(k)])] += weights[k] * force;
    });
  return loads;
}

struct Errors {
  double value, slope;  // L2 of the displacement (m^2.5), of its gradient (m^1.5)
};

Errors errors_of(const ElasticMesh& mesh, const std::vector<Vec3>& x) {
  double value = 0, slope = 0;
  for (const auto& cell : mesh.cells) {
    const Matrix3d rest_edges = ElasticMesh::edges(cell, mesh.rest);
    const Matrix3d F = ElasticMesh::edges(cell, x) * rest_edges.inverse();
    for_each_point(rest_edges.determinant() / 6, [&](const Eigen::Vector4d& weights, double volume) {
      const Vec3 X = between(cell, mesh.rest, weights);
      value += volume * (between(cell, x, weights) - X - displacement(X)).squaredNorm();
      slope += volume * (F - deformation_gradient(X)).squaredNorm();
    });
  }
  return {std::sqrt(value), std::sqrt(slope)};
}

// A cube of 1 m whose surface is held where the solution has it.
Errors errors_of_cube(int cells) {
  constexpr double young = 1e5, poisson = 0.3, huge_step = 1e4;
  const std::string n = std::to_string(cells);
  Experiment run(scene_from_text(block_text("[1, 1, 1]", "[" + n + ", " + n + ", " + n + "]",
                                            "density: 1\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3")));
  run.simulation->make_constraints();
  World& world = run.world();
  const ElasticMesh mesh = mesh_of(run.simulation->ties.constraints, world.position, lame(young, poisson));
  const std::vector<Vec3> loads = consistent_loads(mesh);
  for (std::size_t i = 0; i < mesh.rest.size(); ++i) {
    BodyProperties properties = world.properties[i];
    if (mesh.rest[i].lpNorm<Eigen::Infinity>() > 0.5 - 1e-9) {
      properties.motion = Motion::pinned;
      world.position[i] += displacement(mesh.rest[i]);
    } else {
      properties.force = loads[i];
    }
    world.properties.set(i, properties);
  }
  const ReferenceStep step = reference_step(world, run.simulation->ties.constraints, Vec3::Zero(), huge_step);
  EXPECT_TRUE(step.converged) << cells << " cells: " << step.residual << " m/s, " << step.reason;
  std::vector<Vec3> x = world.position;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += huge_step * step.velocity[i];
  return errors_of(mesh, x);
}

}  // namespace

TEST(ElasticConvergence, AManufacturedSolutionHasTheOrdersOfLinearElements) {
  const std::array<int, 4> meshes{3, 4, 6, 9};
  std::vector<Errors> errors;
  for (const int cells : meshes) errors.push_back(errors_of_cube(cells));
  for (std::size_t k = 1; k < meshes.size(); ++k) {
    const double finer = std::log(static_cast<double>(meshes[k]) / meshes[k - 1]);
    EXPECT_NEAR(std::log(errors[k - 1].value / errors[k].value) / finer, 2, 0.2) << meshes[k];
    EXPECT_NEAR(std::log(errors[k - 1].slope / errors[k].slope) / finer, 1, 0.15) << meshes[k];
  }
}

}  // namespace unibody::small_worlds::elastic_convergence_test
