#include "collide/narrowphase.hpp"

#include <algorithm>
#include <cmath>

#include "collide/approach.hpp"
#include "collide/box_box.hpp"
#include "collide/corners_ahead.hpp"
#include "collide/shape_pairs.hpp"
#include "collide/sweep.hpp"
#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

using Function = void (*)(const Proxy&, const Proxy&, const PairSettings&, PairManifold&);

void none(const Proxy&, const Proxy&, const PairSettings&, PairManifold&) {}

void two_boxes(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  settings.planar ? box_box_planar(a, b, settings, out) : box_box(a, b, settings, out);
}

double fastest(const Proxy& a, const Proxy& b) { return std::max(std::max(a.speed, b.speed), (a.velocity - b.velocity).norm()); }

struct Cell {
  Function function;
  SweepFunction sweep;   // null: never needed
  bool swapped = false;  // the functions take b first
};

// Rows and columns in the order of ShapeKind.
constexpr Cell round_with_round{round_round, sweep_round_round}, round_with_box{round_box, sweep_round_box},
    round_with_plane{round_plane, nullptr}, box_with_box{two_boxes, sweep_box_box}, box_with_plane{box_plane, nullptr},
    solid_with_solid{convex_convex, sweep_convex}, solid_with_plane{convex_plane, nullptr}, nothing{none, nullptr};

constexpr Cell flip(Cell c) { return {c.function, c.sweep, true}; }

constexpr std::size_t listed = 5;  // kinds; all others are convex solids
constexpr Cell table[listed][listed] = {
    /* sphere */ {round_with_round, round_with_box, round_with_plane, round_with_round, round_with_round},
    /* box    */ {flip(round_with_box), box_with_box, box_with_plane, flip(round_with_box), flip(round_with_box)},
    /* plane  */ {flip(round_with_plane), flip(box_with_plane), nothing, flip(round_with_plane), flip(round_with_plane)},
    /* disc   */ {round_with_round, round_with_box, round_with_plane, round_with_round, round_with_round},
    /* point  */ {round_with_round, round_with_box, round_with_plane, round_with_round, round_with_round},
};

Cell cell_of(ShapeKind a, ShapeKind b) {
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  if (i < listed && j < listed) return table[i][j];
  if (b == ShapeKind::plane) return solid_with_plane;
  return a == ShapeKind::plane ? flip(solid_with_plane) : solid_with_solid;
}

// The manifold where the bodies are.
void collide_at(const Cell& cell, const Proxy& first, const Proxy& second, double margin, const CollideSettings& settings,
                PairManifold& m) {
  cell.function(first, second, {margin, settings.planar}, m);
  if (!settings.planar) add_corners_ahead(first, second, settings.step, margin, m);
  // Round bodies that bounce may be sent anywhere within the step (step/impacts.hpp).
  const bool bounce = !settings.restitution.empty() && is_round(first.shape()) && is_round(second.shape());
  tidy(m, bounce ? margin : std::min(margin, margin_along(m.normal, first, second, settings)));
  for (int i = 0; i < m.count; ++i) m.points[i].position += first.position;
}

// The manifold where the bodies will first touch, or are at the end of the step if they touch later, its gaps opened by what they
// close until then along its normal. Where they will not touch, only what is near them now.
void collide_fast(const Cell& cell, const Proxy& first, const Proxy& second, double margin, const CollideSettings& settings,
                  PairManifold& m) {
  const Vec3 velocity = first.velocity - second.velocity;
  Impact impact;
  const Sweep sweep = cell.sweep(first, second, velocity, margin / velocity.norm(), impact);
  if (sweep == Sweep::overlap) return collide_at(cell, first, second, margin, settings, m);
  if (sweep == Sweep::miss) {
    const bool keeps_way = first.struck == 0 && second.struck == 0;
    return collide_at(cell, first, second, margin - (keeps_way ? settings.step * fastest(first, second) : 0), settings, m);
  }

  Proxy a = first, b = second;
  const bool in_step = impact.time <= settings.step;
  const double time = in_step ? impact.time : settings.step;
  a.position += time * a.velocity;
  b.position += time * b.velocity;
  if (in_step && impact.axis >= 0 && !settings.planar) {
    const BoxRelation relation = relate_boxes(a, b);
    box_manifold(a, b, relation, {impact.axis, separation_along(relation, a.half, b.half, impact.axis)}, margin, m);
  } else {
    cell.function(a, b, {margin, settings.planar}, m);
    if (!settings.planar) add_corners_ahead(a, b, settings.step, margin, m);
  }
  const double closed = time * std::max(0.0, -m.normal.dot(velocity));
  m.time = time;
  for (int i = 0; i < m.count; ++i) m.points[i].gap += closed, m.points[i].position += a.position;
  tidy(m, margin);
}

