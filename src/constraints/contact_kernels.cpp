// The inner loops over contacts. Everything that is hot in a rigid scene is in this file.
//
// Per block: gather the four pairs' velocities (two transposes a body), run over the points, scatter. Both bodies' arms reach the
// same point, so linear and angular momentum are kept to round-off whatever the multipliers are.

#include "constraints/contact_batch.hpp"
#include "constraints/friction.hpp"

namespace unibody {

namespace {

using Block = ContactBatch::Block;
using Point = ContactBatch::Point;
using Normal = ContactBatch::Normal;
using Tangents = ContactBatch::Tangents;
using TangentImpulse = ContactBatch::TangentImpulse;
using Coupling = ContactBatch::Coupling;
using NormalMomentum = ContactBatch::NormalMomentum;
using TangentMomentum = ContactBatch::TangentMomentum;
using Inertia = ContactBatch::Inertia;

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

constexpr std::size_t ahead = 4;  // blocks: bodies come from all over the memory, and this long

// Asks for what belongs to the bodies of the block that comes some blocks after block i.
template <class Record>
[[gnu::always_inline]] inline void ask_for(std::span<const Block> blocks, std::size_t i, std::span<Record> of_bodies) {
  const Block& block = blocks[std::min(i + ahead, blocks.size() - 1)];
  for (std::size_t l = 0; l < lanes; ++l) {
    __builtin_prefetch(&of_bodies[block.slot_a[l]], !std::is_const_v<Record>);
    __builtin_prefetch(&of_bodies[block.slot_b[l]], !std::is_const_v<Record>);
  }
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

Vec3x4 multiply(const Vec4d (&m)[6], const Vec3x4& v) {
  return {m[0] * v.x + m[5] * v.y + m[4] * v.z, m[5] * v.x + m[1] * v.y + m[3] * v.z, m[4] * v.x + m[3] * v.y + m[2] * v.z};
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
[[gnu::always_inline]] inline ConeForce project_step(const Block& block, const Point& p, Vec4d bias, const Tangents* tangent,
                                                     const PointVelocity& u, ConeForce from) {
  if constexpr (!tangential) return {max(broadcast(0), from.n - p.inverse_scale * (u.n + bias)), broadcast(0), broadcast(0)};
  Vec4d r = u.n + bias;
  if constexpr (model == FrictionModel::saxce) r += block.friction * sqrt(u.s * u.s + u.t * u.t);
  return project<model>(
      {from.n - p.inverse_scale * r, from.s - tangent->inverse_scale * u.s, from.t - tangent->inverse_scale * u.t},
      block.friction);
}

// The natural residual's own step, 1/K of the point alone, so that it does not depend on the solver's scaling.
template <FrictionModel model, bool tangential>
Vec4d point_residual(const Block& block, const Point& p, const Normal& normal, const Tangents* tangent,
                     const TangentImpulse* sideways, const PointVelocity& u) {
  Point own = p;
  own.inverse_scale = select(p.mobility > broadcast(0), broadcast(1) / p.mobility, broadcast(0));
  const Vec4d lambda = normal.lambda;
  if constexpr (!tangential) {
    const ConeForce next = project_step<model, false>(block, own, normal.bias, nullptr, u, {lambda, lambda, lambda});
    return p.mobility * abs(next.n - lambda);
  } else {
    Tangents own_tangent = *tangent;
    const Vec4d scale = uses_cone_projection(model) ? max(p.mobility, tangent->mobility) : tangent->mobility;
    own_tangent.inverse_scale = select(scale > broadcast(0), broadcast(1) / scale, broadcast(0));
    if (uses_cone_projection(model)) own.inverse_scale = own_tangent.inverse_scale;
    const ConeForce next =
        project_step<model, true>(block, own, normal.bias, &own_tangent, u, {lambda, sideways->lambda_s, sideways->lambda_t});
    const Vec4d ds = next.s - sideways->lambda_s, dt = next.t - sideways->lambda_t;
    return max(p.mobility * abs(next.n - lambda), scale * sqrt(ds * ds + dt * dt));
  }
}

template <FrictionModel model, bool tangential, bool isotropic>
Vec4d relax_block(const Block& block, const Point* points, Normal* normals, const Tangents* tangents,
                  TangentImpulse* tangent_impulses, const Coupling* couplings, const Inertia* inertia, bool backwards,
                  std::span<SolverBody> bodies) {
  Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
  const Vec3x4 t = cross(block.n, block.s);
  Vec4d change = broadcast(0);
  for (std::uint32_t i = 0; i < block.count; ++i) {
    const std::uint32_t k = backwards ? block.count - 1 - i : i;
    const Point& p = points[k];
    Normal& normal = normals[k];
    const PointVelocity u = relative_velocity<tangential>(block, t, p, a, b);
    if constexpr (!tangential) {
      const ConeForce next =
          project_step<model, false>(block, p, normal.bias, nullptr, u, {normal.lambda, normal.lambda, normal.lambda});
      const Vec4d dn = next.n - normal.lambda;
      normal.lambda = next.n;
      change = max(change, p.mobility * abs(dn));
      push<isotropic>(a, b, p, inertia, block.n * dn);
    } else {
      const Tangents& tangent = tangents[k];
      TangentImpulse& sideways = tangent_impulses[k];
      ConeForce next;
      if constexpr (uses_cone_projection(model)) {
        next =
            project_step<model, true>(block, p, normal.bias, &tangent, u, {normal.lambda, sideways.lambda_s, sideways.lambda_t});
      } else {  // the normal first, then the tangents with the velocity that it leaves
        next.n = max(broadcast(0), normal.lambda - p.inverse_scale * (u.n + normal.bias));
        const Vec4d dn = next.n - normal.lambda;
        next.s = sideways.lambda_s - tangent.inverse_scale * (u.s + couplings[k].K_ns * dn);
        next.t = sideways.lambda_t - tangent.inverse_scale * (u.t + couplings[k].K_nt * dn);
        next = project<model>(next, block.friction);
      }
      const Vec4d dn = next.n - normal.lambda, ds = next.s - sideways.lambda_s, dt = next.t - sideways.lambda_t;
      normal.lambda = next.n, sideways.lambda_s = next.s, sideways.lambda_t = next.t;
      change = max(change, max(p.mobility * abs(dn), tangent.mobility * max(abs(ds), abs(dt))));
      push<isotropic>(a, b, p, inertia, impulse_vector<true>(block, t, dn, ds, dt));
    }
  }
  scatter(block.slot_a, a, bodies);
  scatter(block.slot_b, b, bodies);
  return change;
}

// Adds the four lanes' impulses to the wrenches, lane after lane: for each body in ascending key order.
[[gnu::always_inline]] inline void add_wrenches(const Block& block, Vec3x4 force, Vec3x4 torque_a, Vec3x4 torque_b,
                                                std::span<Wrench> wrenches) {
  Vec4d none_f{}, none_a{}, none_b{};
  transpose(force.x, force.y, force.z, none_f);
  transpose(torque_a.x, torque_a.y, torque_a.z, none_a);
  transpose(torque_b.x, torque_b.y, torque_b.z, none_b);
  const Vec4d f[lanes] = {force.x, force.y, force.z, none_f};
  const Vec4d ta[lanes] = {torque_a.x, torque_a.y, torque_a.z, none_a}, tb[lanes] = {torque_b.x, torque_b.y, torque_b.z, none_b};
  for (std::size_t l = 0; l < lanes; ++l) {
    Wrench &a = wrenches[block.slot_a[l]], &b = wrenches[block.slot_b[l]];
    a.force += f[l], a.torque += ta[l];
    b.force -= f[l], b.torque -= tb[l];
  }
}

struct SweepTerms {
  Vec4d gradient = broadcast(0), progress = broadcast(0), change = broadcast(0);
};

template <FrictionModel model, bool tangential>
SweepTerms sweep_block(const Block& block, const Point* points, Normal* normals, NormalMomentum* normal_momenta,
                       const Tangents* tangents, TangentImpulse* tangent_impulses, TangentMomentum* tangent_momenta, double beta,
                       std::span<const SolverBody> bodies, std::span<Wrench> wrenches) {
  const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
  const Vec3x4 t = cross(block.n, block.s);
  const Vec4d zero = broadcast(0), momentum = broadcast(beta);
  Vec3x4 force{zero, zero, zero}, torque_a = force, torque_b = force;
  SweepTerms sums;
  for (std::uint32_t k = 0; k < block.count; ++k) {
    const Point& p = points[k];
    Normal& normal = normals[k];
    NormalMomentum& along = normal_momenta[k];
    const Tangents* tangent = tangential ? tangents + k : nullptr;
    TangentMomentum* sideways = tangential ? tangent_momenta + k : nullptr;
    const PointVelocity u = relative_velocity<tangential>(block, t, p, a, b);
    ConeForce from{along.y, zero, zero};
    if constexpr (tangential) from.s = sideways->y_s, from.t = sideways->y_t;
    const ConeForce next = project_step<model, tangential>(block, p, normal.bias, tangent, u, from);

    const auto advance = [&](Vec4d& lambda, Vec4d& y, Vec4d new_lambda, Vec4d r, Vec4d scale) {
      const Vec4d step = new_lambda - y, forward = new_lambda - lambda, scaled = scale * step;
      const Vec4d new_y = new_lambda + momentum * forward;
      sums.gradient += r * forward;
      sums.progress += scaled * step;
      sums.change = max(sums.change, abs(scaled));
      lambda = new_lambda;
      const Vec4d dy = new_y - y;
      y = new_y;
      return dy;
    };
    const Vec4d dn = advance(normal.lambda, along.y, next.n, u.n + normal.bias, along.scale);
    Vec4d ds = zero, dt = zero;
    if constexpr (tangential) {
      ds = advance(tangent_impulses[k].lambda_s, sideways->y_s, next.s, u.s, sideways->scale);
      dt = advance(tangent_impulses[k].lambda_t, sideways->y_t, next.t, u.t, sideways->scale);
    }
    const Vec3x4 f = impulse_vector<tangential>(block, t, dn, ds, dt);
    force = force + f, torque_a = torque_a + cross(p.arm_a, f), torque_b = torque_b + cross(p.arm_b, f);
  }
  add_wrenches(block, force, torque_a, torque_b, wrenches);
  return sums;
}

}  // namespace

double ContactBatch::relax(std::size_t group, bool backwards, std::span<SolverBody> bodies) {
  const std::uint32_t begin = group == 0 ? 0 : group_end_[group - 1], end = group_end_[group];
  return with_model(friction_, [&]<FrictionModel model>() {
    Vec4d change = broadcast(0);
    for (std::uint32_t i = begin; i < end; ++i) {
      const Block& block = blocks[i];
      ask_for<SolverBody>(blocks, i, bodies);
      const std::int32_t t = block.first_tangent;
      const Tangents* tangent = t < 0 ? nullptr : &tangents[t];
      TangentImpulse* sideways = t < 0 ? nullptr : &tangent_impulses[t];
      const Coupling* coupling = t < 0 ? nullptr : &couplings[t];
      const Inertia* inertia = block.inertia < 0 ? nullptr : &inertias[block.inertia];
      const auto relax_as = [&]<bool tangential, bool isotropic>() {
        return relax_block<model, tangential, isotropic>(block, &points[block.first_point], &normals[block.first_point], tangent,
                                                         sideways, coupling, inertia, backwards, bodies);
      };
      if (tangent)
        change = max(change, inertia ? relax_as.template operator()<true, false>() : relax_as.template operator()<true, true>());
      else
        change =
            max(change, inertia ? relax_as.template operator()<false, false>() : relax_as.template operator()<false, true>());
    }
    return step_ * horizontal_max(change);
  });
}

void ContactBatch::sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, double beta, SweepSums& sums,
                                std::span<const std::uint8_t> counted) {
  const double per_unit = 1 / sums.unit;
  with_model(friction_, [&]<FrictionModel model>() {
    Vec4d change = broadcast(0), largest = broadcast(0);
    Mask4 gradient{}, progress{};
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Block& block = blocks[i];
      ask_for<const SolverBody>(blocks, i, bodies), ask_for<Wrench>(blocks, i, wrenches);
      const std::uint32_t p = block.first_point;
      const std::int32_t t = block.first_tangent;
      const SweepTerms terms = t < 0
                                   ? sweep_block<model, false>(block, &points[p], &normals[p], &normal_momenta[p], nullptr,
                                                               nullptr, nullptr, beta, bodies, wrenches)
                                   : sweep_block<model, true>(block, &points[p], &normals[p], &normal_momenta[p], &tangents[t],
                                                              &tangent_impulses[t], &tangent_momenta[t], beta, bodies, wrenches);
      change = max(change, terms.change);
      largest = max(largest, max(abs(terms.gradient), terms.progress));
      Mask4 counts;
      for (std::size_t l = 0; l < lanes; ++l) counts[l] = block.manifold[l] >= 0 && counted[block.manifold[l]] != 0 ? -1 : 0;
      gradient += whole_units(terms.gradient, per_unit) & counts;
      progress += whole_units(terms.progress, per_unit) & counts;
    }
    for (std::size_t l = 0; l < lanes; ++l) sums.gradient += gradient[l], sums.progress += progress[l];
    sums.change = std::max(sums.change, step_ * horizontal_max(change));
    sums.largest = std::max(sums.largest, horizontal_max(largest));
  });
}

namespace {

// One manifold of a block, its lane beside three empty ones, with the scales of its points alone.
struct LoneManifold {
  LoneManifold(const ContactBatch& batch, const Block& whole, std::size_t lane, Slot nobody, bool cone) : block(whole) {
    const auto inverse = [](Vec4d k) { return select(k > broadcast(0), broadcast(1) / k, broadcast(0)); };
    for (std::size_t l = 0; l < lanes; ++l)
      if (l != lane) block.slot_a[l] = block.slot_b[l] = nobody;
    for (std::uint32_t k = 0; k < block.count; ++k) {
      points[k] = batch.points[block.first_point + k], normals[k] = batch.normals[block.first_point + k];
      points[k].inverse_scale = inverse(points[k].mobility);
      if (block.first_tangent < 0) continue;
      const std::size_t t = static_cast<std::size_t>(block.first_tangent) + k;
      tangents[k] = batch.tangents[t], tangent_impulses[k] = batch.tangent_impulses[t];
      const Vec4d scale = cone ? max(points[k].mobility, tangents[k].mobility) : tangents[k].mobility;
      tangents[k].inverse_scale = inverse(scale);
      if (cone) points[k].inverse_scale = tangents[k].inverse_scale;
    }
  }

