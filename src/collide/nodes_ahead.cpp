#include "collide/nodes_ahead.hpp"

#include <algorithm>

#include "collide/convex_distance.hpp"
#include "collide/narrowphase.hpp"

namespace unibody {

namespace {

// The nearest unit vector to another that leans over none of the given ones; none where there is none within 60 degrees, as in a
// fold: {0, 0, 0}.
Vec3 levelled(const Vec3& direction, const std::vector<Vec3>& neighbours) {
  constexpr int sweeps = 16;  // of projections on one half space after the other, which come to one on all of them
  constexpr double least_length = 0.5, no_lean = 1e-12, most_lean = 1e-3;
  Vec3 level = direction;
  bool leans = true;
  for (int sweep = 0; sweep < sweeps && leans; ++sweep) {
    leans = false;
    for (const Vec3& to : neighbours)
      if (const double lean = to.dot(level); lean > no_lean) level -= lean * to, leans = true;
  }
  const double length = level.norm();
  const bool found = std::ranges::none_of(neighbours, [&](const Vec3& to) { return to.dot(level) > most_lean * length; });
  return found && length > least_length ? Vec3(level / length) : Vec3(Vec3::Zero());
}

// m, how far a body reaches against a direction, from its centre.
double reach_against(const Proxy& body, const Vec3& direction) {
  if (is_round(body.shape())) return body.half.x();
  double reach = 0;
  const auto note = [&](const Proxy& part) {
    const ConvexBody solid = convex_body(part.shape(), part.rotation, part.position - body.position);
    reach = std::max(reach, solid.rounding - direction.dot(solid.support(-direction)));
  };
  body.kind == ShapeKind::compound ? for_each_part(body, note) : note(body);
  return reach;
}

class Ahead {
 public:
  Ahead(const World& world, const Surfaces& surfaces, const CollideSettings& settings, const Contacts& contacts)
      : world_(world), surfaces_(surfaces), settings_(settings), contacts_(contacts) {}

  // Whether the contact is one of a node ahead of a body.
  bool operator()(const Manifold& m) {
    const bool first = surfaces_.is_node(m.slot_a);
    if (first == surfaces_.is_node(m.slot_b) || m.count != 1 || m.time > 0) return false;
    const Slot node = first ? m.slot_a : m.slot_b, body = first ? m.slot_b : m.slot_a;
    const ShapeKind kind = world_.properties[static_cast<std::size_t>(body)].shape.kind;
    if (kind == ShapeKind::plane || kind == ShapeKind::mesh) return false;
    const ContactPoint& point = contacts_.points[m.first];
    const Vec3 towards = first ? Vec3(-m.normal) : m.normal;  // from the node to the body
    const Vec3 on_body = point.position + 0.5 * point.gap * towards;
    const Vec3 approach = velocity_at(node, on_body) - velocity_at(body, on_body);
    if (!(point.gap > 0 && settings_.step * towards.dot(approach) > point.gap)) return false;

    find_neighbours(node);
    if (std::ranges::none_of(neighbours_, [&](const Vec3& to) { return to.dot(towards) > least_lean; })) return false;
    const Vec3 level = levelled(towards, neighbours_);
    if (level.isZero(0)) return false;
    const Proxy proxy = make_proxy(world_, static_cast<std::size_t>(body), settings_);
    const double radius = world_.properties[static_cast<std::size_t>(node)].shape.size.x();
    const double gap = level.dot(proxy.position - place(node)) - reach_against(proxy, level) - radius;
    return gap > -most_overlap * radius && level.dot(approach) < most_closing * towards.dot(approach);
  }

 private:
  static constexpr double least_lean = 1e-9;   // as a sine
  static constexpr double most_closing = 0.1;  // along the surface's own direction, over that along the distance
  static constexpr double most_overlap = 0.1;  // of the node's radius: what lies on a cloth overlaps it by the solve's tolerance

  Vec3 place(Slot s) const { return world_.position[static_cast<std::size_t>(s)]; }
  Vec3 velocity_at(Slot s, const Vec3& at) const {
    const auto i = static_cast<std::size_t>(s);
    return world_.velocity[i] + world_.angular_velocity_of(i).cross(at - world_.position[i]);
  }
  void find_neighbours(Slot node) {
    neighbours_.clear();
    for (const Slot next : surfaces_.ring(node)) {
      const Vec3 to = place(next) - place(node);
      if (const double length = to.norm(); length > 0) neighbours_.emplace_back(to / length);
    }
  }

  const World& world_;
  const Surfaces& surfaces_;
  const CollideSettings& settings_;
  const Contacts& contacts_;
  std::vector<Vec3> neighbours_;  // unit vectors from the node to those that share an edge with it
};

}  // namespace

void leave_out_nodes_ahead(const World& world, const Surfaces& surfaces, const CollideSettings& settings, Contacts& contacts) {
  Ahead is_ahead(world, surfaces, settings, contacts);
  if (std::ranges::none_of(contacts.manifolds, std::ref(is_ahead))) return;
  leave_out(contacts, std::ref(is_ahead));
}

}  // namespace unibody
