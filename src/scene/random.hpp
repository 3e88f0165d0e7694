// Random numbers as pure functions of a place in a sequence: any rank can draw the numbers of any body.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/types.hpp"

namespace unibody {

// The 64-bit linear congruential generator s -> a s + c of the reference scenes.
struct Lcg {
  static constexpr std::uint64_t a = 6364136223846793005u, c = 1442695040888963407u;
  std::uint64_t state = 1;

  // Uniform in [-1, 1).
  double next() {
    state = state * a + c;
    return static_cast<double>(state >> 11) * 0x1p-53 * 2 - 1;
  }

  // Does what n calls of next() do, in O(log n): n steps are one step s -> a_n s + c_n, found by repeated squaring.
  void jump(std::uint64_t n) {
    std::uint64_t a_power = a, c_power = c;  // of 2^i steps
    for (; n != 0; n >>= 1) {
      if (n & 1) state = a_power * state + c_power;
      c_power += a_power * c_power;
      a_power *= a_power;
    }
  }
};

// splitmix64's finaliser: every bit of the result depends on every bit of x.
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Draws of body `number`, uniform in [0, 1).
class BodyRandom {
 public:
  BodyRandom(std::uint64_t seed, Id number) : state_(mixed(mixed(seed) ^ static_cast<std::uint64_t>(number))) {}
  double next() { return static_cast<double>((state_ = mixed(state_)) >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + next() * (high - low); }

 private:
  std::uint64_t state_;
};

// Every orientation equally likely (K. Shoemake, Uniform random rotations, 1992).
inline Quat random_orientation(BodyRandom& random) {
  const double u = random.next(), alpha = 2 * M_PI * random.next(), beta = 2 * M_PI * random.next();
  const double r = std::sqrt(1 - u), s = std::sqrt(u);
  return Quat(s * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha), s * std::sin(beta)).normalized();
}

}  // namespace unibody
