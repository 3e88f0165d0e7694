// What Newton's method asks of the constraints of one type: values and gradients at the end of a step, their multipliers on
// trial, and their part of the objective's gradient and Hessian (primal_dual.hpp).
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <span>

#include "coarse/block_matrix.hpp"
#include "constraints/constraint_type.hpp"

namespace unibody {

// A step at some velocities, by slot: up to date on guests too.
struct StepEnd {
  std::span<const Vec3> start, velocity;  // m, at the start of the step; m/s
  double step;                            // s
};

template <class C>
struct ElementRows {
  using Slots = std::array<Slot, C::stencil>;
  using Numbers = std::array<double, C::rows>;
  static constexpr bool has_constant_curvature = requires(const std::array<double, C::parameter_names.size()>& parameters) {
    C::second_derivatives(parameters);
  };

  // Four constraints at a time, the last one repeated where there are fewer.
  ElementRows(std::span<const Constraint<C>> four, std::span<const Slots> slots, const StepEnd& end) {
    std::array<Vec4d, C::parameter_names.size()> parameters;
    std::array<Vec3x4, C::stencil> x;
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::size_t i = std::min(l, four.size() - 1);
      for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p][l] = four[i].parameters[p];
      for (std::size_t e = 0; e < C::stencil; ++e) {
        const auto s = static_cast<std::size_t>(slots[i][e]);
        const Vec3 at = end.start[s] + end.step * end.velocity[s];
        x[e].x[l] = at[0], x[e].y[l] = at[1], x[e].z[l] = at[2];
      }
    }
    C::evaluate(parameters, x, rows_);
  }

  Vec3 gradient(std::size_t lane, std::size_t row, std::size_t node) const {
    const Vec3x4& g = rows_.gradient[row][node];
    return {g.x[lane], g.y[lane], g.z[lane]};
  }

  double length(std::size_t lane, std::size_t row) const { return rows_.value[row][lane]; }  // c, m

  // c + rho D^T v, m
  double value(std::size_t lane, std::size_t row, const Constraint<C>& c, const Slots& slots, const StepEnd& end) const {
    double value = rows_.value[row][lane];
    if (c.damping > 0)
      for (std::size_t e = 0; e < C::stencil; ++e)
        value += c.damping * gradient(lane, row, e).dot(end.velocity[static_cast<std::size_t>(slots[e])]);
    return value;
  }

  // Calls gradient(node, impulse) for -D lambda of each node, and block(e, f, 3 x 3) for each part of the Hessian. `wants(e, f)`
  // says which of these there are.
  template <class OnGradient, class Wants, class OnBlock>
  void add(std::size_t lane, const Constraint<C>& c, const Numbers& softness, const Numbers& lambda, double step,
           OnGradient&& on_gradient, Wants&& wants, OnBlock&& on_block) const {
    using Small = Eigen::Matrix<double, static_cast<int>(C::stencil), static_cast<int>(C::stencil)>;
    Small curvature = Small::Zero();
    if constexpr (has_constant_curvature) curvature = positive_curvature<Small>(c, lambda, step);
    std::array<std::array<Vec3, C::stencil>, C::rows> D;
    for (auto& of_row : D) of_row.fill(Vec3::Zero());  // GCC does not see that all are set
    std::array<double, C::rows> stiffness{};           // of the direction of each row; kg
    for (std::size_t k = 0; k < C::rows; ++k) {
      for (std::size_t e = 0; e < C::stencil; ++e) D[k][e] = gradient(lane, k, e);
      if (softness[k] > 0 && !(is_unilateral<C> && lambda[k] == 0)) stiffness[k] = step * (step + c.damping) / softness[k];
    }
    double across = 0;  // of a link in tension, beside its direction
    if constexpr (is_link<C>) {
      const double length = rows_.value[0][lane] + c.parameters[0];
      if (lambda[0] < 0 && length > 0) across = -step * lambda[0] / length, stiffness[0] -= across;
    }
    for (std::size_t e = 0; e < C::stencil; ++e) {
      Vec3 impulse = Vec3::Zero();
      for (std::size_t k = 0; k < C::rows; ++k) impulse -= lambda[k] * D[k][e];
      on_gradient(e, impulse);
      for (std::size_t f = 0; f < C::stencil; ++f) {
        if (!wants(e, f)) continue;
        double diagonal = e == f ? across : -across;
        if constexpr (has_constant_curvature) diagonal += curvature(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(f));
        BlockMatrix::Block block{Vec4d{diagonal, 0, 0, 0}, Vec4d{0, diagonal, 0, 0}, Vec4d{0, 0, diagonal, 0}};
        for (std::size_t k = 0; k < C::rows; ++k) {
          const Vec3 left = stiffness[k] * D[k][e];
          const Vec4d column{left[0], left[1], left[2], 0};
          for (std::size_t i = 0; i < 3; ++i) block[i] += column * broadcast(D[k][f][static_cast<Eigen::Index>(i)]);
        }
        on_block(e, f, block);
      }
    }
  }

 private:
  // What of -h sum lambda d2c/dx2 is positive semidefinite, a number for each pair of nodes: second derivatives of these types
  // are multiples of the identity.
  template <class Small>
  static Small positive_curvature(const Constraint<C>& c, const Numbers& lambda, double step) {
    Small S = Small::Zero();
    const auto H = C::second_derivatives(c.parameters);
    for (std::size_t k = 0; k < C::rows; ++k)
      for (std::size_t a = 0; a < C::stencil; ++a)
        for (std::size_t b = 0; b < C::stencil; ++b)
          S(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) -= step * lambda[k] * H[k][a][b];
    const Eigen::SelfAdjointEigenSolver<Small> modes(S);
    if (modes.eigenvalues()[0] >= 0) return S;
    return modes.eigenvectors() * modes.eigenvalues().cwiseMax(0).asDiagonal() * modes.eigenvectors().transpose();
  }

  Rows<C::stencil, C::rows> rows_;
};

}  // namespace unibody
