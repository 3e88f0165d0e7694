// One constraint at one state, as dense matrices: what Newton's method needs of it beside what the sweeps evaluate.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>

#include "constraints/constraint_type.hpp"

namespace unibody {

// A type whose values are quadratic may give their second derivatives: of row k by nodes a and b, [k][a][b] times the identity.
template <class C>
concept HasSecondDerivatives = requires(const std::array<double, C::parameter_names.size()>& parameters) {
  {
    C::second_derivatives(parameters)
    } -> std::same_as<std::array<std::array<std::array<double, C::stencil>, C::stencil>, C::rows>>;
};

// Values, gradients as a matrix (coordinates of the bodies one after the other by rows), and second derivatives.
template <class C>
struct Local {
  static constexpr int coordinates = 3 * static_cast<int>(C::stencil), rows = static_cast<int>(C::rows);
  using Place = Eigen::Matrix<double, coordinates, 1>;
  using Gradient = Eigen::Matrix<double, coordinates, rows>;
  using Hessian = Eigen::Matrix<double, coordinates, coordinates>;

  static constexpr auto pack(const std::array<Place, lanes>& places) {
    std::array<Vec3x4, C::stencil> x;
    for (std::size_t e = 0; e < C::stencil; ++e)
      for (std::size_t l = 0; l < lanes; ++l) {
        const auto at = places[l].template segment<3>(3 * static_cast<int>(e));
        x[e].x[l] = at[0], x[e].y[l] = at[1], x[e].z[l] = at[2];
      }
    return x;
  }

  static Rows<C::stencil, C::rows> evaluate(const Constraint<C>& c, const std::array<Place, lanes>& places) {
    std::array<Vec4d, C::parameter_names.size()> parameters;
    for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(c.parameters[p]);
    Rows<C::stencil, C::rows> at;
    C::evaluate(parameters, pack(places), at);
    return at;
  }

  static Gradient gradient(const Rows<C::stencil, C::rows>& at, std::size_t lane) {
    Gradient D;
    for (int k = 0; k < rows; ++k)
      for (int e = 0; e < static_cast<int>(C::stencil); ++e) {
        const Vec3x4& g = at.gradient[static_cast<std::size_t>(k)][static_cast<std::size_t>(e)];
        D.template block<3, 1>(3 * e, k) = Vec3(g.x[lane], g.y[lane], g.z[lane]);
      }
    return D;
  }

  static std::array<Hessian, C::rows> second_derivatives(const Constraint<C>& c, const Place& x) {
    if constexpr (HasSecondDerivatives<C>)
      return spread(C::second_derivatives(c.parameters));
    else
      return differences(c, x);
  }

 private:
  static std::array<Hessian, C::rows> spread(const auto& by_nodes) {
    std::array<Hessian, C::rows> H;
    H.fill(Hessian::Zero());
    for (std::size_t k = 0; k < C::rows; ++k)
      for (std::size_t a = 0; a < C::stencil; ++a)
        for (std::size_t b = 0; b < C::stencil; ++b)
          H[k].template block<3, 3>(3 * static_cast<int>(a), 3 * static_cast<int>(b)).diagonal().setConstant(by_nodes[k][a][b]);
    return H;
  }

  // Fourth-order central differences of the gradients: the four lanes are the four points along one coordinate. At a thousandth
  // of the constraint's extent truncation and round-off are both about 1e-12.
  static std::array<Hessian, C::rows> differences(const Constraint<C>& c, const Place& x) {
    double extent = 0;
    for (int e = 3; e < coordinates; e += 3) extent = std::max(extent, (x.template segment<3>(e) - x.template head<3>()).norm());
    const double d = extent > 0 ? 1e-3 * extent : 1e-3;
    std::array<Hessian, C::rows> H;
    for (int j = 0; j < coordinates; ++j) {
      std::array<Place, lanes> places{x, x, x, x};
      places[0][j] += d, places[1][j] -= d, places[2][j] += 2 * d, places[3][j] -= 2 * d;
      const auto at = evaluate(c, places);
      const Gradient slope = (8 * (gradient(at, 0) - gradient(at, 1)) - (gradient(at, 2) - gradient(at, 3))) / (12 * d);
      for (int k = 0; k < rows; ++k) H[static_cast<std::size_t>(k)].col(j) = slope.col(k);
    }
    for (Hessian& h : H) h = (0.5 * (h + h.transpose())).eval();
    return H;
  }
};

}  // namespace unibody
