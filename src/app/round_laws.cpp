#include "app/round_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/largest.hpp"

namespace unibody {

namespace {

struct Law {
  PairValue value;
  const char *key, *effect;
};

constexpr std::array laws{Law{PairValue::elastic_modulus, "elastic_modulus", "their contacts are rigid"},
                          Law{PairValue::surface_energy, "surface_energy", "they do not hold each other by it"},
                          Law{PairValue::liquid_volume, "liquid_volume", "no liquid bridges them"}};

// Of the bodies of a material that are not round, over all ranks.
struct Angular {
  bool any = false, several = false, dynamic = false;
};

std::vector<Angular> angular_bodies(const Simulation& simulation) {
  const World& world = simulation.world;
  const std::size_t n = simulation.scene.pairs.materials;
  std::vector<double> ends(3 * n,
                           -HUGE_VAL);  // the largest number of such a body, minus the smallest, and 1 where one is dynamic
  for (std::size_t i = 0; i < world.size(); ++i) {
    const BodyProperties& body = world.properties[i];
    if (is_round(body.shape)) continue;
    double* of = &ends[3 * static_cast<std::size_t>(body.material)];
    const auto id = static_cast<double>(world.id[i]);
    of[0] = std::max(of[0], id), of[1] = std::max(of[1], -id);
    if (body.is_dynamic()) of[2] = 1;
  }
  make_largest(simulation.comm(), ends);
  std::vector<Angular> found(n);
  for (std::size_t m = 0; m < n; ++m) {
    const double* of = &ends[3 * m];
    found[m] = {of[0] >= 0, of[0] >= 0 && of[0] != -of[1], of[2] > 0};
  }
  return found;
}

}  // namespace

std::vector<std::string> laws_without_effect(const Simulation& simulation) {
  std::vector<std::string> warnings;
  const Scene& scene = simulation.scene;
  if (std::ranges::none_of(laws, [&](const Law& law) { return scene.pairs.any(law.value); })) return warnings;
  const std::vector<Angular> angular = angular_bodies(simulation);
  for (std::size_t a = 0; a < scene.pairs.materials; ++a)
    for (std::size_t b = a; b < scene.pairs.materials; ++b) {
      const bool may_meet = a == b ? angular[a].several : angular[a].any && angular[b].any;
      if (!may_meet || !(angular[a].dynamic || angular[b].dynamic)) continue;
      for (const Law& law : laws)
        if (scene.pairs.of(law.value, static_cast<int>(a), static_cast<int>(b)) > 0)
          warnings.push_back(std::string(law.key) + " of " + scene.materials[a] + " and " + scene.materials[b] +
                             " has no effect between two of their bodies neither of which is a sphere, a disc or a particle: "
                             "its law needs a radius, and " +
                             law.effect);
    }
  return warnings;
}

}  // namespace unibody
