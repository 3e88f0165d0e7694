// A mix is a set of shapes with their shares and sizes, from which the bodies of a pile or an inlet are drawn.
#pragma once

#include <vector>

#include "scene/body_entry.hpp"
#include "scene/random.hpp"
#include "scene/size_distribution.hpp"

namespace unibody {

Key mix_key();  // of a generator

class Mix {
 public:
  // Reads a list of maps {shape, share, scale}. It fails where a shape cannot move, or has no mass in one of its sizes.
  static Mix read(const Value& list, const BodyTemplate& body, const Scene& scene);

  Shape draw(BodyRandom& random) const;                      // takes two draws
  double largest_radius() const { return largest_radius_; }  // m, of the largest bounding sphere

 private:
  struct Ingredient {
    Shape shape;
    double share = 1;
    SizeDistribution sizes;

    Shape scaled(double factor) const { return {shape.kind, shape.size * factor, shape.data}; }
  };
  static Ingredient read_ingredient(const Value& value, const BodyTemplate& body, const Scene& scene);

  std::vector<Ingredient> ingredients_;
  double total_share_ = 0, largest_radius_ = 0;
};

}  // namespace unibody
