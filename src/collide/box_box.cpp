// Box against box: separating axes, then clipping of the incident face by the sides of the reference face.
//
// An edge axis gives its own point AND the clipped faces, all with the edge's normal: a single point under a box that lies
// almost flat is a pivot about which it spins into its neighbour. The price is about 10 % more points.
#include "collide/box_box.hpp"

#include <algorithm>
#include <cmath>

#include "collide/box_edges.hpp"
#include "collide/shape_pairs.hpp"

namespace unibody {

namespace {

constexpr double parallel = 1e-6;  // sin^2 of the angle below which two edges span no axis

double smallest_half(const Vec3& a, const Vec3& b) { return std::min(a.minCoeff(), b.minCoeff()); }

double sign_of(double x) { return x < 0 ? -1.0 : 1.0; }

// A corner of the clipped polygon in the reference face's (u, v), with its height along the reference normal. It lies where
// the edges `in` and `out` meet: 0..3 are the incident face's edges, 4..7 the reference face's sides.
struct Corner {
  double u, v, height;
  std::uint8_t in, out;
};

struct Polygon {
  Corner corner[12];
  int count = 0;
};

// Keeps what has side * (u or v) <= limit (Sutherland-Hodgman).
template <double Corner::*coordinate>
void clip(Polygon& polygon, double side, double limit, std::uint8_t label) {
  const Polygon from = polygon;
  polygon.count = 0;
  double beyond_p = side * from.corner[0].*coordinate - limit;
  for (int i = 0; i < from.count; ++i) {
    const Corner& p = from.corner[i];
    const Corner& q = from.corner[i + 1 < from.count ? i + 1 : 0];
    const double beyond_q = side * q.*coordinate - limit;
    const bool keep = beyond_p <= 0;
    if (keep) polygon.corner[polygon.count++] = p;
    if (keep != (beyond_q <= 0)) {
      const double t = beyond_p / (beyond_p - beyond_q);
      Corner& c = polygon.corner[polygon.count++];
      c = {p.u + t * (q.u - p.u), p.v + t * (q.v - p.v), p.height + t * (q.height - p.height), p.out, p.out};
      (keep ? c.out : c.in) = label;
      c.*coordinate = side * limit;
    }
    beyond_p = beyond_q;
  }
}

// The frame of a reference box X and the other box Y in it.
struct Frame {
  const Proxy *x, *y;
  Vec3 columns[3];  // y's axes
  Vec3 centre;      // y's centre
  bool x_is_b;
};

Frame frame_of(const Proxy& a, const Proxy& b, const BoxRelation& r, bool x_is_b) {
  Frame f;
  f.x_is_b = x_is_b;
  f.x = x_is_b ? &b : &a;
  f.y = x_is_b ? &a : &b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) (x_is_b ? f.columns[i][j] : f.columns[j][i]) = r.turn[i][j];
  f.centre = Vec3(r.offset[0], r.offset[1], r.offset[2]);
  if (x_is_b)
    f.centre = -Vec3(r.turn[0][0] * f.centre[0] + r.turn[1][0] * f.centre[1] + r.turn[2][0] * f.centre[2],
                     r.turn[0][1] * f.centre[0] + r.turn[1][1] * f.centre[1] + r.turn[2][1] * f.centre[2],
                     r.turn[0][2] * f.centre[0] + r.turn[1][2] * f.centre[1] + r.turn[2][2] * f.centre[2]);
  return f;
}

// Collects points in X's frame and hands them out relative to a's centre in world axes.
struct Collector {
  const Frame& frame;
  const Vec3 origin;  // X's centre less a's centre, world
  Vec3 normal;        // X's frame, from X to Y
  PairManifold& out;

