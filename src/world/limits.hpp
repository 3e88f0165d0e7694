// What no scene starts with and no run comes to.
#pragma once

namespace unibody {

inline constexpr double farthest = 1e15;          // m, a coordinate
inline constexpr double fastest = 299'792'458.0;  // m/s, the speed of light
inline constexpr double least_size = 1e-15;       // m, of a body
inline constexpr double largest_size = 1e15;      // m, of a body

}  // namespace unibody
