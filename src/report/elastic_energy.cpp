#include "report/elastic_energy.hpp"

#include <algorithm>
#include <array>

#include "collide/collide.hpp"
#include "constraints/compliance.hpp"
#include "core/exact_sum.hpp"
#include "report/stretch.hpp"

namespace unibody {

namespace {

template <class C>
double energy_of(const World& world, const Constraint<C>& c) {
  std::array<Vec4d, C::parameter_names.size()> parameters;
  for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(c.parameters[p]);
  std::array<Vec3x4, C::stencil> x;
  for (std::size_t e = 0; e < C::stencil; ++e) {
    const Vec3& at = world.position[static_cast<std::size_t>(world.find(c.ids[e]))];
    x[e] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())};
  }
  Rows<C::stencil, C::rows> rows;
  C::evaluate(parameters, x, rows);
  double energy = 0;
  for (std::size_t k = 0; k < C::rows; ++k)
    if (c.compliance[k] > 0) energy += rows.value[k][0] * rows.value[k][0] / (2 * c.compliance[k]);
  return energy;
}

}  // namespace

double elastic_energy(MPI_Comm comm, const World& world, const ConstraintSet& constraints) {
  std::array<ExactSum, 1> sum;
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list) {
      const bool stores = std::ranges::any_of(c.compliance, [](double e) { return e > 0; });  // links of most cloths do not
      if (stores && counts_here(world, c)) sum[0] += energy_of(world, c);
    }
  });
  return all_sums(comm, sum)[0];
}

double contact_energy(MPI_Comm comm, const World& world, const Contacts& contacts, const MaterialPairs& pairs) {
  std::array<ExactSum, 1> sum;
  for (const Manifold& m : contacts.manifolds) {
    const ContactLaw law = contact_law(pairs, world.properties[static_cast<std::size_t>(m.slot_a)],
                                       world.properties[static_cast<std::size_t>(m.slot_b)]);
    if (!law.complies() || m.is_inner_ring || !counts_here(world, m)) continue;
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p)
      if (const double gap = contacts.points[p].gap; gap < 0) sum[0] += law.energy(-gap);
  }
  return all_sums(comm, sum)[0];
}

}  // namespace unibody
