// How the sizes of many bodies are spread: factors on the size of one shape.
#pragma once

#include <vector>

#include "scene/key.hpp"

namespace unibody {

class SizeDistribution {
 public:
  // All have the size of the shape.
  SizeDistribution() = default;

  double smallest() const { return smallest_; }
  double largest() const { return largest_; }

  // The factor below which a share u of all bodies lies, 0 <= u < 1.
  double at(double u) const;

  // One of these, or a map of one of them that may also have `by: number` (the default) or `by: mass`, which says whether the
  // shares are those of the bodies' number or mass:
  //   [smallest, largest]                            as many in each equal range of the logarithm, by number
  //   {uniform: [smallest, largest]}                 as many, or as much mass, in each equal range
  //   {normal: {mean, deviation, smallest, largest}}           the normal distribution between these two
  //   {log_normal: {median, deviation, smallest, largest}}     that of the logarithm, whose deviation is in natural logarithms
  //   {table: [[factor, share], ...]}                these factors alone
  static Key key();  // of a kind of body
  static SizeDistribution read(const Value& value);

 private:
  enum class Kind : std::uint8_t { one, logarithmic, tabulated, stepped };

  // Fills the table of a law from its density: density(factor) is the share of bodies, or of mass, per unit of the factor of
  // size.
  template <class Density>
  void tabulate(bool by_mass, Density&& density);
  void read_range(const Value& value);
  void read_bell(const Value& value, bool logarithmic, bool by_mass);
  void read_table(const Value& value, bool by_mass);

  Kind kind_ = Kind::one;
  double smallest_ = 1, largest_ = 1;
  std::vector<double> factors_;   // ascending, of `stepped`
  std::vector<double> below_{0};  // share below the start of each cell of equal width, or of each factor; then 1
};

}  // namespace unibody
