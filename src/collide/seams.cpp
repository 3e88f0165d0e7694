#include "collide/seams.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "collide/convex_distance.hpp"
#include "collide/triangle_distance.hpp"
#include "world/hull.hpp"
#include "world/mesh_shape.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr double flush = 2e-3;               // of the smaller half size: what a step of a surface may be and not be felt
constexpr double flush_direction = 0.999;    // cosine between a plane and a face that lies in it
constexpr double same_direction = 1 - 1e-9;  // cosine

// One of the two solids of a manifold, seen from the other.
struct Side {
  const Proxy* part;                      // a convex solid, or a mesh
  const MeshSurface::Triangle* triangle;  // of the mesh
  Vec3 normal;                            // unit, from this solid to the other
  Vec3 points[PairManifold::capacity];    // m, world, on this solid's surface, at the step's start
};

// The gap between the solids at the manifold's time (m): 0 where they will first touch then.
double gap_at_its_time(const PairManifold& m, const ContactPoint& point) { return m.time > 0 ? 0 : point.gap; }

int nearest_of(const PairManifold& m) {
  int nearest = 0;
  for (int k = 1; k < m.count; ++k)
    if (m.points[k].gap < m.points[nearest].gap) nearest = k;
  return nearest;
}

double depth_of(const PairManifold& m) { return std::max(0.0, -m.points[nearest_of(m)].gap); }

Side side_of(const PairManifold& m, bool second) {
  Side side;
  side.part = second ? m.part_b : m.part_a;
  side.triangle = side.part->kind == ShapeKind::mesh ? m.triangle : nullptr;
  side.normal = second ? m.normal : Vec3(-m.normal);
  for (int k = 0; k < m.count; ++k)
    side.points[k] = m.points[k].position - 0.5 * gap_at_its_time(m, m.points[k]) * side.normal - m.time * side.part->velocity;
  return side;
}

Vec3 node_of(const Side& side, std::size_t k) {
  const MeshSurface& mesh = shape_library().meshes[side.part->data];
  return side.part->position + side.part->rotation * mesh.nodes[static_cast<std::size_t>(side.triangle->nodes[k])];
}

// How far a solid reaches in a direction (unit). m
double reach_of(const Side& side, const Vec3& direction) {
  if (side.triangle)
    return std::max({direction.dot(node_of(side, 0)), direction.dot(node_of(side, 1)), direction.dot(node_of(side, 2))});
  const Proxy& p = *side.part;
  if (p.kind == ShapeKind::plane) return HUGE_VAL;
  if (p.kind == ShapeKind::box) return direction.dot(p.position) + (p.rotation.transpose() * direction).cwiseAbs().dot(p.half);
  if (is_round(p.shape())) return direction.dot(p.position) + p.half.x();
  const ConvexBody body = convex_body(p.shape(), p.rotation, p.position);
  return direction.dot(body.support(direction)) + body.rounding;
}

// Calls f(normal, height) for the planes of the faces of a solid, until it returns true.
template <class F>
bool any_face(const Side& side, F&& f) {
  const Proxy& p = *side.part;
  if (side.triangle) {
    const Vec3 up = p.rotation * side.triangle->normal;
    return f(up, up.dot(node_of(side, 0)));
  }
  if (p.kind == ShapeKind::hull) {
    const Hull& hull = shape_library().hulls[p.data];
    return std::any_of(hull.faces.begin(), hull.faces.end(), [&](const Hull::Face& face) {
      const Vec3 up = p.rotation * face.normal;
      return f(up, up.dot(p.position) + face.normal.dot(hull.corners[hull.face_corners[face.first]]));
    });
  }
  if (p.kind != ShapeKind::box && p.kind != ShapeKind::cylinder) return false;
  for (int axis = p.kind == ShapeKind::box ? 0 : 2; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const Vec3 up = sign * p.rotation.col(axis);
      if (f(up, up.dot(p.position) + p.half[axis])) return true;
    }
  return false;
}

double flush_of(const Proxy& a, const Proxy& b) {
  const double size =
      std::min(a.kind == ShapeKind::mesh ? HUGE_VAL : a.half_size, b.kind == ShapeKind::mesh ? HUGE_VAL : b.half_size);
  return flush * size;
}

bool on_border(const MeshSurface::Triangle& t) { return *std::min_element(t.across.begin(), t.across.end()) < 0; }

// Whether the nearest point lies at the edge of a face of one solid that the other solid is wholly above: then the contact may be
// with the side next to that face. A face along the normal is the contact's own, of two faces that lie on each other also one
// that is tilted a little.
bool may_be_hidden(const PairManifold& m, bool second, double slack) {
  const Side side = side_of(m, second);
  const double own = m.count > 2 ? flush_direction : same_direction;
  if (side.part->kind == ShapeKind::mesh && (!side.triangle || !on_border(*side.triangle))) return false;
  std::optional<Side> other;
  return any_face(side, [&](const Vec3& up, double height) {
    if (up.dot(side.normal) > own) return false;
    if (up.dot(side.points[nearest_of(m)]) < height - slack) return false;
    if (!other) other = side_of(m, !second);
    return reach_of(*other, -up) <= slack - height;
  });
}

