#include "constraints/dense_system.hpp"

#include <Eigen/Eigenvalues>

namespace unibody::small_worlds {

double spectral_radius(const Eigen::MatrixXd& N, const Eigen::VectorXd& inverse_scale) {
  const Eigen::VectorXd root = inverse_scale.cwiseSqrt();
  const Eigen::MatrixXd scaled = root.asDiagonal() * N * root.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

}  // namespace unibody::small_worlds
