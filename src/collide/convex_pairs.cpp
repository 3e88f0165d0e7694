// Any two convex solids, and a convex solid over a plane.
//
// The normal is that of the distance (convex_distance.hpp), or of a face or a curved side where that separates nearly as well: a
// face gives a steadier manifold. The points are the corners of what both solids turn to each other, cut to where they lie over
// each other: two faces, a face and an edge, two edges that run along each other; each with its own gap along the normal. The
// nearest points come on top where no corner says as much.
#include "collide/convex_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "collide/convex_distance.hpp"
#include "collide/mesh_triangles.hpp"
#include "collide/shape_pairs.hpp"
#include "collide/sweep.hpp"
#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

constexpr std::uint32_t nearest_feature = 1u << 16;
constexpr double steepest = 0.3;          // cosine between the normal and a face that counts as turned to the other solid
constexpr double along_each_other = 0.1;  // sine of the angle between two edges

// m, what a face may separate less than the nearest points and still be the normal, of solids of a size.
double face_loss(double size, double gap) { return 5e-4 * size + 0.02 * std::abs(gap); }

// Height over the plane across the normal as a linear function of the place in it.
struct Height {
  double at_origin = 0, u = 0, v = 0;
  double operator()(double x, double y) const { return at_origin + u * x + v * y; }
};

// A corner in the plane across the normal, and the edges in which it lies.
struct Flat {
  double u, v;
  std::uint8_t in, out;
};

// What a solid turns to the other, seen along the normal.
struct Outline {
  int count = 0;
  Flat corners[2 * SupportFeature::capacity];
  Height height;  // m, of the solid's surface along the normal
};

struct Plane {
  Vec3 n, u, v;
};

Outline outline_of(const ConvexBody& body, const SupportFeature& feature, const Plane& plane, double outwards) {
  Outline result;
  Vec3 world[SupportFeature::capacity];
  for (int k = 0; k < feature.count; ++k) {
    world[k] = body.nodes ? feature.corners[k] : Vec3(body.centre + body.rotation * feature.corners[k]);
    result.corners[k] = {plane.u.dot(world[k]), plane.v.dot(world[k]),
                         static_cast<std::uint8_t>((k + feature.count - 1) % feature.count), static_cast<std::uint8_t>(k)};
  }
  result.count = feature.count;
  const Flat& first = result.corners[0];
  const double start = plane.n.dot(world[0]);
  if (feature.count >= 3) {
    const Vec3 m = body.rotation * feature.normal;
    const double slant = m.dot(plane.n);
    if (!(std::abs(slant) > steepest)) result.count = 1;
    result.height.u = -m.dot(plane.u) / slant, result.height.v = -m.dot(plane.v) / slant;
  } else if (feature.count == 2) {
    const Flat& second = result.corners[1];
    const double du = second.u - first.u, dv = second.v - first.v, squared = du * du + dv * dv;
    const double slope = squared > 0 ? (plane.n.dot(world[1]) - start) / squared : 0;
    if (!(slope * slope * squared < 4)) result.count = 1;  // it points at the other solid
    result.height.u = slope * du, result.height.v = slope * dv;
  }
  result.height.at_origin = start - result.height.u * first.u - result.height.v * first.v + outwards * body.rounding;
  if (outwards < 0 && result.count >= 3) {  // seen from behind
    std::reverse(result.corners, result.corners + result.count);
    for (int k = 0; k < result.count; ++k) std::swap(result.corners[k].in, result.corners[k].out);
  }
  return result;
}

// Keeps what lies to the left of the line from p to q (Sutherland-Hodgman); `open`: the outline is a segment.
void clip(Outline& outline, const Flat& p, const Flat& q, std::uint8_t label) {
  const auto beyond = [&](const Flat& x) { return (q.v - p.v) * (x.u - p.u) - (q.u - p.u) * (x.v - p.v); };
  const Outline from = outline;
  const int edges = from.count == 2 ? 1 : from.count;
  outline.count = 0;
  for (int i = 0; i < from.count; ++i) {
    const Flat &x = from.corners[i], &y = from.corners[i + 1 < from.count ? i + 1 : 0];
    const double bx = beyond(x), by = beyond(y);
    if (bx <= 0) outline.corners[outline.count++] = x;
    if (i >= edges || (bx <= 0) == (by <= 0)) continue;
    const double t = bx / (bx - by);
    Flat& c = outline.corners[outline.count++];
    c = {x.u + t * (y.u - x.u), x.v + t * (y.v - x.v), x.out, x.out};
    (bx <= 0 ? c.out : c.in) = label;
  }
}