  // `on_y`: the point on Y's surface
  void add(const Vec3& on_y, double gap, std::uint32_t feature) {
    out.add(origin + frame.x->rotation * (on_y - 0.5 * gap * normal), gap, feature);
  }
};

// The part of Y's most opposed face that lies over X's face k on the side `side`.
struct FaceClip {
  int k, face_y;  // face_y = 2 axis + (positive side)
  double side;
  Polygon polygon;
};

FaceClip clip_faces(const Frame& f, int k, double side) {
  FaceClip c;
  c.k = k, c.side = side;
  int m = 0;
  for (int j = 1; j < 3; ++j)
    if (std::abs(f.columns[j][k]) > std::abs(f.columns[m][k])) m = j;
  const double side_y = -side * sign_of(f.columns[m][k]);
  c.face_y = 2 * m + (side_y > 0);

  const Vec3 centre = f.centre + side_y * f.y->half[m] * f.columns[m];
  const int m1 = (m + 1) % 3, m2 = (m + 2) % 3, ku = (k + 1) % 3, kv = (k + 2) % 3;
  const Vec3 e1 = f.y->half[m1] * f.columns[m1], e2 = f.y->half[m2] * f.columns[m2];
  const double hu = f.x->half[ku], hv = f.x->half[kv], hk = f.x->half[k];

  const double s1[4] = {1, -1, -1, 1}, s2[4] = {1, 1, -1, -1};
  Polygon& p = c.polygon;
  bool beyond[4] = {};  // some corner is beyond this side of the reference face
  for (int i = 0; i < 4; ++i) {
    const double u = centre[ku] + s1[i] * e1[ku] + s2[i] * e2[ku], v = centre[kv] + s1[i] * e1[kv] + s2[i] * e2[kv];
    const double h = side * (centre[k] + s1[i] * e1[k] + s2[i] * e2[k]) - hk;
    p.corner[i] = {u, v, h, static_cast<std::uint8_t>((i + 3) & 3), static_cast<std::uint8_t>(i)};
    beyond[0] |= u > hu, beyond[1] |= v > hv, beyond[2] |= -u > hu, beyond[3] |= -v > hv;
  }
  p.count = 4;
  if (beyond[0]) clip<&Corner::u>(p, 1, hu, 4);
  if (beyond[1]) clip<&Corner::v>(p, 1, hv, 5);
  if (beyond[2]) clip<&Corner::u>(p, -1, hu, 6);
  if (beyond[3]) clip<&Corner::v>(p, -1, hv, 7);
  return c;
}

std::uint32_t face_feature(const Frame& f, const FaceClip& c, const Corner& p) {
  const std::uint32_t face_x = 2 * c.k + (c.side > 0);
  return (f.x_is_b ? 1u << 12 : 0u) | face_x << 9 | static_cast<std::uint32_t>(c.face_y) << 6 |
         static_cast<std::uint32_t>(p.in) << 3 | p.out;
}

constexpr std::uint32_t edge_feature = 1u << 13, support_feature = 1u << 14;

// Adds the clipped corners with the collector's normal; `least` is a lower bound of their gaps. Returns the smallest gap.
double add_clip(const FaceClip& c, double least, double margin, Collector& to) {
  const double slant = c.side * to.normal[c.k];  // n . n_face
  double smallest = margin;
  for (int i = 0; i < c.polygon.count; ++i) {
    const Corner& p = c.polygon.corner[i];
    const double gap = std::max(p.height / slant, least);
    if (!(gap <= margin)) continue;
    Vec3 on_y;
    on_y[c.k] = c.side * (to.frame.x->half[c.k] + p.height);
    on_y[(c.k + 1) % 3] = p.u, on_y[(c.k + 2) % 3] = p.v;
    to.add(on_y, gap, face_feature(to.frame, c, p));
    smallest = std::min(smallest, gap);
  }
  return smallest;
}

// Nearest points of disjoint boxes, by projecting to and fro. Converges slowly between nearly parallel faces, but any direction
// found separates, so an early end is safe.
void add_nearest(Collector& to, double margin) {
  const Frame& f = to.frame;
  Vec3 p = f.centre.cwiseMax(-f.x->half).cwiseMin(f.x->half), q = p;
  for (int i = 0; i < 12; ++i) {
    const Vec3 d = p - f.centre;
    q = f.centre;
    for (int j = 0; j < 3; ++j) q += std::clamp(f.columns[j].dot(d), -f.y->half[j], f.y->half[j]) * f.columns[j];
    p = q.cwiseMax(-f.x->half).cwiseMin(f.x->half);
  }
  const Vec3 d = q - p;
  const double distance = d.norm();
  Vec3 n = distance > 1e-100 ? Vec3(d / distance) : to.normal;
  const auto separation = [&](const Vec3& v) {
    double s = v.dot(f.centre) - v.cwiseAbs().dot(f.x->half);
    for (int j = 0; j < 3; ++j) s -= std::abs(f.columns[j].dot(v)) * f.y->half[j];
    return s;
  };
  if (!(separation(n) >= separation(to.normal))) n = to.normal;
  const double gap = separation(n);
  if (gap > margin) return;
  to.normal = n;
  to.add(0.5 * (p + q) + 0.5 * gap * n, gap, support_feature);
}

// Y's corner that reaches deepest into X: the last resort for boxes that overlap.
void add_support(Collector& to, double gap) {
  const Frame& f = to.frame;
  Vec3 corner = f.centre;
  for (int j = 0; j < 3; ++j) corner -= sign_of(f.columns[j].dot(to.normal)) * f.y->half[j] * f.columns[j];
  to.add(corner, gap, support_feature);
}

// The point of an edge axis: half way between the two edges' nearest points.
void add_edge_point(int i, int j, double gap, Collector& to) {
  const Frame& f = to.frame;  // X is a
  Vec3 on_a = Vec3::Zero(), on_b = f.centre;
  std::uint32_t corners = 0;
  for (int k = 0; k < 3; ++k) {
    if (k != i) on_a[k] = sign_of(to.normal[k]) * f.x->half[k], corners |= (to.normal[k] < 0) << k;
    const double along = f.columns[k].dot(to.normal);
    if (k != j) on_b -= sign_of(along) * f.y->half[k] * f.columns[k], corners |= (along < 0) << (3 + k);
  }
  // nearest points of the two lines, kept within the edges
  const Vec3 d = on_b - on_a, &v = f.columns[j];
  const double c = v[i], det = 1 - c * c;
  const double s = std::clamp((d[i] - c * v.dot(d)) / det, -f.x->half[i], f.x->half[i]);
  const double t = std::clamp(c * s - v.dot(d), -f.y->half[j], f.y->half[j]);
  on_a[i] += s;
  on_b += t * v;
  const Vec3 middle = 0.5 * (on_a + on_b);
  to.add(middle + 0.5 * gap * to.normal, gap, edge_feature | static_cast<std::uint32_t>(3 * i + j) << 6 | corners);
}

// The axis as a unit vector in a's frame.
Vec3 axis_direction(const BoxRelation& r, int code) {
  Vec3 n = Vec3::Zero();
  if (code < 3) {
    n[code] = 1;
  } else if (code < 6) {
    for (int i = 0; i < 3; ++i) n[i] = r.turn[i][code - 3];
  } else {
    const int i = (code - 6) / 3, j = (code - 6) % 3, i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    n[i1] = -r.turn[i2][j], n[i2] = r.turn[i1][j];
    n /= std::sqrt(n.squaredNorm());
  }
  return n;
}

}  // namespace

