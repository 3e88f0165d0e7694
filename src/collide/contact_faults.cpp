#include "collide/contact_faults.hpp"

#include <cmath>

namespace unibody {

namespace {

bool holds(const World& world, Slot slot, Id id) {
  return slot >= 0 && static_cast<std::size_t>(slot) < world.size() && world.id[static_cast<std::size_t>(slot)] == id;
}

bool is_unit(const Vec3& normal) { return std::abs(normal.norm() - 1) <= 1e-6; }

std::string fault_of(const Manifold& m, const Contacts& contacts, const World& world) {
  if (m.id_a >= m.id_b) return "its bodies are not in order";
  if (!holds(world, m.slot_a, m.id_a) || !holds(world, m.slot_b, m.id_b)) return "a slot holds another body";
  if (m.count < 1 || m.first + m.count > contacts.points.size()) return "its points are not in the list";
  if (!is_unit(m.normal)) return "its normal is not of length 1";
  for (std::uint32_t k = m.first; k < m.first + m.count; ++k)
    if (!std::isfinite(contacts.points[k].gap) || !contacts.points[k].position.allFinite()) return "a point is not finite";
  return "";
}

std::string fault_of(const SurfaceContact& c, const World& world) {
  for (std::size_t e = 0; e < 4; ++e)
    if (c.ids[e] >= 0 && !holds(world, c.slots[e], c.ids[e])) return "a slot holds another body";
  if (!is_unit(c.normal)) return "its normal is not of length 1";
  return std::isfinite(c.gap) && c.arm.allFinite() ? "" : "it is not finite";
}

}  // namespace

std::string fault_of(const Contacts& contacts, const World& world) {
  if (!contacts.bounce.empty() && contacts.bounce.size() != contacts.points.size()) return "bounces are not as many as points";
  const Manifold* before = nullptr;
  for (const Manifold& m : contacts.manifolds) {
    const std::string name = "the contact of bodies " + std::to_string(m.id_a) + " and " + std::to_string(m.id_b) + ": ";
    if (before && std::pair(m.id_a, m.id_b) < std::pair(before->id_a, before->id_b)) return name + "it is not in order";
    if (const std::string fault = fault_of(m, contacts, world); !fault.empty()) return name + fault;
    before = &m;
  }
  const SurfaceContact* last = nullptr;
  for (const SurfaceContact& c : contacts.surface) {
    const std::string name = "the contact of a surface with body " + std::to_string(c.ids[0]) + ": ";
    if (last && !last->before(c)) return name + "it is not in order";
    if (const std::string fault = fault_of(c, world); !fault.empty()) return name + fault;
    last = &c;
  }
  return "";
}

}  // namespace unibody
