#include "scene/anisotropic_friction.hpp"

namespace unibody {

namespace {

// Beyond these ratios the iterations of a contact that slides across its weak direction no longer come to an end.
constexpr Range ratios{0.01, 100};

const Keys& anisotropic_friction_keys() {
  static const Keys table{
      "anisotropic_friction",
      "Friction that is the materials' own along an axis of the body, and another across it.",
      {keys::direction("axis", needed, "the axis, in the body's axes"),
       keys::number("across", "", ratios, needed, "coefficient of friction across the axis, over that along it")}};
  return table;
}

}  // namespace

Key anisotropic_friction_key() {
  return keys::map("anisotropic_friction", anisotropic_friction_keys, "a map with axis and across", "none",
                   "friction that differs along an axis of the body and across it");
}

std::optional<AnisotropicFriction> read_anisotropic_friction(const KeyedMap& entry, const Scene& scene) {
  const Value* value = entry.find("anisotropic_friction");
  if (value == nullptr) return std::nullopt;
  const KeyedMap map(*value, anisotropic_friction_keys());
  const AnisotropicFriction friction{map.direction("axis"), map.number("across")};
  const FrictionModel model = scene.solver.friction;
  if (model != FrictionModel::disc && model != FrictionModel::none)
    value->fail("a map beside solver.friction: " + std::string(friction_model_names[static_cast<std::size_t>(model)]),
                "solver.friction: disc, which alone knows friction that depends on the direction");
  return friction;
}

}  // namespace unibody
