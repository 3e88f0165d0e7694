// The mass of an entry's bodies, and how it lies in them.
#pragma once

#include "scene/body_entry.hpp"

namespace unibody {

// Keys of how the mass lies, of bodies with one shape.
const Keys& inertia_keys();

// Reads mass or density, and what the entry says of how the mass lies: the shape is then another one, with that. The motion is
// read before.
void read_amount(const KeyedMap& entry, BodyTemplate& body, const Scene& scene);

// Fails on `entry` where it gives no mass and the shape has none of its own, or a density beside those of the shape's parts.
void check_own_mass(const Value& entry, const BodyTemplate& body, const Shape& shape);

// Mass and inertia of this shape must be numbers > 0; fails on `entry` where they overflow or vanish.
void check_mass(const Value& entry, const BodyTemplate& body, const Shape& shape);

}  // namespace unibody
