#include "app/contact_times.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/compliance.hpp"
#include "core/largest.hpp"
#include "core/text.hpp"

namespace unibody {

namespace {

constexpr double steps_of_contact = 20;

// By material, over all ranks: 1/kg of the lightest dynamic body, 1/m of the smallest round one. 0 where there is none.
struct Lightest {
  std::vector<double> inverse_mass, curvature;
};

Lightest lightest_of(const Simulation& simulation) {
  const World& world = simulation.world;
  const std::size_t n = simulation.scene.pairs.materials;
  std::vector<double> all(2 * n, 0.0);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const BodyProperties& body = world.properties[i];
    const auto material = static_cast<std::size_t>(body.material);
    if (body.is_dynamic()) all[material] = std::max(all[material], 1 / body.mass);
    if (is_round(body.shape)) all[n + material] = std::max(all[n + material], 1 / body.shape.size.x());
  }
  make_largest(simulation.comm(), all);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(n);
  return {{all.begin(), middle}, {middle, all.end()}};
}

}  // namespace

std::vector<std::string> unresolved_contacts(const Simulation& simulation) {
  std::vector<std::string> warnings;
  if (!simulation.traits.complies) return warnings;
  const Scene& scene = simulation.scene;
  const Lightest lightest = lightest_of(simulation);
  const double step = scene.time.frame / scene.time.substeps;
  for (std::size_t a = 0; a < scene.pairs.materials; ++a)
    for (std::size_t b = a; b < scene.pairs.materials; ++b) {
      const auto of = [&](PairValue value) { return scene.pairs.of(value, static_cast<int>(a), static_cast<int>(b)); };
      const double mobility = lightest.inverse_mass[a] + lightest.inverse_mass[b],
                   curvature = lightest.curvature[a] + lightest.curvature[b];
      const ContactLaw law{of(PairValue::stiffness), of(PairValue::elastic_modulus), 0, 0, curvature > 0 ? 1 / curvature : 0};
      if (!law.complies() || !(mobility > 0)) continue;
      const double time = contact_time(law, mobility);
      if (steps_of_contact * step <= time) continue;
      warnings.push_back(
          "a step of " + number_text(step, 3) + " s is more than a twentieth of the " + number_text(time, 3) +
          " s for which the lightest bodies of " + scene.materials[a] + " and " + scene.materials[b] +
          " touch: they rebound slower than their damping says; more time.substeps, a shorter time.frame or softer "
          "contacts would follow it");
    }
  return warnings;
}

}  // namespace unibody
