#include "constraints/contact_batch.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "collide/collide.hpp"
#include "constraints/carried.hpp"
#include "constraints/contact_for_each.hpp"
#include "constraints/creep.hpp"
#include "constraints/friction.hpp"
#include "constraints/lanes.hpp"
#include "world/world.hpp"

namespace unibody {

namespace {

void set_inertia(Vec4d (&m)[6], std::size_t lane, const InverseInertia& i) {
  m[0][lane] = i.xx, m[1][lane] = i.yy, m[2][lane] = i.zz, m[3][lane] = i.yz, m[4][lane] = i.xz, m[5][lane] = i.xy;
}

}  // namespace

ContactBatch::ContactBatch(std::pmr::memory_resource* memory)
    : blocks(memory),
      points(memory),
      normals(memory),
      tangents(memory),
      tangent_impulses(memory),
      couplings(memory),
      normal_scales(memory),
      tangent_scales(memory),
      normal_momenta(memory),
      tangent_momenta(memory),
      inertias(memory),
      drifts(memory),
      ratios(memory),
      places_(memory),
      rows_(memory),
      closing_(memory),
      bouncing_(memory),
      left_shares_(memory),
      counted_(memory),
      kept_impulses_(memory),
      leak_shares_(memory),
      uneven_shares_(memory),
      creeps_(memory),
      constrained_(memory),
      hidden_(memory),
      soft_points_(memory) {}

// Manifolds are read in key order, where each is next to the one before and so are its bodies: in the order of colours they are
// strangers, which in large scenes costs more than all that is done with them. Each colour has a block that fills up.
void ContactBatch::build(const BuildContext& context) {
  const auto& [bodies, inertia, isotropic, counts] =
      std::tie(context.state.bodies, context.state.inertia, context.state.isotropic, context.state.counts);
  displaced_ = context.displaced, bounce_starts_ = context.bounce_starts;
  contacts_ = context.contacts, world_ = &context.world,
  friction_ = in_directions(context.settings.friction, !context.world.friction_axes.empty());
  scaling_ = context.settings.scaling, step_ = context.state.step, least_creep_ = context.least_creep;
  is_gauss_seidel_ = counts.empty(), bias_is_gap_ = true, kept_ = Kept::nothing;
  closing_.clear(), bouncing_.clear(), leak_shares_.clear(), uneven_shares_.clear();
  constrained_.clear(), hidden_.clear(), selected_ = Islands::all, any_selected_ = true;
  counted_.resize(contacts_->manifolds.size());
  for (std::size_t m = 0; m < counted_.size(); ++m) counted_[m] = counts_here(*world_, contacts_->manifolds[m]);
  const auto nobody = static_cast<Slot>(bodies.size() - 1);
  const auto inertia_of = [&](Slot s) {
    const double all = bodies[s].inverse_inertia;
    return isotropic[s] ? InverseInertia{all, all, all, 0, 0, 0} : inertia[s];
  };
  recall_creeps(context.contact_history);
  lay_out(context.contact_order, context.contact_groups, isotropic, is_gauss_seidel_);

  std::pmr::vector<std::uint8_t> filled(blocks.size(), 0, places_.get_allocator());  // lanes
  for (std::uint32_t m = 0; m < places_.size(); ++m) {
    const std::size_t number = places_[m] / lanes, lane = places_[m] % lanes;
    if (filled[number]++ == 0) begin_block(number, nobody);
    Block& block = blocks[number];
    fill_lane(block, lane, m);
    if (block.inertia >= 0) {
      set_inertia(inertias[block.inertia].a, lane, inertia_of(block.slot_a[lane]));
      set_inertia(inertias[block.inertia].b, lane, inertia_of(block.slot_b[lane]));
    }
    if (filled[number] < rows_[number].used) continue;
    if (is_gauss_seidel_)
      scale_gauss_seidel(block, bodies);
    else
      scale_jacobi(block, bodies, counts);
  }
  soften(context);
}

// Gives each manifold its place, in the given order, and each block its rows: as many as its longest manifold has.
void ContactBatch::lay_out(std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups,
                           std::span<const std::uint8_t> isotropic, bool gauss_seidel) {
  places_.resize(order.size()), group_end_.clear();
  std::uint32_t place = 0;
  std::size_t begin = 0;
  for (const std::size_t end : groups) {
    for (; begin < end; ++begin) places_[order[begin]] = place++;
    place = (place + lanes - 1) / lanes * lanes;
    group_end_.push_back(place / lanes);
  }
  rows_.assign(place / lanes, Rows{});
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Manifold& m = contacts_->manifolds[i];
    Rows& rows = rows_[places_[i] / lanes];
    ++rows.used, rows.count = std::max(rows.count, static_cast<std::uint16_t>(m.count));
    if (acts_in_solve(friction_) && m.friction > 0) {
      rows.first_tangent = 0;
      if (friction_ == FrictionModel::ellipse) rows.ratio = 0;
      if (is_carried(m) || (!creeps_.empty() && !beyond(creeps_[i], least_creep_, smaller_radius(m)).is_zero())) rows.drift = 0;
    }
    if (!isotropic[m.slot_a] || !isotropic[m.slot_b]) rows.inertia = 0;
  }
  std::uint32_t point_count = 0, tangent_count = 0, general_count = 0, drift_count = 0, ratio_count = 0;
  for (Rows& rows : rows_) {
    rows.first_point = std::exchange(point_count, point_count + rows.count);
    if (rows.first_tangent == 0)
      rows.first_tangent = static_cast<std::int32_t>(std::exchange(tangent_count, tangent_count + rows.count));
    if (rows.inertia == 0) rows.inertia = static_cast<std::int32_t>(general_count++);
    if (rows.drift == 0) rows.drift = static_cast<std::int32_t>(drift_count++);
    if (rows.ratio == 0) rows.ratio = static_cast<std::int32_t>(ratio_count++);
  }
  const auto renew = [](auto& of, std::size_t size) { of.clear(), of.resize(size); };  // room for so many and no more
  renew(blocks, rows_.size()), renew(inertias, general_count), renew(drifts, drift_count), renew(ratios, ratio_count);
  renew(points, point_count), renew(normals, point_count);
  renew(tangents, tangent_count), renew(tangent_impulses, tangent_count);
  renew(couplings, gauss_seidel ? tangent_count : 0);
  renew(normal_scales, gauss_seidel ? 0 : point_count), renew(tangent_scales, gauss_seidel ? 0 : tangent_count);
  renew(normal_momenta, gauss_seidel ? 0 : point_count), renew(tangent_momenta, gauss_seidel ? 0 : tangent_count);
}

