// How long a step the solvers take along each row of a contact.

#include <cassert>

#include "constraints/contact_rows.hpp"

namespace unibody {

using namespace contact_rows;

// Gauss-Seidel: each point's own 3 x 3 block; for cone projections one scalar for its three rows. A contact without
// friction has no tangents, also beside others in its block: who they are depends on the rank.
void ContactBatch::scale_gauss_seidel(Block& block, std::span<const SolverBody> bodies) {
  const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
  const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
  const Vec3x4 t = cross(block.n, block.s);
  const Mask4 rough = block.friction > broadcast(0);
  for (std::uint32_t p = 0; p < block.count; ++p) {
    Point& point = points[block.first_point + p];
    const Vec4d in_use = point.inverse_scale;
    if (block.first_tangent < 0) {
      point.inverse_scale = inverse_or_zero(mobility<false>(block, t, point, a, b, inertia).nn * in_use);
      continue;
    }
    const Mobility k = mobility<true>(block, t, point, a, b, inertia);
    Tangents& tangent = tangents[block.first_tangent + p];
    couplings[block.first_tangent + p] = {k.ns, k.nt};
    point.inverse_scale = inverse_or_zero(k.nn * in_use);
    tangent.inverse_scale = inverse_or_zero(select(rough, k.tangential() * in_use, broadcast(0)));
    if (uses_cone_projection(friction_)) {
      const Vec4d coupling = abs(k.ns) + abs(k.nt);
      const Vec4d bound = max(k.nn + coupling, max(k.ss + abs(k.st) + abs(k.ns), k.tt + abs(k.st) + abs(k.nt)));
      point.inverse_scale = inverse_or_zero(select(rough, bound, k.nn) * in_use);
      tangent.inverse_scale = select(rough, point.inverse_scale, broadcast(0));
    }
  }
}

// Jacobi: absolute row sums of the whole manifold block, masses split by the bodies' constraint counts (Cauchy-Schwarz over a
// body's manifolds, then diagonal dominance): the scaled matrix then has no eigenvalue above 1, so that no relaxation parameter
// is needed.
void ContactBatch::scale_jacobi(Block& block, std::span<const SolverBody> bodies, std::span<const std::int32_t> counts) {
  const Side of_a = gather(block.slot_a, bodies), of_b = gather(block.slot_b, bodies);
  const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
  Vec4d split_a{}, split_b{};
  for (std::size_t l = 0; l < lanes; ++l) {
    split_a[l] = std::max(1.0, scaling_ * counts[block.slot_a[l]]);
    split_b[l] = std::max(1.0, scaling_ * counts[block.slot_b[l]]);
  }
  const Vec4d linear = split_a * of_a.mass + split_b * of_b.mass;
  const auto turn_a = [&](const Vec3x4& torque) { return inertia ? multiply(inertia->a, torque) : torque * of_a.inertia; };
  const auto turn_b = [&](const Vec3x4& torque) { return inertia ? multiply(inertia->b, torque) : torque * of_b.inertia; };
  const std::uint32_t rows_a_point = block.first_tangent < 0 ? 1 : 3;
  const std::uint32_t rows = rows_a_point * block.count;
  assert(rows <= 24);
  const Vec3x4 axes[3] = {block.n, block.s, cross(block.n, block.s)};
  Vec3x4 a[24], b[24], wa[24], wb[24];
  Vec4d in_use[24], sum[24];
  for (std::uint32_t p = 0; p < block.count; ++p) {
    const Point& point = points[block.first_point + p];
    for (std::uint32_t d = 0; d < rows_a_point; ++d) {
      const std::uint32_t i = rows_a_point * p + d;
      a[i] = cross(point.arm_a, axes[d]), b[i] = cross(point.arm_b, axes[d]);
      wa[i] = turn_a(a[i]) * split_a, wb[i] = turn_b(b[i]) * split_b;
      in_use[i] = point.inverse_scale;
      if (d > 0) in_use[i] = select(block.friction > broadcast(0), in_use[i], broadcast(0));
      sum[i] = broadcast(0);
    }
  }
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = i; j < rows; ++j) {
      Vec4d entry = dot(a[i], wa[j]) + dot(b[i], wb[j]);
      if ((j - i) % rows_a_point == 0) entry += linear;
      entry = abs(entry) * in_use[i] * in_use[j];
      sum[i] += entry;
      if (j != i) sum[j] += entry;
    }
  for (std::uint32_t p = 0; p < block.count; ++p) {
    const std::uint32_t i = rows_a_point * p;
    const auto set = [](Vec4d& scale, Vec4d& inverse, Vec4d value) { scale = value, inverse = inverse_or_zero(value); };
    Point& point = points[block.first_point + p];
    Vec4d& scale = normal_scales[block.first_point + p];
    if (rows_a_point == 1) {
      set(scale, point.inverse_scale, sum[i]);
      continue;
    }
    Vec4d tangential = max(sum[i + 1], sum[i + 2]), normal = sum[i];
    if (uses_cone_projection(friction_)) normal = tangential = max(normal, tangential);
    const std::size_t k = block.first_tangent + p;
    set(scale, point.inverse_scale, normal);
    set(tangent_scales[k], tangents[k].inverse_scale, select(block.friction > broadcast(0), tangential, broadcast(0)));
  }
}

}  // namespace unibody
