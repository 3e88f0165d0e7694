#include "world/world_faults.hpp"

#include <cmath>

namespace unibody {

namespace {

constexpr double most_off_length = 1e-6;  // of an orientation

std::string fault_of_lengths(const World& w) {
  const std::size_t n = w.size(), turning = w.has_rotations ? n : 0;
  if (w.first_static() > n) return "more homes and guests than bodies";
  if (w.position.size() != n || w.velocity.size() != n) return "positions or velocities are not as many as bodies";
  if (w.orientation.size() != turning || w.angular_velocity.size() != turning) return "rotations are not as many as bodies";
  if (!w.has_rotations && w.held_orientation.size() != n - w.first_static())
    return "held orientations are not as many as statics";
  return "";
}

std::string fault_of_order(const World& w) {
  for (std::size_t i = 1; i < w.size(); ++i)
    if (i != w.homes && i != w.first_static() && w.id[i - 1] >= w.id[i])
      return "body " + std::to_string(w.id[i]) + " stands behind body " + std::to_string(w.id[i - 1]);
  return "";
}

}  // namespace

std::string fault_of(const World& world) {
  if (std::string fault = fault_of_lengths(world); !fault.empty()) return fault;
  if (std::string fault = fault_of_order(world); !fault.empty()) return fault;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const BodyState s = world.state(i);
    const std::string body = "body " + std::to_string(world.id[i]);
    if (!s.position.allFinite() || !s.velocity.allFinite() || !s.angular_velocity.allFinite())
      return "the state of " + body + " is not finite";
    if (!(std::abs(s.orientation.norm() - 1) <= most_off_length)) return "the orientation of " + body + " is not of length 1";
  }
  return "";
}

}  // namespace unibody
