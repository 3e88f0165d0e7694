// Coefficients of friction that change in time.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/time_value.hpp"

namespace unibody {

struct FrictionInTime {
  std::vector<TimeValue> materials;             // of each material with itself
  std::vector<std::optional<TimeValue>> pairs;  // materials x materials, symmetric: those that the scene lists

  // Constant coefficients, materials x materials, of which each pair has its own.
  static FrictionInTime of(const std::vector<double>& coefficients, std::size_t material_count) {
    FrictionInTime friction;
    for (std::size_t i = 0; i < material_count; ++i) friction.materials.emplace_back(coefficients[i * material_count + i]);
    for (const double mu : coefficients) friction.pairs.emplace_back(mu);
    return friction;
  }

  // From now on a and b have another law.
  void set(int a, int b, const TimeValue& law) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b), n = materials.size();
    if (i == j) materials[i] = law;
    pairs[i * n + j] = pairs[j * n + i] = law;
  }

  bool changes() const {
    for (const TimeValue& own : materials)
      if (own.changes()) return true;
    for (const auto& pair : pairs)
      if (pair && pair->changes()) return true;
    return false;
  }

  // Coulomb's mu of each pair, materials x materials, by the number that mu(law) makes of a law in time; of pairs that are not
  // listed the geometric mean of their materials'.
  template <class F>
  std::vector<double> coefficients(F&& mu) const {
    const std::size_t n = materials.size();
    std::vector<double> all;
    for (std::size_t i = 0; i < n * n; ++i) {
      const std::size_t a = i / n, b = i % n;
      all.push_back(a == b ? mu(materials[a]) : pairs[i] ? mu(*pairs[i]) : std::sqrt(mu(materials[a]) * mu(materials[b])));
    }
    return all;
  }
  std::vector<double> at(double time) const {
    return coefficients([&](const TimeValue& law) { return law.at(time); });
  }
  std::vector<double> mean(double from, double to) const {  // over a step
    return coefficients([&](const TimeValue& law) { return law.mean(from, to); });
  }

  std::string text() const {  // equal for equal laws, and for no others
    std::string all;
    for (const TimeValue& own : materials) all += own.text() + ' ';
    for (const auto& pair : pairs) all += (pair ? pair->text() : "-") + ' ';
    return all;
  }
};

}  // namespace unibody