double least_gap(const PairManifold& m) {
  double least = HUGE_VAL;
  for (int i = 0; i < m.count; ++i) least = std::min(least, m.points[i].gap);
  return least;
}

// Two solids that are apart may pass by each other in the step, and the plane of their contact, which is that of the step's
// start, would still hold them (approach.hpp). Puts the contact in its place that they have at the time when they are nearest to
// each other, its gaps and arms as seen from where the two are at the start.
void leave_way(const Cell& cell, const Proxy& first, const Proxy& second, double margin, const CollideSettings& settings,
               PairManifold& m) {
  const Vec3 velocity = approach_velocity(first, second, settings), apart = first.position - second.position;
  const double close = 1e-6 * std::min(first.half_size, second.half_size), far = margin + settings.step * velocity.norm();
  const double gap = least_gap(m);
  if (!(gap > close && gap < -settings.step * m.normal.dot(velocity))) return;
  Proxy moving = first, standing = second;
  standing.position.setZero();  // exchanged ids change signs alone
  PairManifold then;
  const auto collide_then = [&](double time) {
    moving.position = apart + time * velocity;
    then.count = 0;
    cell.function(moving, standing, {far, settings.planar}, then);
    return then.count > 0;
  };
  const auto separation_at = [&](double time, Separation& separation) {
    if (!collide_then(time)) return false;
    separation = {least_gap(then), -then.normal.dot(velocity)};
    return true;
  };
  const Encounter encounter = encounter_of(settings.step, close, separation_at);
  if (!encounter.passes() || !collide_then(encounter.time)) return;
  const double closed = encounter.time * std::max(0.0, -then.normal.dot(velocity));
  // Arms from where the bodies are now, to one place for both: angular momentum is kept. Of what does not move they mean nothing.
  const double share = first.dynamic && second.dynamic ? 0.5 : first.dynamic ? 0 : 1;
  const Vec3 place = first.position + share * encounter.time * velocity + (share - 0.5) * closed * then.normal;
  m.normal = then.normal, m.count = then.count;
  for (int i = 0; i < then.count; ++i)
    m.points[i] = {then.points[i].position + place, then.points[i].gap + closed, then.points[i].feature};
  tidy(m, margin);
}

}  // namespace

void tidy(PairManifold& m, double margin) {
  ContactPoint* p = m.points;
  m.count = static_cast<int>(std::remove_if(p, p + m.count, [&](const ContactPoint& q) { return !(q.gap <= margin); }) - p);
  for (int i = 1; i < m.count; ++i) {  // few: by insertion
    const ContactPoint q = p[i];
    int hole = i;
    for (; hole > 0 && q.feature < p[hole - 1].feature; --hole) p[hole] = p[hole - 1];
    p[hole] = q;
  }
  const auto same = [](const ContactPoint& a, const ContactPoint& b) { return a.feature == b.feature; };
  m.count = static_cast<int>(std::unique(p, p + m.count, same) - p);
  while (m.count > PairManifold::kept) {  // of the two points that are nearest to each other, the shallower goes
    int remove = 0;
    double nearest = HUGE_VAL;
    for (int i = 0; i < m.count; ++i)
      for (int j = i + 1; j < m.count; ++j) {
        const double d = (p[i].position - p[j].position).squaredNorm();
        if (d < (1 - alike_distances) * nearest)
          nearest = d, remove = p[j].gap >= p[i].gap - alike_distances * std::sqrt(d) ? j : i;
      }
    std::move(p + remove + 1, p + m.count, p + remove);
    --m.count;
  }
}

// m: how much further than at its own speed a body's far end may come in the step, once the near one has bounced. A thin rod
// that lands on one end at a speed u is sent down at its other end by u (1 + e)/2, and no even body by more.
double reach_of_bounce(const Proxy& p, const CollideSettings& settings) {
  const double restitution = settings.largest_restitution_of(p.material);
  return restitution > 0 ? 0.5 * (1 + restitution) * settings.step * (p.speed + p.radius * p.spin.norm()) : 0;
}