// A block of empty lanes, and rows of zeros for its points.
void ContactBatch::begin_block(std::size_t number, Slot nobody) {
  const Rows& rows = rows_[number];
  Block& block = blocks[number] = Block{};
  std::fill_n(block.slot_a, lanes, nobody), std::fill_n(block.slot_b, lanes, nobody);
  std::fill_n(block.manifold, lanes, -1);
  block.first_point = rows.first_point, block.count = rows.count;
  block.first_tangent = rows.first_tangent, block.inertia = rows.inertia, block.drift = rows.drift, block.ratio = rows.ratio;
  if (rows.drift >= 0) drifts[rows.drift] = Drift{};
  if (rows.ratio >= 0) ratios[rows.ratio] = broadcast(1);
  if (rows.inertia >= 0) inertias[rows.inertia] = Inertia{};
  const auto clear = [&](auto& of, std::size_t first) {
    if (!of.empty())
      std::fill_n(of.begin() + static_cast<std::ptrdiff_t>(first), rows.count,
                  typename std::remove_cvref_t<decltype(of)>::value_type{});
  };
  clear(points, rows.first_point), clear(normals, rows.first_point);
  clear(normal_scales, rows.first_point), clear(normal_momenta, rows.first_point);
  if (rows.first_tangent < 0) return;
  const auto first = static_cast<std::size_t>(rows.first_tangent);
  clear(tangents, first), clear(tangent_impulses, first), clear(couplings, first);
  clear(tangent_scales, first), clear(tangent_momenta, first);
}

bool ContactBatch::is_carried(const Manifold& m) const {
  if (step_ * common_turn(*world_, m.slot_a, m.slot_b).turn.norm() >= least_turn) return true;
  return !world_->surface_motions.empty() && (has_own_motion(*world_, m.slot_a) || has_own_motion(*world_, m.slot_b));
}

// Of a's centre against b, with the turn about the normal.
OwnMotion ContactBatch::drift_of(const Manifold& m) const {
  const CommonTurn common = common_turn(*world_, m.slot_a, m.slot_b);
  const Vec3 centre_a = place_of(*world_, m, m.slot_a), centre_b = place_of(*world_, m, m.slot_b), from = centre_a - centre_b;
  const Vec3 velocity = world_->velocity[m.slot_a] - world_->velocity[m.slot_b];
  const Vec3 drift = drift_along_circle(common.turn, from, velocity, step_);  // odd in both: whichever of the two carries
  OwnMotion all{drift - m.normal * m.normal.dot(drift), Vec3::Zero()};
  if (world_->surface_motions.empty()) return all;
  Vec3 middle = Vec3::Zero();
  for (std::uint32_t p = 0; p < m.count; ++p) middle += contacts_->points[m.first + p].position / m.count;
  const OwnMotion on_b = drift_on_surface(*world_, m.slot_b, m.slot_a, middle - centre_b, from, m.normal, step_);
  const OwnMotion on_a = drift_on_surface(*world_, m.slot_a, m.slot_b, middle - centre_a, -from, m.normal, step_);
  all.v += on_b.v + on_b.w.cross(from), all.w += on_b.w;
  all.v -= on_a.v, all.w -= on_a.w;
  return all;
}

