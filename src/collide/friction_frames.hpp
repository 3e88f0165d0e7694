// Anisotropic friction: what the axes of two bodies make of their contact.
#pragma once

#include "collide/contacts.hpp"

namespace unibody {

// The frame of a contact with this unit normal between two bodies, and by what it multiplies the pair's coefficient of friction,
// which is then the one along the frame's s. slot_b: -1 where the other side is a cloth, a thread or a solid, which has no axis.
//
// Along a direction e across the normal the logarithm of a body's factor is log(across) (1 - (p.e)^2), with p its axis less what
// it has along the normal: its friction is that along the axis where e is, and the one across it at right angles, also where the
// axis sticks out of the face. The factors of two bodies multiply.
struct FactoredFrame {
  FrictionFrame frame;
  double factor = 1;
};
FactoredFrame friction_frame(const World& world, Slot slot_a, Slot slot_b, const Vec3& normal);

// Gives all contacts their frames, and multiplies their coefficients of friction. Where the world has axes.
void add_friction_frames(const World& world, Contacts& contacts);

}  // namespace unibody
