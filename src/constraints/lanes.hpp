// Vectors of one lane of four.
#pragma once

#include <cstddef>

#include "core/simd.hpp"
#include "core/types.hpp"

namespace unibody {

inline Vec3 lane_of(const Vec3x4& v, std::size_t lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }
inline void set_lane(Vec3x4& v, std::size_t lane, const Vec3& x) { v.x[lane] = x.x(), v.y[lane] = x.y(), v.z[lane] = x.z(); }

}  // namespace unibody
