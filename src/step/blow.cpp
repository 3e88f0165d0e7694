#include "step/blow.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/friction.hpp"

namespace unibody {

namespace {

void clamp(double& s, double& t, double limit, double across) {
  if (across == 1) {
    const double along = std::hypot(s, t);
    if (along > limit) s *= limit / along, t *= limit / along;
    return;
  }
  Vec4d all_s = broadcast(s), all_t = broadcast(t);
  clamp_ellipse(all_s, all_t, broadcast(limit), broadcast(across));
  s = all_s[0], t = all_t[0];
}

}  // namespace

Vec3 Blow::after(std::uint32_t k) const {
  Vec3 u = before[k];
  for (std::uint32_t l = 0; l < count; ++l) u += K[k][l] * impulse[l];
  return u;
}

void Blow::solve(double restitution, const Friction& friction) {
  if (solve_at(restitution, friction) <= 0 || restitution == 0) return;
  double low = 0, high = 1;
  for (int k = 0; k < 50; ++k) {
    const double share = 0.5 * (low + high);
    (solve_at(share * restitution, friction) > 0 ? high : low) = share;
  }
  solve_at(low * restitution, friction);
}

// Solves by projected Gauss-Seidel. Returns twice the work of the impulses (J).
double Blow::solve_at(double restitution, const Friction& friction) {
  for (std::uint32_t k = 0; k < count; ++k) impulse[k].setZero();
  for (int pass = 0; pass < 200; ++pass) {
    double change = 0, size = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      Vec3& here = impulse[k];
      const Vec3 old = here;
      const Mat3& own = K[k][k];
      const double target = std::max(0.0, -restitution * before[k].x());
      here.x() = std::max(0.0, here.x() - (after(k).x() - target) / own(0, 0));
      if (friction.along > 0) {
        const Vec3 u = after(k);
        const double across = std::max(own(1, 1), own(2, 2)) + std::abs(own(1, 2));
        here.y() -= u.y() / across, here.z() -= u.z() / across;
        clamp(here.y(), here.z(), friction.along * here.x(), friction.across);
      }
      change = std::max(change, (here - old).norm()), size = std::max(size, here.norm());
    }
    if (change <= 1e-15 * size) break;
  }
  double work = 0;
  for (std::uint32_t k = 0; k < count; ++k) work += impulse[k].dot(before[k] + after(k));
  return work;
}

}  // namespace unibody
