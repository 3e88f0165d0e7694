// For each body: the number of other bodies that push it, and the stress that the forces of its contacts make in it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "scene/scene.hpp"
#include "step/contact_impulse.hpp"

namespace unibody {

// The symmetric part of a force, or an impulse, times a way: xx, yy, zz, yz, xz, xy.
std::array<double, 6> symmetric_product(const Vec3& force, const Vec3& way);

struct LoadedBody {
  Id id = 0;
  std::int32_t coordination = 0;   // other bodies, nodes left out, that push it
  std::array<double, 6> stress{};  // Pa: xx, yy, zz, yz, xz, xy; positive in compression
};

// Lists the dynamic bodies that a contact pushes, in ascending order of their ids. Nodes of cloths, threads and solids are left
// out. step: the length (s) of the step in which the impulses acted.
std::vector<LoadedBody> loaded_bodies(std::span<const ContactImpulse> contacts, const Scene& scene, double step);

}  // namespace unibody
