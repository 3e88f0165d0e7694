// What the passes over contacts are made of: the rows of a block's points, a gradient step, and what it does to the bodies.
//
// Per block: gather the four pairs' velocities (two transposes a body), run over the points, scatter. Both bodies' arms reach the
// same point, so linear and angular momentum are kept to round-off whatever the multipliers are.
#pragma once

#include "constraints/contact_batch.hpp"
#include "constraints/friction.hpp"

namespace unibody::contact_rows {

using Block = ContactBatch::Block;
using Point = ContactBatch::Point;
using Normal = ContactBatch::Normal;
using Tangents = ContactBatch::Tangents;
using TangentImpulse = ContactBatch::TangentImpulse;
using Coupling = ContactBatch::Coupling;
using NormalMomentum = ContactBatch::NormalMomentum;
using TangentMomentum = ContactBatch::TangentMomentum;
using Inertia = ContactBatch::Inertia;
using Drift = ContactBatch::Drift;

// The velocities of one side's four bodies, with their inverse mass and isotropic inverse inertia.
struct Side {
  Vec3x4 v;
  Vec4d mass;
  Vec3x4 w;
  Vec4d inertia;
};

[[gnu::always_inline]] inline Side gather(const Slot (&slot)[lanes], std::span<const SolverBody> bodies) {
  const SolverBody *b0 = &bodies[slot[0]], *b1 = &bodies[slot[1]], *b2 = &bodies[slot[2]], *b3 = &bodies[slot[3]];
  const auto row = [](const double* from) { return Vec4d(*reinterpret_cast<const Vec4dView*>(from)); };
  Side s{{row(b0->v), row(b1->v), row(b2->v)}, row(b3->v), {row(b0->w), row(b1->w), row(b2->w)}, row(b3->w)};
  transpose(s.v.x, s.v.y, s.v.z, s.mass);
  transpose(s.w.x, s.w.y, s.w.z, s.inertia);
  return s;
}

[[gnu::always_inline]] inline void scatter(const Slot (&slot)[lanes], Side s, std::span<SolverBody> bodies) {
  transpose(s.v.x, s.v.y, s.v.z, s.mass);
  transpose(s.w.x, s.w.y, s.w.z, s.inertia);
  const Vec4d v[lanes] = {s.v.x, s.v.y, s.v.z, s.mass}, w[lanes] = {s.w.x, s.w.y, s.w.z, s.inertia};
  for (std::size_t l = 0; l < lanes; ++l) {
    *reinterpret_cast<Vec4dView*>(bodies[slot[l]].v) = v[l];
    *reinterpret_cast<Vec4dView*>(bodies[slot[l]].w) = w[l];
  }
}

// A side in which the tangents see no drift. All kernels that look at tangents start from this.
[[gnu::always_inline]] inline Side less_drift(Side a, const Drift* drift) {
  if (drift) a.v = a.v - drift->v, a.w = a.w - drift->w;
  return a;
}

// K = D^T W D of a point alone, 1/kg; without tangents nn alone.
struct Mobility {
  Vec4d nn, ss, tt, st, ns, nt;
  Vec4d tangential() const { return max(ss + abs(st), tt + abs(st)); }  // bounds that of both tangents
};

template <bool tangential>
[[gnu::always_inline]] inline Mobility mobility(const Block& block, const Vec3x4& t, const Point& p, const Side& a, const Side& b,
                                                const Inertia* inertia) {
  const auto turn_a = [&](const Vec3x4& torque) { return inertia ? multiply(inertia->a, torque) : torque * a.inertia; };
  const auto turn_b = [&](const Vec3x4& torque) { return inertia ? multiply(inertia->b, torque) : torque * b.inertia; };
  const Vec4d linear = a.mass + b.mass;
  const Vec3x4 an = cross(p.arm_a, block.n), bn = cross(p.arm_b, block.n);
  const Vec3x4 wan = turn_a(an), wbn = turn_b(bn);
  Mobility k{};
  k.nn = linear + dot(an, wan) + dot(bn, wbn);
  if constexpr (tangential) {
    const Vec3x4 as = cross(p.arm_a, block.s), bs = cross(p.arm_b, block.s);
    const Vec3x4 at = cross(p.arm_a, t), bt = cross(p.arm_b, t);
    const Vec3x4 wat = turn_a(at), wbt = turn_b(bt);
    k.ss = linear + dot(as, turn_a(as)) + dot(bs, turn_b(bs)), k.tt = linear + dot(at, wat) + dot(bt, wbt);
    k.st = dot(as, wat) + dot(bs, wbt);
    k.ns = dot(as, wan) + dot(bs, wbn), k.nt = dot(at, wan) + dot(bt, wbn);
  }
  return k;
}

struct PointVelocity {
  Vec4d n, s, t;
};

// Inlined by force, as the pieces below: called, they pass their vectors through memory.
template <bool tangential>
[[gnu::always_inline]] inline PointVelocity relative_velocity(const Block& block, const Vec3x4& t, const Point& p, const Side& a,
                                                              const Side& b) {
  const Vec3x4 u = (a.v + cross(a.w, p.arm_a)) - (b.v + cross(b.w, p.arm_b));
  if constexpr (tangential) return {dot(block.n, u), dot(block.s, u), dot(t, u)};
  return {dot(block.n, u), broadcast(0), broadcast(0)};
}

template <bool tangential>
[[gnu::always_inline]] inline Vec3x4 impulse_vector(const Block& block, const Vec3x4& t, Vec4d n, Vec4d s, Vec4d along_t) {
  if constexpr (tangential) return (block.n * n + block.s * s) + t * along_t;
  return block.n * n;
}

template <bool isotropic>
[[gnu::always_inline]] inline void push(Side& a, Side& b, const Point& p, const Inertia* inertia, const Vec3x4& f) {
  const Vec3x4 torque_a = cross(p.arm_a, f), torque_b = cross(p.arm_b, f);
  a.v = a.v + f * a.mass, b.v = b.v - f * b.mass;
  if constexpr (isotropic) {
    a.w = a.w + torque_a * a.inertia, b.w = b.w - torque_b * b.inertia;
  } else {
    a.w = a.w + multiply(inertia->a, torque_a), b.w = b.w - multiply(inertia->b, torque_b);
  }
}

// New multipliers of a point from trial ones: a gradient step of length 1/P, then the cone.
template <FrictionModel model, bool tangential>
[[gnu::always_inline]] inline ConeForce project_step(const Block& block, const Point& p, const Tangents* tangent,
                                                     const PointVelocity& u, ConeForce from,
                                                     [[maybe_unused]] Vec4d ratio = broadcast(1)) {
  if constexpr (!tangential) return {max(broadcast(0), from.n - p.inverse_scale * (u.n + p.bias)), broadcast(0), broadcast(0)};
  Vec4d r = u.n + p.bias;
  if constexpr (model == FrictionModel::saxce) r += block.friction * sqrt(u.s * u.s + u.t * u.t);
  return project<model>(
      {from.n - p.inverse_scale * r, from.s - tangent->inverse_scale * u.s, from.t - tangent->inverse_scale * u.t},
      block.friction, ratio);
}

template <FrictionModel model, bool tangential, bool isotropic>
Vec4d relax_block(const Block& block, const Point* points, Normal* normals, const Tangents* tangents,
                  TangentImpulse* tangent_impulses, const Coupling* couplings, const Inertia* inertia, const Drift* drift,
                  Vec4d ratio, bool backwards, std::span<SolverBody> bodies) {
  Side a = less_drift(gather(block.slot_a, bodies), drift), b = gather(block.slot_b, bodies);
  const Vec3x4 t = cross(block.n, block.s);
  Vec4d change = broadcast(0);
  for (std::uint32_t i = 0; i < block.count; ++i) {
    const std::uint32_t k = backwards ? block.count - 1 - i : i;
    const Point& p = points[k];
    Normal& normal = normals[k];
    const PointVelocity u = relative_velocity<tangential>(block, t, p, a, b);
    if constexpr (!tangential) {
      const ConeForce next = project_step<model, false>(block, p, nullptr, u, {normal.lambda, normal.lambda, normal.lambda});
      const Vec4d dn = next.n - normal.lambda;
      normal.lambda = next.n;
      change = max(change, abs(dn) * inverse_or_zero(p.inverse_scale));
      push<isotropic>(a, b, p, inertia, block.n * dn);
    } else {
      const Tangents& tangent = tangents[k];
      TangentImpulse& sideways = tangent_impulses[k];
      ConeForce next;
      if constexpr (uses_cone_projection(model)) {
        next = project_step<model, true>(block, p, &tangent, u, {normal.lambda, sideways.lambda_s, sideways.lambda_t}, ratio);
      } else {  // the normal first, then the tangents with the velocity that it leaves
        next.n = max(broadcast(0), normal.lambda - p.inverse_scale * (u.n + p.bias));
        const Vec4d dn = next.n - normal.lambda;
        next.s = sideways.lambda_s - tangent.inverse_scale * (u.s + couplings[k].K_ns * dn);
        next.t = sideways.lambda_t - tangent.inverse_scale * (u.t + couplings[k].K_nt * dn);
        next = project<model>(next, block.friction, ratio);
      }
      const Vec4d dn = next.n - normal.lambda, ds = next.s - sideways.lambda_s, dt = next.t - sideways.lambda_t;
      normal.lambda = next.n, sideways.lambda_s = next.s, sideways.lambda_t = next.t;
      const Vec4d sideways_change = max(abs(ds), abs(dt)) * inverse_or_zero(tangent.inverse_scale);
      change = max(change, max(abs(dn) * inverse_or_zero(p.inverse_scale), sideways_change));
      push<isotropic>(a, b, p, inertia, impulse_vector<true>(block, t, dn, ds, dt));
    }
  }
  if (drift) {  // what does not move keeps its velocity to the last bit, however often it is touched on this rank
    const Side found = gather(block.slot_a, bodies);
    const Mask4 moves = a.mass > broadcast(0);
    const auto restored = [&](const Vec3x4& x, const Vec3x4& old) {
      return Vec3x4{select(moves, x.x, old.x), select(moves, x.y, old.y), select(moves, x.z, old.z)};
    };
    a.v = restored(a.v + drift->v, found.v), a.w = restored(a.w + drift->w, found.w);
  }
  scatter(block.slot_a, a, bodies);
  scatter(block.slot_b, b, bodies);
  return change;
}

}  // namespace unibody::contact_rows