void clip_by_polygon(Outline& outline, const Outline& by) {
  for (int k = 0; k < by.count && outline.count > 0; ++k)
    clip(outline, by.corners[k], by.corners[(k + 1) % by.count], static_cast<std::uint8_t>(128 + k));
}

// A face that is tilted out of the plane across the normal meets what runs along its foremost edge there, and nothing beside it:
// whether it is cut to just inside of the face or just outside would be a matter of rounding. Makes the face that edge where the
// segment runs along it. outwards: 1 where the normal leads out of the face's solid, else -1.
void turn_to_edge(Outline& face, const Outline& segment, double outwards) {
  constexpr double tilted = 0.02;
  if (!(std::hypot(face.height.u, face.height.v) > tilted)) return;
  int foremost = 0;
  double best = -HUGE_VAL;
  for (int k = 0; k < face.count; ++k) {
    const Flat &p = face.corners[k], &q = face.corners[(k + 1) % face.count];
    const double height = outwards * (face.height(p.u, p.v) + face.height(q.u, q.v));
    if (height > best) best = height, foremost = k;
  }
  const Flat p = face.corners[foremost], q = face.corners[(foremost + 1) % face.count];
  const double u = q.u - p.u, v = q.v - p.v;
  const double su = segment.corners[1].u - segment.corners[0].u, sv = segment.corners[1].v - segment.corners[0].v;
  if (std::abs(u * sv - v * su) > along_each_other * std::hypot(u, v) * std::hypot(su, sv)) return;
  face.count = 2, face.corners[0] = p, face.corners[1] = q;
}

// Two edges: the stretch of the first in which they run beside each other.
bool overlap_segments(Outline& a, const Outline& b) {
  const double au = a.corners[1].u - a.corners[0].u, av = a.corners[1].v - a.corners[0].v;
  const double bu = b.corners[1].u - b.corners[0].u, bv = b.corners[1].v - b.corners[0].v;
  const double la = std::sqrt(au * au + av * av), lb = std::sqrt(bu * bu + bv * bv);
  if (!(la > 0 && lb > 0) || std::abs(au * bv - av * bu) > along_each_other * la * lb) return false;
  const auto place = [&](const Flat& x) { return ((x.u - a.corners[0].u) * au + (x.v - a.corners[0].v) * av) / la; };
  const double s = place(b.corners[0]), t = place(b.corners[1]);
  const double from = std::max(0.0, std::min(s, t)), to = std::min(la, std::max(s, t));
  if (!(from <= to)) return false;
  const Flat start = a.corners[0];
  const auto at = [&](double x) { return Flat{start.u + x / la * au, start.v + x / la * av, 0, 0}; };
  a.corners[0] = at(from), a.corners[1] = at(to);
  a.corners[0].in = 0, a.corners[1].in = 1;
  return true;
}

// m, how much further apart two curved sides are at a place of the first that is not right over the second.
double curve_away(const Flat& place, const Outline& line, double radii) {
  const Flat &p = line.corners[0], &q = line.corners[1];
  const double u = q.u - p.u, v = q.v - p.v, across = u * (place.v - p.v) - v * (place.u - p.u);
  return across * across / ((u * u + v * v) * 2 * radii);
}

struct Manifolder {
  const ConvexBody &a, &b;
  double margin;
  PairManifold& out;
  bool edges_of_faces = false;  // what runs along the foremost edge of a tilted face touches that edge