Proxy make_proxy(const World& world, std::size_t slot, const CollideSettings& settings) {
  const BodyProperties& body = world.properties[slot];
  Proxy p;
  p.slot = static_cast<Slot>(slot);
  p.position = world.position[slot];
  if (settings.planar) p.position.y() = 0;
  p.velocity = world.velocity[slot];
  p.turn = body.is_dynamic() ? Vec3(Vec3::Zero()) : world.angular_velocity_of(slot);
  p.rotation = world.orientation_of(slot).toRotationMatrix();
  p.kind = body.shape.kind;
  const bool turns = !is_round(body.shape) && p.kind != ShapeKind::plane;  // so that it shows
  p.half = turns ? body.shape.size : Vec3::Constant(body.shape.size.x());
  p.data = body.shape.data;
  p.radius = p.kind == ShapeKind::plane ? 0 : bounding_radius(body.shape);
  p.dynamic = body.is_dynamic();
  if (p.dynamic) p.struck = settings.struck.speed_at(world.period.wrapped(p.position), p.radius);
  p.speed = std::max(p.velocity.norm(), p.struck);
  p.spin = turns ? world.angular_velocity_of(slot) : Vec3(Vec3::Zero());
  p.spin_reach = settings.step * p.radius * p.spin.norm();
  p.material = body.material, p.group = body.group;
  if (turns && p.dynamic) p.bounce_reach = reach_of_bounce(p, settings);
  if (!world.surface_motions.empty()) p.spin += own_motion(world, p.slot).w;
  p.half_size = p.kind == ShapeKind::hull ? 0.5 * smallest_size(body.shape) : p.half.minCoeff();
  if (settings.planar && p.kind == ShapeKind::box) p.half_size = std::min(p.half.x(), p.half.z());
  p.home = slot < world.homes;
  p.fall = p.dynamic ? settings.gravity.norm() * settings.step * settings.step : 0;
  p.id = world.id[slot];
  return p;
}

double relative_speed(const Proxy& a, const Proxy& b) {
  const Vec3 apart = a.velocity - b.velocity;
  const auto beside = [](const Proxy& body, const Proxy& carrier) {
    return (body.velocity - carrier.velocity - carrier.turn.cross(body.centre() - carrier.centre())).norm();
  };
  double least = apart.norm();
  if (!b.turn.isZero(0)) least = std::min(least, beside(a, b));
  if (!a.turn.isZero(0)) least = std::min(least, beside(b, a));
  return least;
}

double margin_along(const Vec3& normal, const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  const double va = normal.dot(a.velocity), vb = normal.dot(b.velocity);
  const double fastest_along = std::max({std::abs(va), std::abs(vb), std::abs(va - vb), a.struck, b.struck});
  const double fall = std::abs(normal.dot(settings.gravity)) * settings.step * settings.step;
  return settings.margin + settings.step * fastest_along + (a.turn_reach() + b.turn_reach()) + fall;
}

Vec3 approach_velocity(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  const double share = (a.dynamic ? 1 : 0) - (b.dynamic ? 1 : 0);
  return a.velocity - b.velocity + share * settings.step * settings.gravity;
}

double pair_margin(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  return settings.margin + settings.step * fastest(a, b) + (a.turn_reach() + b.turn_reach()) + std::max(a.fall, b.fall);
}

void collide_pair(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& m) {
  m.count = 0, m.time = 0;
  const double margin = pair_margin(a, b, settings);
  const bool has_plane = a.kind == ShapeKind::plane || b.kind == ShapeKind::plane;
  const double reach = a.radius + b.radius + margin;
  if (!has_plane && (a.position - b.position).squaredNorm() > reach * reach) return;

  const Cell cell = cell_of(a.kind, b.kind);
  const Proxy &first = cell.swapped ? b : a, &second = cell.swapped ? a : b;
  const double travel = settings.step * relative_speed(a, b);
  const double half_size = std::min(a.half_size, b.half_size);
  if (cell.sweep && travel > half_size)
    collide_fast(cell, first, second, margin, settings, m);
  else
    collide_at(cell, first, second, margin, settings, m);
  if (cell.sweep && m.count > 0 && m.time == 0 && travel > least_approach * half_size)
    leave_way(cell, first, second, margin, settings, m);
  if (cell.swapped) m.normal = -m.normal;
}

}  // namespace unibody
