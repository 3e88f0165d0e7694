#include "collide/convex_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

// A point of the difference a - b, and where it comes from.
struct Vertex {
  Vec3 w, a, b;
};

Vertex furthest(const ConvexBody& a, const ConvexBody& b, const Vec3& direction) {
  Vertex v;
  v.a = a.support(direction), v.b = b.support(-direction);
  v.w = v.a - v.b;
  return v;
}

// Up to four vertices, with the weights of their point nearest to the origin.
struct Simplex {
  Vertex v[4];
  double weight[4];
  int count = 0;

  Vec3 point() const {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < count; ++i) sum += weight[i] * v[i].w;
    return sum;
  }
  void keep_weighted() {
    int kept = 0;
    for (int i = 0; i < count; ++i)
      if (weight[i] > 0) v[kept] = v[i], weight[kept++] = weight[i];
    count = kept;
  }
  // Leaves the vertices that the nearest point needs; false where the origin is inside.
  bool reduce();
};

bool Simplex::reduce() {
  const Vec3 origin = Vec3::Zero();
  if (count == 1) {
    weight[0] = 1;
  } else if (count == 2) {
    weight[1] = closest_on_segment(origin, v[0].w, v[1].w);
    weight[0] = 1 - weight[1];
  } else if (count == 3) {
    const TrianglePoint near = closest_on_triangle(origin, v[0].w, v[1].w, v[2].w);
    for (int i = 0; i < 3; ++i) weight[i] = near.weights[i];
  } else {
    constexpr int faces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    double nearest = HUGE_VAL, best[4] = {};
    for (const auto& f : faces) {
      const Vec3 &p = v[f[0]].w, &q = v[f[1]].w, &r = v[f[2]].w;
      const Vec3 n = (q - p).cross(r - p);
      const double own = n.dot(v[f[3]].w - p), other = -n.dot(p);
      if (own * other > 0 && std::abs(own) > 1e-14 * n.norm() * (v[f[3]].w - p).norm()) continue;  // on the inner side
      const TrianglePoint near = closest_on_triangle(origin, p, q, r);
      if (near.distance >= nearest) continue;
      nearest = near.distance;
      std::fill(best, best + 4, 0.0);
      for (int i = 0; i < 3; ++i) best[f[i]] = near.weights[i];
    }
    if (nearest == HUGE_VAL) return false;
    std::copy(best, best + 4, weight);
  }
  keep_weighted();
  return true;
}

// The face of the difference that is nearest to the origin from inside, by an inner polytope that grows towards it.
class Expansion {
 public:
  Expansion(const ConvexBody& a, const ConvexBody& b, double scale) : a_(a), b_(b), scale_(scale) {}

  void run(ConvexDistance& result) {
    start();
    Face best = faces_[0];
    double least = HUGE_VAL;  // m, of the depths along the normals so far: what a polytope that gets no further has found
    for (int i = 0; i < 200; ++i) {
      const std::size_t number = nearest();
      const Face face = faces_[number];
      if (face.offset == HUGE_VAL) break;
      const Vertex w = rounded(face.normal);
      const double depth = face.normal.dot(w.w);
      if (depth < least) least = depth, best = face;
      if (!(depth - face.offset > 1e-10 * scale_)) break;
      if (face.offset >= 0) inside_ = face.offset;
      if (!grow(w, 1e-13 * scale_) && !grow(w, 1e-10 * scale_)) faces_[number].offset = HUGE_VAL;  // others may say more
    }
    finish(best, result);
  }

 private:
  static constexpr std::size_t most_faces = 1000;
  static constexpr double same_face = 1 - 1e-8;  // cosine between normals
  struct Face {
    std::array<std::uint16_t, 3> corners;
    Vec3 normal;
    double offset;
  };

  // The vertex of the whole solids, their rounding included: the cores alone may have no volume.
  Vertex rounded(const Vec3& direction) const {
    const Vec3 unit = direction.normalized();
    Vertex v;
    v.a = a_.support(unit) + a_.rounding * unit, v.b = b_.support(-unit) - b_.rounding * unit;
    v.w = v.a - v.b;
    return v;
  }