  // Adds the corners across a normal; returns the smallest gap.
  double add(const Vec3& normal, const SupportFeature& of_a, const SupportFeature& of_b, double least) {
    Plane plane;
    plane.n = normal;
    plane.u = std::abs(normal.y()) < 0.7 ? Vec3(normal.z(), 0, -normal.x()) : Vec3(0, -normal.z(), normal.y());
    plane.u.normalize();
    plane.v = normal.cross(plane.u);
    Outline x = outline_of(a, of_a, plane, -1), y = outline_of(b, of_b, plane, 1);
    if (x.count < 2 || y.count < 2) return HUGE_VAL;
    if (edges_of_faces && x.count == 2 && y.count > 2) turn_to_edge(y, x, 1);
    if (edges_of_faces && y.count == 2 && x.count > 2) turn_to_edge(x, y, -1);
    const Height above = x.height, below = y.height;
    bool from_a = false;
    const bool edges = x.count == 2 && y.count == 2;
    if (edges) {
      if (!overlap_segments(x, y)) return HUGE_VAL;
      from_a = true;
    } else if (y.count >= 3) {
      clip_by_polygon(x, y), from_a = true;
    } else {
      clip_by_polygon(y, x);
    }
    const Outline& kept = from_a ? x : y;
    double smallest = HUGE_VAL;
    for (int k = 0; k < kept.count; ++k) {
      const Flat& c = kept.corners[k];
      const double high = above(c.u, c.v), low = below(c.u, c.v);
      double gap = std::max(high - low, least);
      if (edges) gap += curve_away(c, y, a.shape.size.x() + b.shape.size.x());
      if (!(gap <= margin)) continue;
      out.add(c.u * plane.u + c.v * plane.v + 0.5 * (high + low) * plane.n, gap, static_cast<std::uint32_t>(c.in) << 8 | c.out);
      smallest = std::min(smallest, gap);
    }
    return smallest;
  }
};

void feature_towards(const ConvexBody& body, const Vec3& direction, SupportFeature& feature) {
  feature.count = 0, feature.normal.setZero();
  body.functions->feature(body.shape, body.rotation.transpose() * direction, feature);
}

// Whether a triangle is what is nearest in its surroundings in the direction in which it was found: no neighbour rises towards
// the body, and of triangles that share the point this is the one that speaks for it, or any may. `behind`: on either side of it.
bool stands_out(const MeshTriangle& t, const ConvexDistance& found, bool any_speaks, bool behind = false) {
  constexpr double lean = 1e-6;
  const TrianglePoint at = closest_on_triangle(found.on_b, t.nodes[0], t.nodes[1], t.nodes[2]);
  if (found.normal.dot(t.normal) > 1 - 1e-6) return true;  // flat on it
  const auto rises = [&](std::size_t edge) {
    if (t.of->across[edge] < 0) return false;
    const Vec3 &from = t.nodes[edge], along = t.nodes[(edge + 1) % 3] - from;
    Vec3 inwards = t.across[edge] - from;
    inwards -= along * (along.dot(inwards) / along.squaredNorm());
    return found.normal.dot(inwards) > lean * inwards.norm();
  };
  // From a node the surface goes on along all of its edges, not those of this triangle and its neighbours alone.
  const auto rises_from = [&](std::size_t k) {
    const auto node = static_cast<std::size_t>(t.of->nodes[k]);
    const std::span ring(t.mesh->ring.data() + t.mesh->ring_begin[node], t.mesh->ring_begin[node + 1] - t.mesh->ring_begin[node]);
    return std::ranges::any_of(ring, [&](const MeshSurface::RingNode& other) {
      const Vec3 along = t.mesh->nodes[static_cast<std::size_t>(other.node)] - t.origin - t.nodes[k];
      return other.patch == t.of->patch && found.normal.dot(along) > lean * along.norm();
    });
  };
  const auto normal_over = [&](std::size_t edge) -> Vec3 {
    if (t.of->across[edge] < 0) return Vec3::Zero();
    return (t.across[edge] - t.nodes[edge]).cross(t.nodes[(edge + 1) % 3] - t.nodes[edge]).normalized();
  };
  constexpr double on = 1e-6;  // weight of a corner that does not count
  for (std::size_t k = 0; k < 3; ++k) {
    const auto w = [&](std::size_t i) { return at.weights[static_cast<Eigen::Index>(i % 3)]; };
    const std::size_t before = (k + 2) % 3;
    if (w(k) > 1 - on)
      return (any_speaks || t.of->speaks_for_node[k]) && !rises_from(k) &&
             (behind || found.normal.dot(t.normal + normal_over(k) + normal_over(before)) > 0);
    if (w(before) <= on && w(k) > on && w(k + 1) > on)
      return (any_speaks || t.of->speaks_for_edge[k]) && !rises(k) && (behind || found.normal.dot(t.normal + normal_over(k)) > 0);
  }
  return behind || found.normal.dot(t.normal) > 0;
}

