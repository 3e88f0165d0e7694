// A contact problem written out in full, independent of the batch's layout: rows n, s, t of each point over 6 columns a body.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds {

// m, from a body's centre to where a contact acts on it: half way across the gap, but of what is not round and meets something
// that forces don't move at its own surface.
inline Vec3 arm_to(const Bench& bench, const Manifold& m, const ContactPoint& point, Slot slot) {
  const bool first = slot == m.slot_a;
  const bool round = is_round(bench.world.properties[static_cast<std::size_t>(slot)].shape);
  const bool other_moves = bench.world.properties[static_cast<std::size_t>(first ? m.slot_b : m.slot_a)].is_dynamic();
  const Vec3 half_gap = (first ? 0.5 : -0.5) * std::max(0.0, point.gap) * m.normal;
  return point.position + (other_moves || round ? Vec3(Vec3::Zero()) : half_gap) -
         bench.world.position[static_cast<std::size_t>(slot)];
}

struct Dense {
  Eigen::MatrixXd D;  // rows: 3 a point, in the order of Contacts::points; columns: 6 a body. Velocity of each row: D u
  Eigen::MatrixXd W;  // inverse mass matrix
  Eigen::VectorXd u;  // present velocities

  explicit Dense(const Bench& bench) {
    const auto bodies = static_cast<Eigen::Index>(bench.world.size());
    D.setZero(3 * static_cast<Eigen::Index>(bench.contacts.points.size()), 6 * bodies);
    W.setZero(6 * bodies, 6 * bodies);
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const auto slot = static_cast<std::size_t>(b);
      const BodyProperties& p = bench.world.properties[slot];
      if (!p.is_dynamic()) continue;
      const Mat3 R = bench.world.orientation[slot].toRotationMatrix();
      W.block<3, 3>(6 * b, 6 * b) = Mat3::Identity() / p.mass;
      W.block<3, 3>(6 * b + 3, 6 * b + 3) = R * p.inertia.cwiseInverse().asDiagonal() * R.transpose();
    }
    for (const Manifold& m : bench.contacts.manifolds)
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        const Vec3 s = first_tangent_of(m.normal), axes[3] = {m.normal, s, m.normal.cross(s)};
        for (int d = 0; d < 3; ++d) {
          const Eigen::Index row = 3 * static_cast<Eigen::Index>(k) + d;
          double sign = 1;
          for (const Slot body : {m.slot_a, m.slot_b}) {
            const Vec3 arm = arm_to(bench, m, bench.contacts.points[k], body);
            D.block<1, 3>(row, 6 * body) = sign * axes[d].transpose();
            D.block<1, 3>(row, 6 * body + 3) = sign * arm.cross(axes[d]).transpose();
            sign = -1;
          }
        }
      }
    u = velocities(bench);
  }

  static Eigen::VectorXd velocities(const Bench& bench) {
    Eigen::VectorXd u(6 * static_cast<Eigen::Index>(bench.world.size()));
    for (std::size_t b = 0; b < bench.world.size(); ++b) {
      u.segment<3>(6 * static_cast<Eigen::Index>(b)) = Eigen::Map<const Vec3>(bench.system.bodies[b].v);
      u.segment<3>(6 * static_cast<Eigen::Index>(b) + 3) = Eigen::Map<const Vec3>(bench.system.bodies[b].w);
    }
    return u;
  }

  Eigen::MatrixXd N() const { return D * W * D.transpose(); }
};

// 1/P of each row, as the batch has it.
inline Eigen::VectorXd inverse_scales(const Bench& bench) {
  const ContactBatch& batch = bench.system.contacts();
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(bench.contacts.points.size()));
  for (const auto& block : batch.blocks)
    for (std::size_t l = 0; l < lanes; ++l) {
      if (block.manifold[l] < 0) continue;
      const Manifold& m = bench.contacts.manifolds[static_cast<std::size_t>(block.manifold[l])];
      for (std::uint32_t p = 0; p < m.count; ++p) {
        const Eigen::Index row = 3 * static_cast<Eigen::Index>(m.first + p);
        scale[row] = batch.points[block.first_point + p].inverse_scale[l];
        if (block.first_tangent < 0) continue;
        scale[row + 1] = scale[row + 2] = batch.tangents[static_cast<std::size_t>(block.first_tangent) + p].inverse_scale[l];
      }
    }
  return scale;
}

inline std::vector<ContactBatch::Impulse> impulses_of(const Bench& bench) {
  std::vector<ContactBatch::Impulse> all(bench.contacts.points.size());
  bench.system.contacts().get_impulses(all);
  return all;
}

// Largest eigenvalue of P^-1 N, P diagonal.
double spectral_radius(const Eigen::MatrixXd& N, const Eigen::VectorXd& inverse_scale);

}  // namespace unibody::small_worlds
