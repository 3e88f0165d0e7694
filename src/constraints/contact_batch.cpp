#include "constraints/contact_batch.hpp"

#include <cassert>

#include "constraints/friction.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

void set_lane(Vec3x4& v, std::size_t lane, const Vec3& x) { v.x[lane] = x.x(), v.y[lane] = x.y(), v.z[lane] = x.z(); }

void set_lane(Vec4d (&m)[6], std::size_t lane, const InverseInertia& i) {
  m[0][lane] = i.xx, m[1][lane] = i.yy, m[2][lane] = i.zz, m[3][lane] = i.yz, m[4][lane] = i.xz, m[5][lane] = i.xy;
}

constexpr std::size_t ahead = 16;

// Colours run through the contacts with strides that the processor does not foresee.
void ask_for(const Contacts& contacts, const std::vector<Vec3>& position, std::uint32_t soon, std::uint32_t later) {
  const Manifold &m = contacts.manifolds[soon], &next = contacts.manifolds[later];
  const ContactPoint& point = contacts.points[m.first];
  __builtin_prefetch(&point.position);  // a record may begin in one cache line and end in another
  __builtin_prefetch(&point.feature);
  __builtin_prefetch(&position[static_cast<std::size_t>(m.slot_b)]);
  __builtin_prefetch(&next.id_a);
  __builtin_prefetch(&next.count);
}

}  // namespace

ContactBatch::ContactBatch(std::pmr::memory_resource* memory)
    : blocks(memory),
      sources(memory),
      points(memory),
      normals(memory),
      tangents(memory),
      tangent_impulses(memory),
      couplings(memory),
      normal_momenta(memory),
      tangent_momenta(memory),
      inertias(memory),
      bouncing_(memory) {}

void ContactBatch::build(const Contacts& contacts, std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups,
                         const World& world, std::span<const SolverBody> bodies, std::span<const InverseInertia> inertia,
                         std::span<const std::uint8_t> isotropic, std::span<const std::int32_t> counts,
                         const SolverSettings& settings, double step) {
  contacts_ = &contacts, world_ = &world, bias_is_gap_ = true, kept_ = Kept::nothing, friction_ = settings.friction,
  scaling_ = settings.scaling, step_ = step;
  blocks.clear(), sources.clear(), points.clear(), normals.clear(), tangents.clear(), tangent_impulses.clear();
  inertias.clear(), group_end_.clear(), bouncing_.clear(), before_ = {};
  couplings.clear(), normal_momenta.clear(), tangent_momenta.clear();
  const auto nobody = static_cast<Slot>(bodies.size() - 1);
  const bool gauss_seidel = counts.empty();
  const auto inertia_of = [&](Slot s) {
    const double all = bodies[s].inverse_inertia;
    return isotropic[s] ? InverseInertia{all, all, all, 0, 0, 0} : inertia[s];
  };
  reserve(order, groups, isotropic, gauss_seidel);

  std::size_t begin = 0;
  for (const std::size_t end : groups) {
    for (; begin < end; begin += std::min(lanes, end - begin)) {
      Block block{};
      Source& source = sources.emplace_back(Source{});
      const std::size_t used = std::min(lanes, end - begin);
      for (std::size_t k = begin + ahead; k < std::min(begin + ahead + lanes, order.size()); ++k)
        ask_for(contacts, world.position, order[k], order[std::min(k + ahead, order.size() - 1)]);
      bool any_friction = false, all_isotropic = true;
      for (std::size_t l = 0; l < lanes; ++l) {
        block.slot_a[l] = block.slot_b[l] = nobody, block.manifold[l] = -1;
        if (l >= used) continue;
        const Manifold& m = contacts.manifolds[order[begin + l]];
        block.slot_a[l] = m.slot_a, block.slot_b[l] = m.slot_b;
        block.manifold[l] = static_cast<std::int32_t>(order[begin + l]);
        block.count = std::max(block.count, m.count);
        any_friction |= acts_in_solve(friction_) && m.friction > 0;
        all_isotropic &= isotropic[m.slot_a] && isotropic[m.slot_b];
      }
      add_rows(block, any_friction, gauss_seidel);
      block.inertia = all_isotropic ? -1 : static_cast<std::int32_t>(inertias.size());
      if (!all_isotropic) {
        Inertia& both = inertias.emplace_back();
        for (std::size_t l = 0; l < lanes; ++l) {
          set_lane(both.a, l, inertia_of(block.slot_a[l]));
          set_lane(both.b, l, inertia_of(block.slot_b[l]));
        }
      }
      for (std::size_t l = 0; l < used; ++l) fill_lane(block, source, l, order[begin + l], world);
      if (gauss_seidel)
        scale_gauss_seidel(block, bodies);
      else
        scale_jacobi(block, bodies, counts);
      blocks.push_back(block);
    }
    group_end_.push_back(static_cast<std::uint32_t>(blocks.size()));
  }
}

