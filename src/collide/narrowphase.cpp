#include "collide/narrowphase.hpp"

#include <algorithm>
#include <cmath>

#include "collide/shape_pairs.hpp"

namespace unibody {

namespace {

using Function = void (*)(const Proxy&, const Proxy&, const PairSettings&, PairManifold&);

void none(const Proxy&, const Proxy&, const PairSettings&, PairManifold&) {}

void two_boxes(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  settings.planar ? box_box_planar(a, b, settings, out) : box_box(a, b, settings, out);
}

struct Cell {
  Function function;
  bool swapped = false;  // the function takes b first
};

// Rows and columns in the order of ShapeKind.
constexpr Cell table[4][4] = {
    /* sphere */ {{round_round}, {round_box}, {round_plane}, {round_round}},
    /* box    */ {{round_box, true}, {two_boxes}, {box_plane}, {round_box, true}},
    /* plane  */ {{round_plane, true}, {box_plane, true}, {none}, {round_plane, true}},
    /* disc   */ {{round_round}, {round_box}, {round_plane}, {round_round}},
};

// Drops points beyond the margin, keeps at most 8 of them, and puts them in the order of their features.
void tidy(PairManifold& m, double margin) {
  ContactPoint* p = m.points;
  m.count = static_cast<int>(std::remove_if(p, p + m.count, [&](const ContactPoint& q) { return !(q.gap <= margin); }) - p);
  std::sort(p, p + m.count, [](const ContactPoint& a, const ContactPoint& b) { return a.feature < b.feature; });
  m.count = static_cast<int>(
      std::unique(p, p + m.count, [](const ContactPoint& a, const ContactPoint& b) { return a.feature == b.feature; }) - p);
  while (m.count > PairManifold::kept) {  // of the two points that are nearest to each other, the shallower goes
    int remove = 0;
    double nearest = HUGE_VAL;
    for (int i = 0; i < m.count; ++i)
      for (int j = i + 1; j < m.count; ++j) {
        const double d = (p[i].position - p[j].position).squaredNorm();
        if (d < nearest) nearest = d, remove = p[j].gap >= p[i].gap ? j : i;
      }
    std::move(p + remove + 1, p + m.count, p + remove);
    --m.count;
  }
}

}  // namespace

Proxy make_proxy(const World& world, std::size_t slot, const CollideSettings& settings) {
  const BodyProperties& body = world.properties[slot];
  Proxy p;
  p.position = world.position[slot];
  if (settings.planar) p.position.y() = 0;
  p.velocity = world.velocity[slot];
  p.rotation = world.orientation[slot].toRotationMatrix();
  p.kind = body.shape.kind;
  p.half = p.kind == ShapeKind::box ? body.shape.size : Vec3::Constant(body.shape.size.x());
  p.radius = p.kind == ShapeKind::plane ? 0 : bounding_radius(body.shape);
  p.speed = p.velocity.norm();
  p.spin_reach = p.kind == ShapeKind::box ? settings.step * p.radius * world.angular_velocity[slot].norm() : 0;
  p.half_size = p.half.minCoeff();
  if (settings.planar && p.kind == ShapeKind::box) p.half_size = std::min(p.half.x(), p.half.z());
  p.home = slot < world.homes;
  p.dynamic = body.is_dynamic();
  p.material = body.material;
  p.slot = static_cast<Slot>(slot);
  p.id = world.id[slot];
  return p;
}

double pair_margin(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  const double speed = std::max(std::max(a.speed, b.speed), (a.velocity - b.velocity).norm());
  const double fall = settings.gravity.norm() * settings.step * settings.step;
  return settings.margin + settings.step * speed + (a.spin_reach + b.spin_reach) + fall;
}

void collide_pair(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& m) {
  m.count = 0;
  const double margin = pair_margin(a, b, settings);
  const bool has_plane = a.kind == ShapeKind::plane || b.kind == ShapeKind::plane;
  const double reach = a.radius + b.radius + margin;
  if (!has_plane && (a.position - b.position).squaredNorm() > reach * reach) return;

  const Cell& cell = table[static_cast<int>(a.kind)][static_cast<int>(b.kind)];
  const Proxy &first = cell.swapped ? b : a, &second = cell.swapped ? a : b;
  cell.function(first, second, {margin, settings.planar}, m);
  if (m.count == 0) return;
  tidy(m, margin);
  for (int i = 0; i < m.count; ++i) m.points[i].position += first.position;
  if (cell.swapped) m.normal = -m.normal;
}

}  // namespace unibody
