// What two materials that touch have in common, beside friction, which may change in time. A new coefficient is a name and a line
// here: the scene file, its reference and what a checkpoint compares have it then.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace unibody {

enum class PairValue {
  restitution,
  rolling,
  spinning,
  stiction,
  stiction_speed,
  adhesion,
  surface_energy,
  adhesion_range,
  liquid_volume,
  surface_tension,
  contact_angle,
  stiffness,
  elastic_modulus,
  damping,
  damping_ratio
};

struct PairValueType {
  const char *key, *unit;  // in the scene file
  double usual, most;      // without the key; a value is at least 0, or above it where it usually is, and at most this
  bool by_mean;  // a pair that the scene does not list has the geometric mean of its materials' values; else the smaller
  bool in_contact_problem;   // a contact problem of FCLIB's form can say it
  const char *mark, *about;  // in the text by which a checkpoint knows its scene; in the reference
};

inline constexpr std::array<PairValueType, 15> pair_value_types{
    {{"restitution", "", 0, 1, false, true, "bounce", "speed after an impact over that before it"},
     {"rolling_friction", "m", 0, 1e308, true, false, "roll", "torque that resists rolling, over the normal force"},
     {"spinning_friction", "m", 0, 1e308, true, false, "spin", "torque that resists spinning, over the normal force"},
     {"stiction", "", 0, 1e308, true, true, "stick", "how much more friction there is at rest, over that in motion"},
     {"stiction_speed", "m/s", 0.001, 1e308, true, true, "stick below", "sliding speed at which that is down to 1/e"},
     {"adhesion", "N", 0, 1e308, true, true, "adhere", "force that pulls two bodies apart"},
     {"surface_energy", "J/m^2", 0, 1e308, true, true, "adhere by", "work of adhesion, where one of two bodies is round"},
     {"adhesion_range", "m", 0, 1e308, true, true, "adhere within",
      "gap up to which that acts; 0: 0.01 of the smaller body's size"},
     {"liquid_volume", "m^3", 0, 1e308, true, true, "wet", "volume of the bridge of liquid between bodies that have touched"},
     {"surface_tension", "N/m", 0.072, 1e308, true, true, "wet by", "surface tension of that liquid"},
     {"contact_angle", "degrees", 0, 90, true, true, "wet at", "angle at which that liquid meets the bodies"},
     {"stiffness", "N/m", 0, 1e308, true, false, "give way", "force over overlap of a point of contact; 0: rigid"},
     {"elastic_modulus", "Pa", 0, 1e308, true, false, "give way by",
      "E* of Hertz' contact, where one of two bodies is round; 0: rigid"},
     {"damping", "N s/m", 0, 1e308, true, false, "damped by", "force over speed of a point of contact that gives way"},
     {"damping_ratio", "", 0, 1e308, true, false, "damped", "of such a contact, 1 where it is critical"}}};

struct MaterialPairs {
  using Values = std::vector<double>;  // materials x materials, row major, symmetric

  std::size_t materials = 1;
  std::array<Values, pair_value_types.size()> values;

  MaterialPairs() {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = {pair_value_types[k].usual};
  }

  Values& operator[](PairValue value) { return values[static_cast<std::size_t>(value)]; }
  const Values& operator[](PairValue value) const { return values[static_cast<std::size_t>(value)]; }
  double of(PairValue value, int a, int b) const {
    return (*this)[value][static_cast<std::size_t>(a) * materials + static_cast<std::size_t>(b)];
  }
  // Whether any pair of materials has another than the usual one.
  bool any(PairValue value) const {
    const double usual = pair_value_types[static_cast<std::size_t>(value)].usual;
    return std::ranges::any_of((*this)[value], [&](double x) { return x != usual; });
  }

  static double mixed(const PairValueType& type, double a, double b) { return type.by_mean ? std::sqrt(a * b) : std::min(a, b); }
};

}  // namespace unibody