  void start() {
    Vertex best[4];
    double most = -1;
    for (int k = 0; k < 3; ++k) {
      const Vertex p = rounded(Vec3::Unit(k)), q = rounded(-Vec3::Unit(k));
      if (const double length = (p.w - q.w).norm(); length > most) most = length, best[0] = p, best[1] = q;
    }
    const Vec3 along = (best[1].w - best[0].w).normalized();
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(along[k]) < std::abs(along[least])) least = k;
    const Vec3 u = along.cross(Vec3::Unit(least)).normalized(), v = along.cross(u);
    most = -1;
    for (const Vec3& d : {u, Vec3(-u), v, Vec3(-v)}) {
      const Vertex p = rounded(d);
      const Vec3 off = p.w - best[0].w - along * along.dot(p.w - best[0].w);
      if (off.norm() > most) most = off.norm(), best[2] = p;
    }
    const Vec3 n = along.cross(best[2].w - best[0].w).normalized();
    const Vertex up = rounded(n), down = rounded(-n);
    const double above = n.dot(up.w - best[0].w), below = n.dot(best[0].w - down.w);
    best[3] = above >= below ? up : down;
    if (above < below) std::swap(best[1], best[2]);
    vertices_ = {best[0], best[1], best[2], best[3]};
    for (const auto& f : {std::array<std::uint16_t, 3>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) add(f);
  }

  void add(const std::array<std::uint16_t, 3>& c) {
    const Vec3 &p = vertices_[c[0]].w, &q = vertices_[c[1]].w, &r = vertices_[c[2]].w;
    Vec3 n = (q - p).cross(r - p);
    const double length = n.norm();
    const bool flat = !(length > 1e-14 * scale_ * scale_);
    n = flat ? Vec3(Vec3::Zero()) : Vec3(n / length);
    // a polytope around the origin only grows: what is nearer than its nearest face was is a sliver with a normal of rounding
    const bool wrong = !flat && n.dot(p) < inside_ - 1e-10 * scale_;
    faces_.push_back({c, wrong ? Vec3(Vec3::Zero()) : n, flat || wrong ? HUGE_VAL : n.dot(p)});
  }

  std::size_t nearest() const {
    std::size_t best = 0;
    for (std::size_t k = 1; k < faces_.size(); ++k)
      if (faces_[k].offset < faces_[best].offset) best = k;
    return best;
  }

  // Takes out the faces that the new vertex sees, by more than `rounding` (m) in front of them, and closes the hole around it.
  // False, with nothing changed, where it sees none or there is no such hole.
  bool grow(const Vertex& w, double rounding) {
    edges_.clear();
    const auto seen = [&](const Face& f) { return f.normal.dot(w.w) - f.offset > rounding; };
    for (const Face& f : faces_)
      if (seen(f))
        for (std::size_t k = 0; k < 3; ++k) edges_.push_back({f.corners[k], f.corners[(k + 1) % 3]});
    horizon_.clear();
    for (const auto& [i, j] : edges_) {
      if (std::find(edges_.begin(), edges_.end(), std::array{j, i}) != edges_.end()) continue;
      const std::array edge{i, j};
      // twice: rounding has torn the polytope, and it would double with every vertex from here on
      if (std::find(horizon_.begin(), horizon_.end(), edge) != horizon_.end()) return false;
      horizon_.push_back(edge);
    }
    if (horizon_.size() < 3 || faces_.size() > most_faces) return false;
    std::erase_if(faces_, seen);
    const auto number = static_cast<std::uint16_t>(vertices_.size());
    vertices_.push_back(w);
    for (const auto& [i, j] : horizon_) add({i, j, number});
    return true;
  }

