#include "report/measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collide/collide.hpp"
#include "constraints/compliance.hpp"
#include "core/checked.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"
#include "world/limits.hpp"

namespace unibody {

namespace {

enum Sum { depth_squared, kinetic, potential, linear, angular = linear + 3, sum_count = angular + 3 };
enum Count { penetrating, pairs, points, bodies, bytes, integer_count };

bool is_finite(const BodyState& s) {
  return s.position.allFinite() && s.orientation.coeffs().allFinite() && s.velocity.allFinite() && s.angular_velocity.allFinite();
}

// The depths of all pairs of bodies and of all contacts of surfaces: how many there are, the deepest, and the sum of squares. A
// pair has one depth, that of its deepest point.
struct Depths {
  double deepest = 0;  // m
  std::int64_t pairs = 0, penetrating = 0, points = 0;
  ExactSum squares;

  void add(double depth, std::int64_t points_of_pair) {
    deepest = std::max(deepest, depth), squares += depth * depth;
    ++pairs, penetrating += depth > 0 ? 1 : 0, points += points_of_pair;
  }
};

// A pair of bodies with many parts, or whose faces turn on each other, has several manifolds in a row.
Depths depths_of(const World& world, const Contacts& contacts, const MaterialPairs* materials) {
  Depths result;
  const auto gives_way = [&](const Manifold& m) {
    return materials != nullptr && contact_law(*materials, world.properties[static_cast<std::size_t>(m.slot_a)],
                                               world.properties[static_cast<std::size_t>(m.slot_b)])
                                       .complies();
  };
  for (std::size_t first = 0, end = 0; first < contacts.manifolds.size(); first = end) {
    const Manifold& pair = contacts.manifolds[first];
    double depth = 0;
    std::int64_t points = 0;
    for (; end < contacts.manifolds.size(); ++end) {
      const Manifold& m = contacts.manifolds[end];
      if (m.id_a != pair.id_a || m.id_b != pair.id_b) break;
      for (std::uint32_t k = 0; k < m.count; ++k) depth = std::max(depth, -contacts.points[m.first + k].gap);
      points += m.count;
    }
    if (counts_here(world, pair)) result.add(gives_way(pair) ? 0 : depth, points);
  }
  for (const SurfaceContact& c : contacts.surface)
    if (counts_here(world, c)) result.add(std::max(0.0, -c.gap), 1);
  return result;
}

void add_body(const BodyProperties& p, const BodyState& s, const Vec3& gravity, std::array<ExactSum, sum_count>& sums) {
  const Vec3 spin = s.orientation.conjugate() * s.angular_velocity;  // body frame
  const Vec3 moment = p.inertia.cwiseProduct(spin);
  const Vec3 momentum = p.mass * s.velocity;
  const Vec3 about_origin = s.position.cross(momentum) + s.orientation * moment;
  sums[kinetic] += 0.5 * (momentum.dot(s.velocity) + moment.dot(spin));
  sums[potential] += -p.mass * gravity.dot(s.position);
  for (int k = 0; k < 3; ++k) {
    sums[static_cast<std::size_t>(linear + k)] += momentum[k];
    sums[static_cast<std::size_t>(angular + k)] += about_origin[k];
  }
}

}  // namespace

bool is_sound(const BodyState& state) {
  return is_finite(state) && state.position.cwiseAbs().maxCoeff() <= farthest && state.velocity.norm() < fastest;
}

Measures measure(MPI_Comm comm, const World& world, const Contacts& contacts, const Vec3& gravity, double bytes_here,
                 const MaterialPairs* materials) {
  std::array<ExactSum, sum_count> sums;
  std::array<std::int64_t, integer_count> counts{};
  const Depths depths = depths_of(world, contacts, materials);
  std::array<double, 2> largest{depths.deepest, bytes_here};  // depth, memory of a rank
  sums[depth_squared] = depths.squares;
  counts[penetrating] = depths.penetrating, counts[pairs] = depths.pairs, counts[points] = depths.points;
  for (std::size_t slot = 0; slot < world.homes; ++slot) add_body(world.properties[slot], world.state(slot), gravity, sums);
  counts[bodies] = static_cast<std::int64_t>(world.homes);
  counts[bytes] = static_cast<std::int64_t>(bytes_here);

  const auto total = all_sums(comm, sums);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), integer_count, MPI_INT64_T, MPI_SUM, comm));
  make_largest(comm, largest);

  Measures result;
  result.penetration_max = largest[0];
  result.penetration_l2 = std::sqrt(total[depth_squared]);
  if (counts[penetrating] > 0)
    result.penetration_rms = std::sqrt(total[depth_squared] / static_cast<double>(counts[penetrating]));
  result.pairs = counts[pairs], result.contacts = counts[points];
  result.kinetic_energy = total[kinetic], result.potential_energy = total[potential];
  result.linear_momentum = Vec3(total.data() + linear), result.angular_momentum = Vec3(total.data() + angular);
  if (counts[bodies] > 0) result.bytes_per_body = static_cast<double>(counts[bytes]) / static_cast<double>(counts[bodies]);
  result.bytes_of_largest_rank = largest[1];
  return result;
}

Id first_bad_body(MPI_Comm comm, const World& world) {
  constexpr Id none = std::numeric_limits<Id>::max();
  Id bad = none;
  for (std::size_t slot = 0; slot < world.size(); ++slot)
    if (!is_sound(world.state(slot))) bad = std::min(bad, world.id[slot]);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_INT64_T, MPI_MIN, comm));
  return bad == none ? -1 : bad;
}

}  // namespace unibody
