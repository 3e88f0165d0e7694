// What two materials that touch have in common, beside friction, which may change in time. A new coefficient is a name and a line
// here: the scene file, its reference and what a checkpoint compares have it then.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace unibody {

enum class PairValue { restitution, rolling, spinning };

struct PairValueType {
  const char *key, *unit;  // in the scene file
  double most;             // a value is at least 0 and at most this
  bool by_mean;  // a pair that the scene does not list has the geometric mean of its materials' values; else the smaller
  bool in_contact_problem;   // a contact problem of FCLIB's form can say it
  const char *mark, *about;  // in the text by which a checkpoint knows its scene; in the reference
};

inline constexpr std::array<PairValueType, 3> pair_value_types{
    {{"restitution", "", 1, false, true, "bounce", "speed after an impact over that before it"},
     {"rolling_friction", "m", 1e308, true, false, "roll", "torque that resists rolling, over the normal force"},
     {"spinning_friction", "m", 1e308, true, false, "spin", "torque that resists spinning, over the normal force"}}};

struct MaterialPairs {
  using Values = std::vector<double>;  // materials x materials, row major, symmetric

  std::size_t materials = 1;
  std::array<Values, pair_value_types.size()> values;

  MaterialPairs() { values.fill({0}); }

  Values& operator[](PairValue value) { return values[static_cast<std::size_t>(value)]; }
  const Values& operator[](PairValue value) const { return values[static_cast<std::size_t>(value)]; }
  double of(PairValue value, int a, int b) const {
    return (*this)[value][static_cast<std::size_t>(a) * materials + static_cast<std::size_t>(b)];
  }
  // Whether any pair of materials has it.
  bool any(PairValue value) const {
    return std::ranges::any_of((*this)[value], [](double x) { return x > 0; });
  }

  static double mixed(const PairValueType& type, double a, double b) { return type.by_mean ? std::sqrt(a * b) : std::min(a, b); }
};

}  // namespace unibody