  void finish(const Face& face, ConvexDistance& result) const {
    const Vec3 n = face.normal;
    result.normal = -n;  // a - b must move along -n to be clear of the origin
    result.gap = -n.dot(rounded(n).w);
    // A face of the difference of two edges, or of a face and what is flat on it, has more than three corners, and is several
    // triangles here: only in one of them lies the point of it that is nearest to the origin.
    double least = HUGE_VAL;
    const auto look_at = [&](const Face& f) {
      const Vertex &p = vertices_[f.corners[0]], &q = vertices_[f.corners[1]], &r = vertices_[f.corners[2]];
      const TrianglePoint near = closest_on_triangle(face.offset * n, p.w, q.w, r.w);
      if (!(near.distance < least)) return;
      least = near.distance;
      result.on_a = near.weights[0] * p.a + near.weights[1] * q.a + near.weights[2] * r.a;
      result.on_b = near.weights[0] * p.b + near.weights[1] * q.b + near.weights[2] * r.b;
    };
    look_at(face);
    for (const Face& f : faces_)
      if (f.normal.dot(n) > same_face) look_at(f);
  }

  const ConvexBody &a_, &b_;
  double scale_;
  double inside_ = -HUGE_VAL;  // m, offset of the face that was nearest, once the origin is inside
  std::vector<Vertex> vertices_;
  std::vector<Face> faces_;
  std::vector<std::array<std::uint16_t, 2>> edges_, horizon_;
};

}  // namespace

ConvexBody convex_body(const Shape& shape, const Mat3& rotation, const Vec3& centre) {
  const ConvexFunctions* functions = type_of(shape.kind).convex;
  ConvexBody body;
  body.shape = shape, body.functions = functions, body.rotation = rotation, body.centre = centre;
  body.rounding = functions->rounding(shape), body.size = smallest_size(shape);
  return body;
}

ConvexBody convex_triangle(const std::array<Vec3, 3>& nodes, double size) {
  ConvexBody body;
  body.nodes = nodes.data(), body.size = size;
  body.centre = (nodes[0] + nodes[1] + nodes[2]) / 3;  // only to begin with
  return body;
}

Cores distance_of_cores(const ConvexBody& a, const ConvexBody& b, double margin, ConvexDistance& result) {
  const double scale = std::min(a.size, b.size), radii = a.rounding + b.rounding, reach = margin + radii;
  const double touching = 1e-10 * scale;
  Simplex simplex;
  Vec3 v = a.centre - b.centre;
  if (!(v.squaredNorm() > 0)) v = Vec3::UnitZ();
  double best = HUGE_VAL;
  for (int i = 0; i < 100; ++i) {
    const double length = v.norm();
    if (length <= touching) return Cores::together;
    const Vertex w = furthest(a, b, -v / length);
    const double lower = w.w.dot(v) / length;
    if (lower > reach) return Cores::far;
    if (i > 0 && length - lower <= 1e-12 * scale + 1e-10 * length) break;
    bool known = false;
    for (int k = 0; k < simplex.count; ++k) known |= simplex.v[k].w == w.w;
    if (known) break;
    const Simplex before = simplex;
    simplex.v[simplex.count++] = w;
    if (!simplex.reduce()) return Cores::together;
    const Vec3 next = simplex.point();
    const double squared = next.squaredNorm();
    if (!(squared < best)) {  // rounding: no nearer
      simplex = before;
      break;
    }
    best = squared, v = next;
  }
  const double length = v.norm();
  if (length <= touching) return Cores::together;
  result.normal = v / length, result.gap = length;
  result.on_a = result.on_b = Vec3::Zero();
  for (int i = 0; i < simplex.count; ++i)
    result.on_a += simplex.weight[i] * simplex.v[i].a, result.on_b += simplex.weight[i] * simplex.v[i].b;
  result.gap -= radii;
  result.on_a -= a.rounding * result.normal, result.on_b += b.rounding * result.normal;
  return result.gap <= margin ? Cores::apart : Cores::far;
}

bool convex_distance(const ConvexBody& a, const ConvexBody& b, double margin, ConvexDistance& result) {
  const Cores cores = distance_of_cores(a, b, margin, result);
  if (cores == Cores::together) Expansion(a, b, std::min(a.size, b.size)).run(result);
  return cores != Cores::far;
}

double gap_along(const ConvexBody& a, const ConvexBody& b, const Vec3& normal) {
  return normal.dot(a.support(-normal) - b.support(normal)) - a.rounding - b.rounding;
}

}  // namespace unibody