double ContactBatch::closing_of(const Manifold& m) const {
  const CommonTurn common = common_turn(*world_, m.slot_a, m.slot_b);
  if (!(step_ * common.turn.norm() >= least_turn)) return 0;
  const Slot carrier = common.a_carries ? m.slot_a : m.slot_b;
  const bool driven = world_->is_static(carrier);
  const auto may_hold = [&](Slot slot) {
    const ShapeKind kind = world_->properties[static_cast<std::size_t>(slot)].shape.kind;
    return kind == ShapeKind::compound || kind == ShapeKind::mesh;
  };
  if (!driven && !may_hold(m.slot_a) && !may_hold(m.slot_b)) return 0;  // convex bodies part where they turn
  const Vec3 from = place_of(*world_, m, m.slot_a) - place_of(*world_, m, m.slot_b);
  const Vec3 velocity = world_->velocity[m.slot_a] - world_->velocity[m.slot_b];
  const auto carried = static_cast<std::size_t>(common.a_carries ? m.slot_b : m.slot_a);
  const Shape& shape = world_->properties[carried].shape;
  const bool rolls = is_round(shape) || shape.kind == ShapeKind::particle;
  const Vec3& spin = world_->angular_velocity_of(carried);
  const Vec3 out = common.a_carries ? Vec3(-m.normal) : m.normal;  // from the carrier
  const double sign = common.a_carries ? -1 : 1;
  return closing_along_normal(common.turn, sign * from, sign * velocity, spin, rolls, driven, out, step_);
}

void ContactBatch::fill_lane(Block& block, std::size_t lane, std::uint32_t number) {
  const World& world = *world_;
  const Manifold& m = contacts_->manifolds[number];
  block.slot_a[lane] = m.slot_a, block.slot_b[lane] = m.slot_b;
  block.manifold[lane] = static_cast<std::int32_t>(number);
  set_lane(block.n, lane, m.normal);
  const FrictionFrame frame = contacts_->frame_of(m);
  set_lane(block.s, lane, frame.s);
  if (block.ratio >= 0) ratios[block.ratio][lane] = frame.across;
  block.friction[lane] = m.friction;
  // Without friction there is none, also beside others in the block: who they are depends on the rank.
  if (block.drift >= 0 && m.friction > 0) {
    OwnMotion drift = is_carried(m) ? drift_of(m) : OwnMotion{};
    if (!creeps_.empty()) {
      const Creep creep = beyond(creeps_[number], least_creep_, smaller_radius(m));
      const Vec3 back = -creep_taken_out / step_ * m.normal.dot(creep.turn) * m.normal;
      drift.v -= creep_taken_out / step_ * (creep.slip - m.normal * m.normal.dot(creep.slip));
      drift.v += back.cross(place_of(world, m, m.slot_a) - creeps_about(m)), drift.w += back;
    }
    set_lane(drifts[block.drift].v, lane, drift.v), set_lane(drifts[block.drift].w, lane, drift.w);
  }
  // The bodies reach the place of the contact from where they will come out: angular momentum is kept. A body that is not round
  // and meets something that forces don't move touches it with its own surface (arm_of), wherever it comes from.
  const auto properties = [&](Slot slot) -> const BodyProperties& { return world.properties[static_cast<std::size_t>(slot)]; };
  const auto moved = [&](Slot slot, Slot other) -> Vec3 {
    if (displaced_.empty() || !(properties(other).is_dynamic() || is_round(properties(slot).shape))) return Vec3::Zero();
    return displaced_[static_cast<std::size_t>(slot)];
  };
  const Vec3 moved_a = moved(m.slot_a, m.slot_b), moved_b = moved(m.slot_b, m.slot_a);
  const bool node_a = is_particle(world, m.slot_a), node_b = is_particle(world, m.slot_b);
  for (std::uint32_t p = 0; p < m.count; ++p) {
    const ContactPoint& contact = contacts_->points[m.first + p];
    Point& point = points[block.first_point + p];
    set_lane(point.arm_a, lane, arm_of(world, m, contact, m.slot_a) - moved_a + (node_b ? moved_b : Vec3(Vec3::Zero())));
    set_lane(point.arm_b, lane, arm_of(world, m, contact, m.slot_b) - moved_b + (node_a ? moved_a : Vec3(Vec3::Zero())));
    point.bias[lane] = contact.gap;
    point.inverse_scale[lane] = 1;  // marks a row in use; the scale passes overwrite it
  }
  if (const double speed = closing_of(m); speed != 0)
    closing_.push_back({{static_cast<std::uint32_t>(&block - blocks.data()), static_cast<std::uint32_t>(lane)}, speed});
}

void ContactBatch::start_stage(const Stage& stage) {
  stage_ = stage;
  select_islands(stage.islands);
  if (!bias_is_gap_)
    for_each_row([&](std::size_t, std::size_t l, std::size_t p, std::size_t, std::size_t contact) {
      points[p].bias[l] = contacts_->points[contact].gap;
    });
  for (Point& p : points) p.bias = stage.bias(p.bias);
  if (stage.kind == Stage::Kind::position)
    for (const Closing& c : closing_)
      for (std::uint32_t k = 0; k < blocks[c.at.block].count; ++k)
        points[blocks[c.at.block].first_point + k].bias[c.at.lane] -= c.speed;
  if (!contacts_->bounce.empty()) start_bounces();
  bias_is_gap_ = false;
}

}  // namespace unibody
