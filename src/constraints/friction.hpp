// Coulomb's cone, five ways (paper, section 2.4 and Algorithm 2; what each gets wrong is said beside it). A sixth has no part in
// the solve: see solve/friction_postprocess.hpp.
//
// Where friction depends on the direction, the disc is an ellipse: of all forces that it allows, the one that takes most energy
// from what slides (Moreau's law of largest dissipation), which is not along the sliding velocity.
//
// Each model says how a contact's trial multipliers (normal n, tangents s and t) are brought back to what the cone allows.
// The trial tangents come in after their gradient step. Lanes are independent. Units cancel: forces or impulses alike.
#pragma once

#include "constraints/solver_settings.hpp"
#include "core/simd.hpp"

namespace unibody {

struct ConeForce {
  Vec4d n, s, t;
};

// |(s, t)| <= limit, shortened along its own direction.
inline void clamp_disc(Vec4d& s, Vec4d& t, Vec4d limit) {
  const Vec4d length2 = s * s + t * t;
  const Mask4 outside = length2 > limit * limit;
  if (!any(outside)) return;
  const Vec4d scale = select(outside, limit / sqrt(select(outside, length2, broadcast(1))), broadcast(1));
  s *= scale, t *= scale;
}

// Moves (s, t) to the nearest point of the ellipse that has the half axes `limit` along s and `across` times `limit` along t
// (0 < across <= 1). The line from the nearest point to (s, t) is square to the ellipse. With lengths in units of the limit the
// nearest point is therefore (s / (1 + x), across^2 t / (across^2 + x)), where x >= 0 is the root of a convex function. Newton's
// method approaches this root from below and never passes it.
inline void clamp_ellipse(Vec4d& s, Vec4d& t, Vec4d limit, Vec4d across) {
  const Vec4d one = broadcast(1), zero = broadcast(0), t_over = t / across;
  const Mask4 outside = s * s + t_over * t_over > limit * limit;
  if (!any(outside)) return;
  const Vec4d unit = select(outside & (limit > zero), limit, one), across2 = across * across;
  const Vec4d p = abs(s) / unit, q = across * abs(t) / unit;
  Vec4d x = max(zero, max(p - one, q - across2));
  constexpr int most = 60;  // most points need 5
  for (int k = 0; k < most; ++k) {
    const Vec4d along_s = p / (one + x), along_t = q / (across2 + x);
    const Vec4d value = along_s * along_s + along_t * along_t - one;
    const Mask4 goes_on = value > broadcast(1e-14);  // a lane that has come to rest stays: no lane depends on the others
    if (!any(goes_on)) break;
    const Vec4d slope = along_s * along_s / (one + x) + along_t * along_t / (across2 + x);
    x += select(goes_on, value / (slope + slope), zero);
  }
  const Vec4d to_s = s / (one + x), to_t = across2 * t / (across2 + x), to_t_over = to_t / across;
  const Vec4d length = sqrt(to_s * to_s + to_t_over * to_t_over), scale = limit / select(length > zero, length, one);
  s = select(outside, to_s * scale, s), t = select(outside, to_t * scale, t);
}

// |s| <= limit, |t| <= limit: the friction box of many real-time engines. sqrt 2 too strong along the bisector.
inline void clamp_box(Vec4d& s, Vec4d& t, Vec4d limit) {
  s = max(-limit, min(limit, s));
  t = max(-limit, min(limit, t));
}

// Nearest point of the cone |(s, t)| <= mu n to the UNCLAMPED triple (Tasora & Anitescu 2011). It converges, to the convexified
// problem: a sliding body floats by h mu |v_T|. With Saxce's shift of the normal residual the fixed point is Coulomb's.
inline ConeForce project_cone(ConeForce y, Vec4d mu) {
  const Vec4d tangential = sqrt(y.s * y.s + y.t * y.t);
  const Vec4d zero = broadcast(0);
  const Mask4 inside = (tangential <= mu * y.n) & (y.n >= zero);  // mu may be 0
  const Mask4 polar = mu * tangential <= -y.n;
  const Vec4d n = (y.n + mu * tangential) / (broadcast(1) + mu * mu);
  const Vec4d scale = mu * n / select(tangential > zero, tangential, broadcast(1));
  ConeForce p{select(polar, zero, n), select(polar, zero, y.s * scale), select(polar, zero, y.t * scale)};
  return {select(inside, y.n, p.n), select(inside, y.s, p.s), select(inside, y.t, p.t)};
}

// The model in a scene where friction depends on the direction somewhere (which the disc alone can say), or nowhere.
inline FrictionModel in_directions(FrictionModel model, bool differs) {
  return differs && model == FrictionModel::disc ? FrictionModel::ellipse : model;
}

// Whether contacts have rows of friction.
inline constexpr bool acts_in_solve(FrictionModel model) {
  return model != FrictionModel::none && model != FrictionModel::postprocess;
}

inline constexpr bool uses_cone_projection(FrictionModel model) {
  return model == FrictionModel::cone || model == FrictionModel::saxce;
}

// The trial normal multiplier is projected on its own and bounds the tangents ("disc": exact Coulomb at the fixed point), or
// the triple is projected together ("cone", "saxce"). across: of the coefficient along t over that along s, mu; 1 but for the
// ellipse.
template <FrictionModel model>
inline ConeForce project(ConeForce y, Vec4d mu, Vec4d across = broadcast(1)) {
  if constexpr (uses_cone_projection(model)) return project_cone(y, mu);
  y.n = max(broadcast(0), y.n);
  if constexpr (model == FrictionModel::disc) clamp_disc(y.s, y.t, mu * y.n);
  if constexpr (model == FrictionModel::ellipse) clamp_ellipse(y.s, y.t, mu * y.n, across);
  if constexpr (model == FrictionModel::box) clamp_box(y.s, y.t, mu * y.n);
  return y;
}

// Calls f with the friction model as a compile-time constant.
template <typename F>
auto with_model(FrictionModel model, F&& f) {
  switch (model) {
    case FrictionModel::cone:
      return f.template operator()<FrictionModel::cone>();
    case FrictionModel::saxce:
      return f.template operator()<FrictionModel::saxce>();
    case FrictionModel::ellipse:
      return f.template operator()<FrictionModel::ellipse>();
    case FrictionModel::box:
      return f.template operator()<FrictionModel::box>();
    case FrictionModel::none:
    case FrictionModel::postprocess:
      return f.template operator()<FrictionModel::none>();
    case FrictionModel::disc:
      break;
  }
  return f.template operator()<FrictionModel::disc>();
}

}  // namespace unibody