// Adds the nearest points of the body and a triangle to their manifold, unless a corner that is in it has nearly as small a gap.
void add_nearest_unless_said(const ConvexBody& body, Cores cores, const ConvexDistance& distance, double least,
                             PairManifold& out) {
  if (cores != Cores::apart || least <= distance.gap + face_loss(body.size, distance.gap)) return;
  if (out.count == 0) out.normal = distance.normal;
  out.add(0.5 * (distance.on_a + distance.on_b), distance.gap, nearest_feature);
}

}  // namespace

// a stands at the origin.
bool convex_manifold(const ConvexBody& a, const ConvexBody& b, double margin, PairManifold& out) {
  ConvexDistance distance;
  if (!convex_distance(a, b, margin, distance)) return false;
  SupportFeature of_a, of_b;
  feature_towards(a, -distance.normal, of_a), feature_towards(b, distance.normal, of_b);
  Vec3 normal = distance.normal;
  double gap = distance.gap;
  bool snapped = false;
  const double smallest = std::min(a.size, b.size);
  double threshold = gap - face_loss(smallest, gap);
  const auto try_normal = [&](const Vec3& n) {
    const double along = gap_along(a, b, n);
    if (along > threshold) normal = n, gap = along, snapped = true, threshold = along + 1e-4 * smallest;
  };
  if (of_a.count >= 3) try_normal(-(a.rotation * of_a.normal));
  if (of_b.count >= 3) try_normal(b.rotation * of_b.normal);
  if (!snapped && of_a.count == 2 && of_a.normal != Vec3::Zero()) try_normal(-(a.rotation * of_a.normal));
  if (!snapped && of_b.count == 2 && of_b.normal != Vec3::Zero()) try_normal(b.rotation * of_b.normal);
  if (snapped) feature_towards(a, -normal, of_a), feature_towards(b, normal, of_b);

  Manifolder manifolder{a, b, margin, out, true};
  const double least = manifolder.add(normal, of_a, of_b, gap);
  if (snapped && out.count == 0) normal = distance.normal, gap = distance.gap, snapped = false;
  out.normal = normal;
  const double snapped_least = gap > 0 ? gap + face_loss(smallest, gap) : 0;
  const bool said = out.count > 0 && least <= (snapped ? snapped_least : gap + 1e-6 * smallest);
  if (!said) out.add(0.5 * (distance.on_a + distance.on_b), gap, nearest_feature);
  return out.count > 0;
}

bool triangle_manifold(const ConvexBody& body, const MeshTriangle& triangle, double margin, PairManifold& out) {
  const Vec3& up = triangle.normal;
  const bool in_front = up.dot(body.centre - triangle.nodes[0]) > 0;
  const auto speaks = [](const std::array<bool, 3>& for_it) { return for_it[0] || for_it[1] || for_it[2]; };
  if (!in_front && !speaks(triangle.of->speaks_for_edge) && !speaks(triangle.of->speaks_for_node)) return false;
  const ConvexBody face = convex_triangle(triangle.nodes, body.size);
  ConvexDistance distance;
  const Cores cores = distance_of_cores(body, face, margin, distance);
  if (cores == Cores::far || (cores == Cores::together && !in_front)) return false;
  double gap = gap_along(body, face, up);
  Vec3 normal = up;
  if (cores == Cores::apart) {
    if (!stands_out(triangle, distance, false)) return false;
    const bool flat = gap > distance.gap - face_loss(body.size, distance.gap);
    if (!flat) normal = distance.normal, gap = distance.gap;
  }
  SupportFeature of_body, of_face;
  feature_towards(body, -normal, of_body);
  for (const Vec3& node : triangle.nodes) of_face.add(node);
  of_face.normal = up;
  const double least = Manifolder{body, face, margin, out}.add(normal, of_body, of_face, gap);
  out.normal = normal;
  add_nearest_unless_said(body, cores, distance, least, out);
  if (out.count > 0 || cores == Cores::apart) return out.count > 0;
  // an edge or corner has gone in beside all that is over the triangle: out by the shortest way that no neighbour bars
  if (!convex_distance(body, face, margin, distance) || !stands_out(triangle, distance, true)) return false;
  out.normal = distance.normal;
  out.add(0.5 * (distance.on_a + distance.on_b), distance.gap, nearest_feature);
  return true;
}

