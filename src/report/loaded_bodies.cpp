#include "report/loaded_bodies.hpp"

#include <algorithm>
#include <map>

#include "world/shapes.hpp"

namespace unibody {

namespace {

struct Sums {
  std::vector<Id> others;
  std::array<double, 6> moments{};  // N m s
};

}  // namespace

std::array<double, 6> symmetric_product(const Vec3& force, const Vec3& way) {
  std::array<double, 6> parts{};
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    parts[static_cast<std::size_t>(k)] = force[k] * way[k];
    parts[static_cast<std::size_t>(3 + k)] = 0.5 * (force[i] * way[j] + force[j] * way[i]);
  }
  return parts;
}

std::vector<LoadedBody> loaded_bodies(std::span<const ContactImpulse> contacts, const Scene& scene, double step) {
  Id end = scene.body_count();  // nodes stand behind
  for (const ConstraintGroup& group : scene.constraint_groups) end = std::min(end, group.first);
  const auto is_body = [&](Id id) { return id >= 0 && id < end; };
  std::map<Id, Sums> all;
  for (const ContactImpulse& contact : contacts)
    for (std::size_t k = 0; k < 4; ++k) {
      if (!is_body(contact.ids[k])) continue;
      Sums& sums = all[contact.ids[k]];
      const Vec3& centre = contact.sides[contact.shares[k] > 0 ? 0 : 1];
      const auto moments = symmetric_product(contact.shares[k] * contact.impulse, centre - contact.point);
      for (std::size_t m = 0; m < moments.size(); ++m) sums.moments[m] += moments[m];
      for (std::size_t l = 0; l < 4; ++l)
        if (contact.shares[k] * contact.shares[l] < 0 && is_body(contact.ids[l])) sums.others.push_back(contact.ids[l]);
    }
  std::vector<LoadedBody> bodies;
  for (auto& [id, sums] : all) {
    const BodyProperties body = scene.body(id).properties;
    if (!body.is_dynamic()) continue;
    std::ranges::sort(sums.others);
    const auto others = std::unique(sums.others.begin(), sums.others.end()) - sums.others.begin();
    LoadedBody& loaded = bodies.emplace_back(LoadedBody{id, static_cast<std::int32_t>(others), sums.moments});
    for (double& x : loaded.stress) x /= step * volume(body.shape);
  }
  return bodies;
}

}  // namespace unibody
