// What contacts do to each body: with how many others it shares them, and the stress in it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "scene/scene.hpp"
#include "step/contact_impulse.hpp"

namespace unibody {

struct LoadedBody {
  Id id = 0;
  std::int32_t coordination = 0;   // other bodies, nodes left out, that push it
  std::array<double, 6> stress{};  // Pa: xx, yy, zz, yz, xz, xy; positive in compression
};

// Of all dynamic bodies, nodes left out, that a contact pushes, in ascending order. step: s, in which the impulses acted.
std::vector<LoadedBody> loaded_bodies(std::span<const ContactImpulse> contacts, const Scene& scene, double step);

}  // namespace unibody
