#include "scene/mix.hpp"

#include <algorithm>

#include "scene/body_mass.hpp"
#include "world/compound.hpp"

namespace unibody {

namespace {

const Keys& ingredient_keys() {
  static const Keys table{
      "mix",
      "A kind of body of a mix.",
      {shape_key(needed), keys::number("share", "", positive, 1, "relative number of this kind"), SizeDistribution::key()}};
  return table;
}

}  // namespace

Key mix_key() {
  return keys::list_of_maps("mix", ingredient_keys, "a list of shapes with share and scale", needed, "the kinds of body");
}

Mix::Ingredient Mix::read_ingredient(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, ingredient_keys());
  Ingredient ingredient;
  const Value& shape = map.need("shape");
  ingredient.shape = read_shape(shape, scene);
  const ShapeKind kind = ingredient.shape.kind;
  if (kind == ShapeKind::plane || kind == ShapeKind::mesh)
    shape.fail("a " + shape.children[0].first + " in a mix", "a shape that can move");
  if (own_mass(ingredient.shape) > 0) shape.fail("densities of parts in a mix", "the density or mass of the entry alone");
  ingredient.share = map.number("share");
  if (const Value* scale = map.find("scale")) {
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