BoxRelation relate_boxes(const Proxy& a, const Proxy& b) {
  BoxRelation r;
  const Vec3 d = b.position - a.position;
  for (int i = 0; i < 3; ++i) {
    r.offset[i] = a.rotation.col(i).dot(d);
    for (int j = 0; j < 3; ++j) {
      r.turn[i][j] = a.rotation.col(i).dot(b.rotation.col(j));
      r.cosine[i][j] = std::abs(r.turn[i][j]);
    }
  }
  return r;
}

bool find_axis(const BoxRelation& r, const Vec3& ha, const Vec3& hb, double margin, BoxAxis& best) {
  const double smallest = smallest_half(ha, hb);
  best = {0, -HUGE_VAL};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const double s = std::abs(r.offset[i]) - (ha[i] + r.cosine[i][0] * hb[0] + r.cosine[i][1] * hb[1] + r.cosine[i][2] * hb[2]);
    if (s > best.separation) best = {i, s};
  }
  if (best.separation > margin) return false;
  const double face_bias = 1e-4 * smallest;  // a's faces are preferred, so that equal boxes do not swap roles from step to step
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) {
    const double u = r.offset[0] * r.turn[0][j] + r.offset[1] * r.turn[1][j] + r.offset[2] * r.turn[2][j];
    const double s = std::abs(u) - (hb[j] + r.cosine[0][j] * ha[0] + r.cosine[1][j] * ha[1] + r.cosine[2][j] * ha[2]);
    if (s > best.separation + (best.code < 3 ? face_bias : 0)) best = {3 + j, s};
  }
  if (best.separation > margin) return false;

  // s > threshold is tested as s length > threshold length, by squares: few edge axes come to a square root
  double threshold = best.separation + 1e-3 * smallest + 0.02 * std::abs(best.separation);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double squared = r.turn[i1][j] * r.turn[i1][j] + r.turn[i2][j] * r.turn[i2][j];
      const double s =
          std::abs(r.offset[i2] * r.turn[i1][j] - r.offset[i1] * r.turn[i2][j]) -
          (ha[i1] * r.cosine[i2][j] + ha[i2] * r.cosine[i1][j] + hb[j1] * r.cosine[i][j2] + hb[j2] * r.cosine[i][j1]);
      if (s * std::abs(s) <= threshold * std::abs(threshold) * squared || squared < parallel) continue;
      threshold = s / std::sqrt(squared), best = {6 + 3 * i + j, threshold};
    }
  }
  return best.separation <= margin;
}