  template <FrictionModel model>
  void relax(const Inertia* inertia, bool backwards, std::span<SolverBody> bodies) {
    const auto relax_as = [&]<bool tangential, bool isotropic>() {
      relax_block<model, tangential, isotropic>(block, points, normals, tangents, tangent_impulses, couplings, inertia, backwards,
                                                bodies);
    };
    if (block.first_tangent >= 0)
      inertia ? relax_as.template operator()<true, false>() : relax_as.template operator()<true, true>();
    else
      inertia ? relax_as.template operator()<false, false>() : relax_as.template operator()<false, true>();
  }

  Block block;
  Point points[8];
  Normal normals[8];
  Tangents tangents[8];
  TangentImpulse tangent_impulses[8];
  Coupling couplings[8] = {};  // left out: the next pass sees them
};

}  // namespace

// Whether a body would end the step further in what does not move than its centre now is out of it, along the normal. (With half
// as much towers that 20 iterations hold fall: what lies on a body that is pushed out so is left behind.)
bool ContactBatch::sinks(const Block& block, const Source& source, std::size_t lane, bool is_a,
                         std::span<const SolverBody> bodies) const {
  const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
  for (std::uint32_t k = 0; k < source.count[lane]; ++k) {
    const Point& p = points[block.first_point + k];
    const Vec4d gap = broadcast(contacts_->points[source.contact[lane] + k].gap);
    const Vec4d end = gap + broadcast(step_) * relative_velocity<false>(block, block.s, p, a, b).n;
    const Vec4d out = is_a ? -dot(block.n, p.arm_a) : dot(block.n, p.arm_b);
    if (end[lane] < 0 && -end[lane] > out[lane]) return true;
  }
  return false;
}

void ContactBatch::settle(std::size_t homes, std::size_t first_static, std::span<SolverBody> bodies) {
  constexpr int passes = 4;
  const auto nobody = static_cast<Slot>(bodies.size() - 1);
  const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < homes; };
  for (std::size_t i = 0; i < blocks.size(); ++i)
    for (std::size_t l = 0; l < lanes; ++l) {
      const Slot a = blocks[i].slot_a[l], b = blocks[i].slot_b[l];
      if (is_home(a) == is_home(b) || static_cast<std::size_t>(is_home(a) ? b : a) < first_static) continue;
      if (!sinks(blocks[i], sources[i], l, is_home(a), bodies)) continue;
      LoneManifold lone(*this, blocks[i], l, nobody, uses_cone_projection(friction_));
      const Inertia* inertia = blocks[i].inertia < 0 ? nullptr : &inertias[blocks[i].inertia];
      with_model(friction_, [&]<FrictionModel model>() {
        for (int pass = 0; pass < passes; ++pass) lone.template relax<model>(inertia, pass % 2 == 1, bodies);
      });
      for (std::uint32_t k = 0; k < blocks[i].count; ++k) {
        normals[blocks[i].first_point + k].lambda[l] = lone.normals[k].lambda[l];
        if (blocks[i].first_tangent < 0) continue;
        TangentImpulse& sideways = tangent_impulses[static_cast<std::size_t>(blocks[i].first_tangent) + k];
        sideways.lambda_s[l] = lone.tangent_impulses[k].lambda_s[l], sideways.lambda_t[l] = lone.tangent_impulses[k].lambda_t[l];
      }
    }
}