// Room for the blocks to come.
void ContactBatch::reserve(std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups,
                           std::span<const std::uint8_t> isotropic, bool gauss_seidel) {
  std::size_t block_count = 0, point_count = 0, tangent_count = 0, general_count = 0, begin = 0;
  for (const std::size_t end : groups)
    for (; begin < end; begin += std::min(lanes, end - begin)) {
      std::uint32_t longest = 0;
      bool general = false, rough = false;
      for (std::size_t l = 0; l < std::min(lanes, end - begin); ++l) {
        const Manifold& next = contacts_->manifolds[order[std::min(begin + l + ahead, order.size() - 1)]];
        __builtin_prefetch(&next.slot_a), __builtin_prefetch(&next.count);
        const Manifold& m = contacts_->manifolds[order[begin + l]];
        longest = std::max(longest, m.count);
        rough |= acts_in_solve(friction_) && m.friction > 0;
        general |= !isotropic[m.slot_a] || !isotropic[m.slot_b];
      }
      ++block_count, point_count += longest, general_count += general;
      if (rough) tangent_count += longest;
    }
  blocks.reserve(block_count), sources.reserve(block_count), inertias.reserve(general_count);
  points.reserve(point_count), normals.reserve(point_count);
  tangents.reserve(tangent_count), tangent_impulses.reserve(tangent_count);
  if (gauss_seidel)
    couplings.reserve(tangent_count);
  else
    normal_momenta.reserve(point_count), tangent_momenta.reserve(tangent_count);
}

// Rows of zeros for the block's points.
void ContactBatch::add_rows(Block& block, bool tangential, bool gauss_seidel) {
  block.first_point = static_cast<std::uint32_t>(points.size());
  block.first_tangent = tangential ? static_cast<std::int32_t>(tangents.size()) : -1;
  points.resize(points.size() + block.count), normals.resize(points.size());
  if (tangential) tangents.resize(tangents.size() + block.count), tangent_impulses.resize(tangents.size());
  if (gauss_seidel)
    couplings.resize(tangents.size());
  else
    normal_momenta.resize(points.size()), tangent_momenta.resize(tangents.size());
}

void ContactBatch::fill_lane(Block& block, Source& source, std::size_t lane, std::uint32_t number, const World& world) {
  const Manifold& m = contacts_->manifolds[number];
  source.contact[lane] = m.first, source.count[lane] = static_cast<std::uint8_t>(m.count);
  set_lane(block.n, lane, m.normal);
  set_lane(block.s, lane, first_tangent_of(m.normal));
  block.friction[lane] = m.friction;
  Vec3 centre_a = world.position[m.slot_a], centre_b = world.position[m.slot_b];
  if (m.time > 0) centre_a += m.time * world.velocity[m.slot_a], centre_b += m.time * world.velocity[m.slot_b];
  for (std::uint32_t p = 0; p < m.count; ++p) {
    const ContactPoint& contact = contacts_->points[m.first + p];
    Point& point = points[block.first_point + p];
    set_lane(point.arm_a, lane, contact.position - centre_a);
    set_lane(point.arm_b, lane, contact.position - centre_b);
    normals[block.first_point + p].bias[lane] = contact.gap;
    point.inverse_scale[lane] = 1;  // marks a row in use; the scale passes overwrite it
  }
}