double separation_along(const BoxRelation& r, const Vec3& ha, const Vec3& hb, int code) {
  const Vec3 n = axis_direction(r, code);
  double s = std::abs(n[0] * r.offset[0] + n[1] * r.offset[1] + n[2] * r.offset[2]) - n.cwiseAbs().dot(ha);
  for (int j = 0; j < 3; ++j) s -= std::abs(n[0] * r.turn[0][j] + n[1] * r.turn[1][j] + n[2] * r.turn[2][j]) * hb[j];
  return s;
}

void box_manifold(const Proxy& a, const Proxy& b, const BoxRelation& r, const BoxAxis& axis, double margin, PairManifold& out) {
  const bool edge = axis.code >= 6;
  Vec3 normal = axis_direction(r, axis.code);
  if (normal[0] * r.offset[0] + normal[1] * r.offset[1] + normal[2] * r.offset[2] < 0) normal = -normal;

  // the reference box: the face's, or for an edge the one with the face best aligned with the normal
  bool x_is_b = axis.code >= 3;
  int k = axis.code % 3;
  Vec3 normal_b;
  for (int j = 0; j < 3; ++j) normal_b[j] = r.turn[0][j] * normal[0] + r.turn[1][j] * normal[1] + r.turn[2][j] * normal[2];
  if (edge) {
    int ka = 0, kb = 0;
    x_is_b = normal_b.cwiseAbs().maxCoeff(&kb) > normal.cwiseAbs().maxCoeff(&ka);
    k = x_is_b ? kb : ka;
  }

  const Vec3 offset = b.position - a.position;
  if (edge) {
    const Frame frame = frame_of(a, b, r, false);
    Collector to{frame, Vec3::Zero(), normal, out};
    add_edge_point((axis.code - 6) / 3, (axis.code - 6) % 3, axis.separation, to);
  }
  const Frame frame = frame_of(a, b, r, x_is_b);
  Collector to{frame, x_is_b ? offset : Vec3::Zero(), x_is_b ? Vec3(-normal_b) : normal, out};
  const FaceClip faces = clip_faces(frame, k, sign_of(to.normal[k]));
  const double smallest = add_clip(faces, edge ? axis.separation : -HUGE_VAL, margin, to);
  if (!edge && out.count == 0 && axis.separation > 0) add_nearest(to, margin);
  if (!edge && axis.separation <= 0 && (out.count == 0 || smallest > 0)) add_support(to, axis.separation);
  out.normal = x_is_b ? Vec3(frame.x->rotation * to.normal) : Vec3(-(frame.x->rotation * to.normal));
}

void box_box(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  const BoxRelation relation = relate_boxes(a, b);
  BoxAxis axis;
  if (!find_axis(relation, a.half, b.half, settings.margin, axis)) return;
  if (!manifold_of_meeting_edges(a, b, relation, false, settings.margin, out))
    box_manifold(a, b, relation, axis, settings.margin, out);
}

}  // namespace unibody
