#include "constraints/compliance.hpp"

#include <algorithm>
#include <cmath>

#include "world/properties.hpp"

namespace unibody {

namespace {

// Of the radius: Hertz' law has no stiffness where the bodies only just touch, but a row needs one.
constexpr double least_overlap = 1e-6, usual_overlap = 1e-3;

// theta, by the square of the step times the contact's angular frequency. A body with a dozen contacts swings some three times as
// fast as with one, and a symplectic step is stable up to an angle of 2.
double implicit_share(double squared_angle) {
  constexpr double resolved = 0.25, unresolved = 1, least = 1e-3;
  return std::clamp((squared_angle - resolved) / (unresolved - resolved), least, 1.0);
}

}  // namespace

double ContactLaw::force(double overlap) const {
  return stiffness > 0 ? stiffness * overlap : 4.0 / 3 * modulus * std::sqrt(radius * overlap) * overlap;
}

double ContactLaw::slope(double overlap) const { return stiffness > 0 ? stiffness : 2 * modulus * std::sqrt(radius * overlap); }

double ContactLaw::energy(double overlap) const { return (stiffness > 0 ? 0.5 : 0.4) * force(overlap) * overlap; }

ContactLaw contact_law(const MaterialPairs& pairs, const BodyProperties& a, const BodyProperties& b) {
  const auto of = [&](PairValue value) { return pairs.of(value, a.material, b.material); };
  return {of(PairValue::stiffness), of(PairValue::elastic_modulus), of(PairValue::damping), of(PairValue::damping_ratio),
          reduced_radius(a.shape, b.shape)};
}

SoftRow soft_row(const ContactLaw& law, double gap, double mobility, double step) {
  const double overlap = std::max(0.0, -gap), slope = law.slope(std::max(overlap, least_overlap * law.radius));
  const double stiff = step * step * slope;  // kg
  double against = implicit_share(stiff * mobility) * stiff;
  if (gap < 0) against += step * (law.damping + 2 * law.damping_ratio * std::sqrt(slope / mobility));
  const double force = gap < 0 ? law.force(overlap) : -slope * gap;
  return {1 / against, -step * force / against};
}

double contact_time(const ContactLaw& law, double mobility) {
  const double m = 1 / mobility;
  if (law.stiffness > 0) return M_PI * std::sqrt(m / law.stiffness);
  const double overlap = usual_overlap * law.radius;  // at which all of m v^2 / 2 is in the contact
  const double speed = std::sqrt(16.0 / 15 * law.modulus * std::sqrt(law.radius * overlap) * overlap * overlap / m);
  return 2.9432 * overlap / speed;
}

}  // namespace unibody