// The plane above which a contact keeps a body.
struct Plane {
  Vec3 normal = Vec3::Zero();  // unit, towards the body
  double height = HUGE_VAL;    // m
  double gap = HUGE_VAL;       // m, of the body's lowest point of contact
  bool doubtful = true;        // the contact may itself be with a hidden side
  bool is_near = false;        // the contact lies where the body may go in the step
  bool of_face = false;        // of the other solid, which rises from the seam; else of the contact with the third

  bool better_than(const Plane& other) const {
    return std::tie(of_face, doubtful, gap) < std::tie(other.of_face, other.doubtful, other.gap);
  }
};

Plane plane_of(const PairManifold& contact, bool of_second, const Proxy& third) {
  Plane plane;
  plane.normal = of_second ? Vec3(-contact.normal) : contact.normal;
  for (int k = 0; k < contact.count; ++k) {
    const ContactPoint& p = contact.points[k];
    plane.height =
        std::min(plane.height, plane.normal.dot(p.position - contact.time * third.velocity) - 0.5 * gap_at_its_time(contact, p));
    plane.gap = std::min(plane.gap, p.gap);
  }
  return plane;
}

class Mender {
 public:
  Mender(PairManifold& manifold, const CollideSettings& settings, KnownContacts& known)
      : m_(manifold), settings_(settings), known_(known) {}

  // Looks for a plane that hides the other solid in the contacts of one of the two with a third body. Of several the one counts
  // that is no hidden side itself, and then the one that is nearest to its body.
  void look(bool second, const Proxy& third) {
    const Proxy& body = second ? *m_.part_b : *m_.part_a;
    const bool third_first = third.id < body.id;
    const auto judge = [&](const PairManifold& contact) {
      Plane plane = plane_of(contact, third_first, third);
      if (!hides(plane, second) && !rises_from(plane, contact, third_first, second)) return;
      plane.doubtful = may_be_at_seam(contact, settings_);
      if (best_.gap != HUGE_VAL && !plane.better_than(best_)) return;
      plane.is_near = is_near(contact, body);
      best_ = plane, of_second_ = second;
    };
    third_first ? known_.each(third, body, settings_, judge) : known_.each(body, third, settings_, judge);
  }

  void mend() {
    if (best_.gap == HUGE_VAL) return;
    const Side side = side_of(m_, of_second_);  // the body above the plane
    const Proxy& body = *side.part;
    if (best_.of_face && (is_round(body.shape()) || m_.time > 0)) return touch_face(body);
    if (is_round(body.shape()) || m_.time > 0 || (rolls(body) && best_.is_near)) {
      m_.count = 0;
      return;
    }
    const Vec3& up = best_.normal;
    m_.normal = of_second_ ? Vec3(-up) : up;
    // A point that lies deeper than the body reaches belongs to one of its sides, which the search has extended as a plane.
    const double lowest = std::min(0.0, best_.gap) - flush_of(*m_.part_a, *m_.part_b);
    int count = 0;
    for (int k = 0; k < m_.count; ++k) {
      const double gap = up.dot(side.points[k]) - best_.height;
      if (gap >= lowest) m_.points[count++] = {side.points[k] - 0.5 * gap * up, gap, m_.points[k].feature};
    }
    m_.count = count;
    tidy(m_, margin_along(up, *m_.part_a, *m_.part_b, settings_));
  }

 private:
  // The other solid has a face in the plane, and the manifold is at its edge.
  bool hides(const Plane& plane, bool of_second) const {
    const Side side = side_of(m_, !of_second);
    if (plane.normal.dot(side.normal) > same_direction) return false;
    const double slack = flush_of(*m_.part_a, *m_.part_b), reach = reach_of(side, plane.normal);
    const double lowest = plane.height - slack + std::min(0.0, plane.gap);
    if (reach > plane.height + slack || reach < lowest) return false;
    const int nearest = nearest_of(m_);
    if (plane.normal.dot(side.points[nearest]) < lowest - depth_of(m_)) return false;
    return any_face(side, [&](const Vec3& up, double) { return up.dot(plane.normal) > flush_direction; });
  }