bool has_no_nearer_neighbour(const ConvexBody& body, const MeshTriangle& triangle, double margin, ConvexDistance& nearest) {
  if (distance_of_cores(body, convex_triangle(triangle.nodes, body.size), margin, nearest) != Cores::apart) return false;
  return stands_out(triangle, nearest, true, true);
}

bool sheet_manifold(const ConvexBody& body, const std::array<Vec3, 3>& triangle, double margin, PairManifold& out) {
  Vec3 up = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
  const double length = up.norm();
  const bool flat_triangle = length > 0;
  if (flat_triangle) up /= up.dot(body.centre - triangle[0]) < 0 ? -length : length;
  const ConvexBody face = convex_triangle(triangle, body.size);
  ConvexDistance distance;
  const Cores cores = distance_of_cores(body, face, margin, distance);
  if (cores == Cores::far || (cores == Cores::together && !flat_triangle)) return false;
  const double along = flat_triangle ? gap_along(body, face, up) : -HUGE_VAL;
  const bool flat = cores == Cores::together || along > distance.gap - face_loss(body.size, distance.gap);
  out.normal = flat ? up : distance.normal;
  SupportFeature of_body, of_face;
  feature_towards(body, -out.normal, of_body);
  for (const Vec3& node : triangle) of_face.add(node);
  if (up.dot((triangle[1] - triangle[0]).cross(triangle[2] - triangle[0])) < 0) std::swap(of_face.corners[1], of_face.corners[2]);
  of_face.normal = up;
  const double gap = flat ? along : distance.gap;
  const double least = flat_triangle ? Manifolder{body, face, margin, out}.add(out.normal, of_body, of_face, gap) : HUGE_VAL;
  add_nearest_unless_said(body, cores, distance, least, out);
  return out.count > 0;
}

void convex_convex(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  convex_manifold(convex_body(a.shape(), a.rotation, Vec3::Zero()), convex_body(b.shape(), b.rotation, b.position - a.position),
                  settings.margin, out);
}

bool half_space_manifold(const ConvexBody& body, const Vec3& on_plane, const Vec3& normal, double margin, PairManifold& out) {
  out.normal = normal;
  const double height = -normal.dot(on_plane) - body.rounding;
  SupportFeature feature;
  feature_towards(body, -normal, feature);
  double least = HUGE_VAL;
  const auto add = [&](const Vec3& on_core, std::uint32_t number) {
    const double gap = height + normal.dot(on_core);
    least = std::min(least, gap);
    if (gap <= margin) out.add(on_core - (body.rounding + 0.5 * gap) * normal, gap, number);
  };
  for (int k = 0; k < feature.count; ++k) add(body.centre + body.rotation * feature.corners[k], static_cast<std::uint32_t>(k));
  const Vec3 lowest = body.support(-normal);
  if (height + normal.dot(lowest) < least - 1e-9 * body.size) add(lowest, nearest_feature);
  return out.count > 0;
}

void convex_plane(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  half_space_manifold(convex_body(a.shape(), a.rotation, Vec3::Zero()), b.position - a.position, b.rotation.col(2),
                      settings.margin, out);
}

// The distance of two convex bodies that move along a line is a convex function of time: as for a sphere and a box.
Sweep sweep_convex(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact) {
  ConvexBody moving = convex_body(a.shape(), a.rotation, a.position - b.position);
  const ConvexBody other = convex_body(b.shape(), b.rotation, Vec3::Zero());
  const Vec3 start = moving.centre;
  const double close = 1e-6 * std::min(moving.size, other.size), furthest = (start.norm() + a.radius + b.radius) * 4;
  for (int i = 0; i < 64; ++i) {
    moving.centre = start + impact.time * velocity;
    ConvexDistance distance;
    if (!convex_distance(moving, other, furthest, distance)) return Sweep::miss;
    if (distance.gap <= close) return i == 0 ? Sweep::overlap : Sweep::hit;
    const double closing = -distance.normal.dot(velocity);
    if (closing <= 0) return Sweep::miss;
    impact.time += distance.gap / closing;
    if (!(impact.time <= limit)) return Sweep::miss;
  }
  return Sweep::hit;
}

}  // namespace unibody