double ContactBatch::residual(std::span<const SolverBody> bodies) const {
  return with_model(friction_, [&]<FrictionModel model>() {
    Vec4d worst = broadcast(0);
    for (std::size_t number = 0; number < blocks.size(); ++number) {
      const Block& block = blocks[number];
      ask_for<const SolverBody>(blocks, number, bodies);
      const Side a = gather(block.slot_a, bodies), b = gather(block.slot_b, bodies);
      const Vec3x4 t = cross(block.n, block.s);
      for (std::uint32_t k = 0; k < block.count; ++k) {
        const Point& p = points[block.first_point + k];
        const Normal& normal = normals[block.first_point + k];
        const std::int32_t i = block.first_tangent + static_cast<std::int32_t>(k);
        if (block.first_tangent < 0)
          worst = max(worst, point_residual<model, false>(block, p, normal, nullptr, nullptr,
                                                          relative_velocity<false>(block, t, p, a, b)));
        else
          worst = max(worst, point_residual<model, true>(block, p, normal, &tangents[i], &tangent_impulses[i],
                                                         relative_velocity<true>(block, t, p, a, b)));
      }
    }
    return step_ * horizontal_max(worst);
  });
}

void ContactBatch::add_impulses(std::span<Wrench> wrenches) const {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = blocks[i];
    ask_for<Wrench>(blocks, i, wrenches);
    const Vec3x4 t = cross(block.n, block.s);
    const Vec4d zero = broadcast(0);
    Vec3x4 force{zero, zero, zero}, torque_a = force, torque_b = force;
    for (std::uint32_t k = 0; k < block.count; ++k) {
      const Point& p = points[block.first_point + k];
      const Vec4d lambda = normals[block.first_point + k].lambda;
      Vec3x4 f = block.n * lambda;
      if (block.first_tangent >= 0) {
        const TangentImpulse& sideways = tangent_impulses[block.first_tangent + k];
        f = impulse_vector<true>(block, t, lambda, sideways.lambda_s, sideways.lambda_t);
      }
      force = force + f, torque_a = torque_a + cross(p.arm_a, f), torque_b = torque_b + cross(p.arm_b, f);
    }
    add_wrenches(block, force, torque_a, torque_b, wrenches);
  }
}

}  // namespace unibody