template <class Record, class F>
void ContactBatch::for_each_row(const Record* records, F&& f) const {
  constexpr std::size_t soon = ahead / lanes;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (records && i + soon < blocks.size())
      for (const std::uint32_t contact : sources[i + soon].contact) __builtin_prefetch(&records[contact]);
    const Block& block = blocks[i];
    const Source& source = sources[i];
    for (std::size_t l = 0; l < lanes; ++l)
      for (std::uint32_t p = 0; p < source.count[l]; ++p)
        f(block, l, block.first_point + p, block.first_tangent < 0 ? no_tangent : block.first_tangent + p, source.contact[l] + p);
  }
}

void ContactBatch::start_stage(const Stage& stage) {
  if (!bias_is_gap_)
    for_each_row(contacts_->points.data(), [&](const Block&, std::size_t l, std::size_t p, std::size_t, std::size_t contact) {
      normals[p].bias[l] = contacts_->points[contact].gap;
    });
  for (Normal& n : normals) n.bias = stage.bias(n.bias);
  if (!contacts_->bounce.empty()) start_bounces();
  bias_is_gap_ = false;
}

void ContactBatch::set_impulses(std::span<const Impulse> impulses) {
  for_each_row(impulses.data(), [&](const Block&, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    const Impulse impulse = impulses.empty() ? Impulse{0, 0, 0} : impulses[contact];
    normals[p].lambda[l] = impulse.n;
    if (t != no_tangent) tangent_impulses[t].lambda_s[l] = impulse.s, tangent_impulses[t].lambda_t[l] = impulse.t;
  });
  start_momenta();
}

void ContactBatch::start_momenta() {
  for (std::size_t p = 0; p < normal_momenta.size(); ++p) normal_momenta[p].y = normals[p].lambda;
  for (std::size_t t = 0; t < tangent_momenta.size(); ++t)
    tangent_momenta[t].y_s = tangent_impulses[t].lambda_s, tangent_momenta[t].y_t = tangent_impulses[t].lambda_t;
}

ContactBatch::Impulse ContactBatch::row(std::size_t l, std::size_t p, std::size_t t) const {
  if (t == no_tangent) return {normals[p].lambda[l], 0, 0};
  return {normals[p].lambda[l], tangent_impulses[t].lambda_s[l], tangent_impulses[t].lambda_t[l]};
}

void ContactBatch::get_impulses(std::span<Impulse> impulses) const {
  for_each_row(impulses.data(), [&](const Block&, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    impulses[contact] = row(l, p, t);
  });
}

void ContactBatch::normal_impulses(std::span<const Impulse> kept, std::span<double> normal) const {
  for_each_row(normal.data(), [&](const Block&, std::size_t l, std::size_t p, std::size_t, std::size_t contact) {
    normal[contact] = normals[p].lambda[l] + (kept_ == Kept::apart ? kept[contact].n : 0);
  });
}

void ContactBatch::keep_impulses(bool joint, std::span<Impulse> kept) {
  get_impulses(kept);
  kept_ = joint ? Kept::joint : Kept::apart;
  if (!joint) before_ = kept;
  if (joint) return start_momenta();
  for (Normal& n : normals) n.lambda = broadcast(0);
  for (TangentImpulse& t : tangent_impulses) t.lambda_s = t.lambda_t = broadcast(0);
  start_momenta();
}

std::int64_t ContactBatch::leak_impulses(double leak, std::span<const std::uint8_t> counted, std::span<Impulse> kept) const {
  std::int64_t sliding = 0;
  for_each_row(kept.data(), [&](const Block& block, std::size_t l, std::size_t p, std::size_t t, std::size_t contact) {
    const Impulse old = kept_ == Kept::nothing ? Impulse{0, 0, 0} : kept[contact], now = row(l, p, t);
    const Impulse before = kept_ == Kept::apart ? old : Impulse{0, 0, 0};
    const double limit = 0.999 * block.friction[l] * (before.n + now.n), s = before.s + now.s, f = before.t + now.t;
    sliding += t != no_tangent && limit > 0 && s * s + f * f >= limit * limit && counted[block.manifold[l]];
    const auto mix = [&](double x, double y) { return x + leak * (kept_ == Kept::apart ? y : y - x); };
    kept[contact] = kept_ == Kept::nothing ? now : Impulse{mix(old.n, now.n), mix(old.s, now.s), mix(old.t, now.t)};
  });
  return sliding;
}

}  // namespace unibody