  // Where the other solid goes on from the third's surface at an angle, as a ramp does: its side under the seam is hidden by the
  // third, and what can be touched is its face there.
  bool rises_from(Plane& plane, const PairManifold& contact, bool third_first, bool of_second) const {
    const Side side = side_of(m_, !of_second), body = side_of(m_, of_second);
    const Vec3 across = side.normal - plane.normal * plane.normal.dot(side.normal);
    if (!(across.norm() > 1e-3)) return false;
    const double slack = flush_of(*m_.part_a, *m_.part_b);
    const int nearest = nearest_of(m_);
    const double reach = slack + depth_of(m_);
    const Vec3& point = side.points[nearest];
    const double over = plane.normal.dot(point) - plane.height;
    if (over > reach || over < std::min(0.0, plane.gap) - reach) return false;
    if (!contains(side_of(contact, !third_first), point + slack * across.normalized(), reach)) return false;
    return any_face(side, [&](const Vec3& up, double height) {
      if (up.dot(side.normal) > same_direction || up.dot(across) < 0 || up.dot(plane.normal) < 0.1) return false;
      if (up.dot(point) < height - reach || reach_of(body, -up) > reach - height) return false;
      plane.normal = up, plane.height = height, plane.of_face = true;
      plane.gap = -reach_of(body, -up) - height;
      return true;
    });
  }

  static bool contains(const Side& side, const Vec3& point, double slack) {
    const Proxy& p = *side.part;
    if (p.kind == ShapeKind::plane) return true;
    if (is_round(p.shape())) return false;
    if (p.kind == ShapeKind::cylinder) {
      const Vec3 local = p.rotation.transpose() * (point - p.position);
      if (local.head<2>().norm() > p.half.x() + slack) return false;
    } else if (side.triangle) {
      const TrianglePoint at = closest_on_triangle(point, node_of(side, 0), node_of(side, 1), node_of(side, 2));
      return at.distance <= slack;
    } else if (p.kind != ShapeKind::box && p.kind != ShapeKind::hull) {
      return false;
    }
    return !any_face(side, [&](const Vec3& up, double height) { return up.dot(point) > height + slack; });
  }

  // One point: the lowest over the face.
  void touch_face(const Proxy& body) {
    const Vec3& up = best_.normal;
    Vec3 lowest = body.position - body.half.x() * up;
    if (!is_round(body.shape())) {
      const ConvexBody solid = convex_body(body.shape(), body.rotation, body.position);
      lowest = solid.support(-up) - solid.rounding * up;
    }
    m_.normal = of_second_ ? Vec3(-up) : up, m_.time = 0, m_.count = 0;
    const double gap = up.dot(lowest) - best_.height;
    m_.add(lowest - 0.5 * gap * up, gap, 0);
    tidy(m_, margin_along(up, *m_.part_a, *m_.part_b, settings_));
  }

  // A round side has no corner that the plane must hold.
  static bool rolls(const Proxy& body) { return body.kind == ShapeKind::capsule || body.kind == ShapeKind::cylinder; }

  bool is_near(const PairManifold& contact, const Proxy& body) const {
    const Vec3& place = m_.points[nearest_of(m_)].position;
    const auto distance = [&](const Vec3& p, const Vec3& q) {
      const Vec3 along = q - p;
      const double t = along.dot(place - p) / std::max(along.squaredNorm(), 1e-300);
      return (p + std::clamp(t, 0.0, 1.0) * along - place).norm();
    };
    for (int i = 0; i < contact.count; ++i)
      for (int j = i; j < contact.count; ++j)
        if (distance(contact.points[i].position, contact.points[j].position) < body.half_size + settings_.step * body.speed)
          return true;
    return false;
  }

  PairManifold& m_;
  const CollideSettings& settings_;
  KnownContacts& known_;
  Plane best_;
  bool of_second_ = false;
};

bool may_collide(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  return (a.group < 0 || a.group != b.group) && (a.dynamic || b.dynamic) && settings.may_touch(a.id, b.id);
}

}  // namespace

bool may_be_at_seam(const PairManifold& m, const CollideSettings&) {
  if (!m.part_a || m.count == 0) return false;
  const bool of_mesh = m.part_a->kind == ShapeKind::mesh || m.part_b->kind == ShapeKind::mesh;
  if (of_mesh && !m.triangle) return false;                             // pushed out of all of it
  if (depth_of(m) > 10 * flush_of(*m.part_a, *m.part_b)) return false;  // deep in each other: nothing is flush
  const double slack = 4 * flush_of(*m.part_a, *m.part_b) + depth_of(m);
  return may_be_hidden(m, true, slack) || may_be_hidden(m, false, slack);
}

void mend_at_seam(PairManifold& m, const std::vector<const Proxy*>& thirds, const CollideSettings& settings,
                  KnownContacts& known) {
  if (!may_be_at_seam(m, settings)) return;
  Mender mender(m, settings, known);
  for (const bool second : {false, true}) {
    const Proxy& body = second ? *m.part_b : *m.part_a;
    if (body.kind == ShapeKind::mesh || body.kind == ShapeKind::plane) continue;
    for (const Proxy* third : thirds)
      if (third->id != body.id && may_collide(body, *third, settings)) mender.look(second, *third);
  }
  mender.mend();
}

}  // namespace unibody
