// Four doubles side by side. The compiler lowers this to whatever the processor has (AVX: one register, SSE: two); every
// lane is plain IEEE arithmetic without contraction, so neither the width nor the place in a batch can change a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace unibody {

inline constexpr std::size_t lanes = 4;
using Vec4d = double __attribute__((vector_size(lanes * sizeof(double))));
using Vec4dView = double __attribute__((vector_size(lanes * sizeof(double)), may_alias));  // to read plain doubles by fours
using Mask4 = long long __attribute__((vector_size(lanes * sizeof(double))));

inline Vec4d broadcast(double x) { return Vec4d{x, x, x, x}; }
inline Vec4d select(Mask4 condition, Vec4d yes, Vec4d no) { return condition ? yes : no; }
#ifdef __AVX__  // one instruction each, of the same meaning to the last bit
inline Vec4d max(Vec4d a, Vec4d b) { return __builtin_ia32_maxpd256(a, b); }
inline Vec4d min(Vec4d a, Vec4d b) { return __builtin_ia32_minpd256(a, b); }
inline bool any(Mask4 m) { return __builtin_ia32_movmskpd256(reinterpret_cast<Vec4d>(m)) != 0; }
#else
inline Vec4d max(Vec4d a, Vec4d b) { return select(a > b, a, b); }
inline Vec4d min(Vec4d a, Vec4d b) { return select(a < b, a, b); }
inline bool any(Mask4 m) { return (m[0] | m[1] | m[2] | m[3]) != 0; }
#endif

inline constexpr unsigned all_lanes = (1u << lanes) - 1;  // a bit a lane

// All bits of the lanes whose bit is set.
inline Mask4 lanes_of(unsigned bits) { return (Mask4{1, 2, 4, 8} & static_cast<long long>(bits)) != 0; }
inline Vec4d abs(Vec4d a) {
  constexpr long long all_but_sign = 0x7fffffffffffffff;
  return reinterpret_cast<Vec4d>(reinterpret_cast<Mask4>(a) & Mask4{all_but_sign, all_but_sign, all_but_sign, all_but_sign});
}
inline Vec4d sqrt(Vec4d a) {  // correctly rounded either way
#ifdef __AVX__
  return __builtin_ia32_sqrtpd256(a);
#else
  return Vec4d{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
#endif
}
inline Vec4d inverse_or_zero(Vec4d a) {  // 0 of what is not positive
  const Mask4 proper = a > broadcast(0);
  return select(proper, broadcast(1) / select(proper, a, broadcast(1)), broadcast(0));
}
inline double horizontal_max(Vec4d a) { return std::max(std::max(a[0], a[1]), std::max(a[2], a[3])); }

// Four 3-vectors, one a lane.
struct Vec3x4 {
  Vec4d x, y, z;
};
inline Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3x4 operator*(const Vec3x4& a, Vec4d s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec4d dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3x4 cross(const Vec3x4& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Four symmetric matrices, their entries xx, yy, zz, yz, xz, xy, times four vectors.
inline Vec3x4 multiply(const Vec4d (&m)[6], const Vec3x4& v) {
  return {m[0] * v.x + m[5] * v.y + m[4] * v.z, m[5] * v.x + m[1] * v.y + m[3] * v.z, m[4] * v.x + m[3] * v.y + m[2] * v.z};
}

// Turns four rows of four into four columns: from a record a lane to a field a vector, and back.
inline void transpose(Vec4d& a, Vec4d& b, Vec4d& c, Vec4d& d) {
  const Vec4d ab_low = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_high = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Vec4d cd_low = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_high = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5), c = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  b = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5), d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

}  // namespace unibody
