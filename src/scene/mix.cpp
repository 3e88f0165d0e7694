#include "scene/mix.hpp"

#include <algorithm>

namespace unibody {

Mix::Ingredient Mix::read_ingredient(const Value& value, const BodyTemplate& body, const Scene& scene) {
  value.map({"shape", "share", "scale"});
  Ingredient ingredient;
  const Value& shape = value.need("shape", "a map with a shape as its key");
  ingredient.shape = read_shape(shape, scene);
  const ShapeKind kind = ingredient.shape.kind;
  if (kind == ShapeKind::plane || kind == ShapeKind::mesh)
    shape.fail("a " + shape.children[0].first + " in a mix", "a shape that can move");
  if (const Value* share = value.find("share")) ingredient.share = share->number(positive, "");
  if (const Value* scale = value.find("scale")) {
    ingredient.sizes = SizeDistribution::read(*scale);
    if (kind == ShapeKind::compound) scale->fail_expected("no scale for a compound");
  }
  for (const double factor : {ingredient.sizes.smallest(), ingredient.sizes.largest()})
    check_mass(value, body, ingredient.scaled(factor));
  return ingredient;
}

Mix Mix::read(const Value& list, const BodyTemplate& body, const Scene& scene) {
  Mix mix;
  for (const Value& entry : list.list("shapes with share and scale")) {
    mix.ingredients_.push_back(read_ingredient(entry, body, scene));
    const Ingredient& last = mix.ingredients_.back();
    mix.total_share_ += last.share;
    mix.largest_radius_ = std::max(mix.largest_radius_, bounding_radius(last.scaled(last.sizes.largest())));
  }
  return mix;
}

Shape Mix::draw(BodyRandom& random) const {
  double rest = random.next() * total_share_;
  std::size_t i = 0;
  while (i + 1 < ingredients_.size() && rest >= ingredients_[i].share) rest -= ingredients_[i++].share;
  return ingredients_[i].scaled(ingredients_[i].sizes.at(random.next()));
}

}  // namespace unibody
