#include "world/hull.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"
#include "world/solid_moments.hpp"

namespace unibody {

namespace {

using Triangle = std::array<std::int32_t, 3>;
constexpr std::size_t most_corners = 48;

__extension__ typedef __int128 LongInteger;
using Whole = std::array<std::int64_t, 3>;

Whole operator-(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// Of differences of at most 2^30, which gives numbers below 2^62.
Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

LongInteger dot(const Whole& a, const Whole& b) {
  return LongInteger{a[0]} * b[0] + LongInteger{a[1]} * b[1] + LongInteger{a[2]} * b[2];
}

// Triangles of the hull, by adding one point after the other. On which side of a triangle a point lies is told from places in
// whole multiples of 2^-30 of the extent, without rounding: with it, triangles of points nearly in one plane would contradict
// each other, and close to a surface that covers the solid more than once. Points of one such place are one.
class Builder {
 public:
  Builder(std::span<const Vec3> points, const Vec3& low, double extent) : points_(points), flat_(1e-6 * extent) {
    const double scale = std::ldexp(1, 30) / extent;
    for (const Vec3& x : points) {
      const Vec3 place = scale * (x - low);
      places_.push_back({std::llround(place[0]), std::llround(place[1]), std::llround(place[2])});
    }
  }

  std::vector<Triangle> run() {
    start();
    for (std::size_t p = 0; p < points_.size(); ++p) add(static_cast<std::int32_t>(p));
    std::vector<Triangle> triangles;
    for (const Facet& f : facets_) triangles.push_back(f.corners);
    return triangles;
  }

 private:
  struct Facet {
    Triangle corners;
    Whole normal;
  };
  const Vec3& at(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }
  const Whole& place(std::int32_t i) const { return places_[static_cast<std::size_t>(i)]; }

  Facet facet(std::int32_t i, std::int32_t j, std::int32_t k) const {
    return {{i, j, k}, cross(place(j) - place(i), place(k) - place(i))};
  }

  template <class F>
  std::int32_t furthest(F&& measure) const {
    std::int32_t best = 0;
    double most = -1;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (const double m = measure(points_[p]); m > most) most = m, best = static_cast<std::int32_t>(p);
    return best;
  }

  // A tetrahedron of points far apart.
  void start() {
    const std::int32_t a = furthest([&](const Vec3& x) { return (x - at(0)).norm(); });
    const std::int32_t b = furthest([&](const Vec3& x) { return (x - at(a)).norm(); });
    const Vec3 along = (at(b) - at(a)).normalized();
    const auto off_line = [&](const Vec3& x) { return (x - at(a) - along * along.dot(x - at(a))).norm(); };
    const std::int32_t c = furthest(off_line);
    const Vec3 normal = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
    const auto off_plane = [&](const Vec3& x) { return std::abs(normal.dot(x - at(a))); };
    const std::int32_t d = furthest(off_plane);
    if (!(off_line(at(c)) > flat_) || !(off_plane(at(d)) > flat_)) throw std::invalid_argument("points that lie in one plane");
    const bool below = normal.dot(at(d) - at(a)) < 0;
    const std::int32_t e = below ? b : c, f = below ? c : b;
    facets_ = {facet(a, e, f), facet(a, d, e), facet(e, d, f), facet(f, d, a)};
  }

  void add(std::int32_t p) {
    std::vector<std::array<std::int32_t, 2>> edges;
    const auto seen = [&](const Facet& f) { return dot(f.normal, place(p) - place(f.corners[0])) > 0; };
    for (const Facet& f : facets_)
      if (seen(f))
        for (std::size_t k = 0; k < 3; ++k) edges.push_back({f.corners[k], f.corners[(k + 1) % 3]});
    if (edges.empty()) return;
    std::erase_if(facets_, seen);
    std::sort(edges.begin(), edges.end());
    for (const auto& [i, j] : edges)  // those of one seen facet only
      if (!std::binary_search(edges.begin(), edges.end(), std::array{j, i})) facets_.push_back(facet(i, j, p));
  }

  std::span<const Vec3> points_;
  std::vector<Whole> places_;
  double flat_;
  std::vector<Facet> facets_;
};

// Selects, of corners in one plane, those on its outline, counterclockwise (Andrew's monotone chain): rounding may have left
// some inside it.
std::vector<std::uint32_t> outline_in_plane(const std::vector<Vec3>& corners, std::vector<std::uint32_t> on, const Vec3& u,
                                            const Vec3& v) {
  const auto place = [&](std::uint32_t i) { return std::pair(u.dot(corners[i]), v.dot(corners[i])); };
  std::sort(on.begin(), on.end(), [&](std::uint32_t i, std::uint32_t j) { return place(i) < place(j); });
  const auto turns_right = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const auto [pu, pv] = place(i);
    const auto [qu, qv] = place(j);
    const auto [ru, rv] = place(k);
    return (qu - pu) * (rv - pv) - (qv - pv) * (ru - pu) <= 0;
  };
  std::vector<std::uint32_t> outline;
  for (const bool back : {false, true}) {
    const std::size_t start = outline.size();
    for (const std::uint32_t i : on) {
      while (outline.size() >= start + 2 && turns_right(outline[outline.size() - 2], outline.back(), i)) outline.pop_back();
      outline.push_back(i);
    }
    outline.pop_back();  // the first of the other half
    if (!back) std::reverse(on.begin(), on.end());
  }
  return outline;
}

// Faces of all corners in one plane, that of the largest triangle among them: places in single precision turn it least.
void merge_faces(Hull& hull, std::vector<Triangle> triangles, double tolerance) {
  const auto at = [&](std::int32_t i) -> const Vec3& { return hull.corners[static_cast<std::size_t>(i)]; };
  const auto area = [&](const Triangle& t) { return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).squaredNorm(); };
  std::stable_sort(triangles.begin(), triangles.end(), [&](const Triangle& a, const Triangle& b) { return area(a) > area(b); });
  std::vector<double> offsets;  // m, of each face
  for (const Triangle& t : triangles) {
    const Vec3 cross = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    const double longest = std::max({(at(t[1]) - at(t[0])).norm(), (at(t[2]) - at(t[1])).norm(), (at(t[0]) - at(t[2])).norm()});
    if (!(cross.norm() > tolerance * longest)) continue;  // a sliver, whose normal means nothing: it lies in another face
    const Vec3 n = cross.normalized();
    if (std::any_of(hull.corners.begin(), hull.corners.end(), [&](const Vec3& x) { return n.dot(x - at(t[0])) > tolerance; }))
      continue;
    const auto same = [&](std::size_t face) {  // all of its corners are among those that the face has
      const Vec3& normal = hull.faces[face].normal;
      return normal.dot(n) > 0 && std::all_of(t.begin(), t.end(), [&](std::int32_t i) {
               return std::abs(normal.dot(at(i)) - offsets[face]) <= tolerance;
             });
    };
    bool is_there = false;
    for (std::size_t face = 0; face < hull.faces.size() && !is_there; ++face) is_there = same(face);
    if (is_there) continue;
    const double offset = n.dot(at(t[0]));
    std::vector<std::uint32_t> on;
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t i = 0; i < hull.corners.size(); ++i)
      if (std::abs(n.dot(hull.corners[i]) - offset) <= tolerance) on.push_back(i), middle += hull.corners[i];
    middle /= static_cast<double>(on.size());
    const Vec3 u = (at(t[0]) - middle).normalized();
    on = outline_in_plane(hull.corners, on, u, n.cross(u));
    if (const std::size_t all = on.size(); all > most_corners) {
      for (std::size_t k = 0; k < most_corners; ++k) on[k] = on[k * all / most_corners];
      on.resize(most_corners);
    }
    offsets.push_back(offset);
    hull.faces.push_back({n, static_cast<std::uint32_t>(hull.face_corners.size()), static_cast<std::uint32_t>(on.size())});
    hull.face_corners.insert(hull.face_corners.end(), on.begin(), on.end());
  }
}

}  // namespace

Hull make_hull(std::span<const Vec3> points) {
  if (points.size() < 4) throw std::invalid_argument(std::to_string(points.size()) + " points");
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double extent = (high - low).maxCoeff();
  const std::vector<Triangle> triangles = Builder(points, low, extent).run();

  const SolidMoments moments = solid_moments(points, triangles);
  Hull hull;
  hull.volume = moments.volume, hull.inertia = moments.inertia, hull.frame = moments.axes, hull.centre = moments.centre;
  std::vector<std::int32_t> number(points.size(), -1);
  std::vector<Triangle> renumbered = triangles;
  for (const Triangle& t : triangles)
    for (const std::int32_t i : t) number[static_cast<std::size_t>(i)] = 0;
  const Mat3 turn = hull.frame.conjugate().toRotationMatrix();
  const bool given = turn == Mat3::Identity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<std::int32_t>(hull.corners.size());
    const Vec3 x = points[i] - hull.centre;
    hull.corners.push_back(given ? x : Vec3(turn * x));
  }
  for (Triangle& t : renumbered)
    for (std::int32_t& i : t) i = number[static_cast<std::size_t>(i)];
  merge_faces(hull, std::move(renumbered), 1e-6 * extent);

  low = high = hull.corners[0];
  for (const Vec3& x : hull.corners) {
    hull.size = hull.size.cwiseMax(x.cwiseAbs()), hull.radius = std::max(hull.radius, x.norm());
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  hull.smallest = (high - low).minCoeff();
  return hull;
}

namespace {

const Hull& hull_of(const Shape& s) { return shape_library().hulls[s.data]; }
double scale_of(const Shape& s) { return s.size.x() / hull_of(s).size.x(); }  // 1, exactly, unless a generator scales it

double bounding(const Shape& s) { return scale_of(s) * hull_of(s).radius; }
double solid_volume(const Shape& s) { return std::pow(scale_of(s), 3) * hull_of(s).volume; }
Vec3 solid_inertia(const Shape& s, double mass) { return mass * scale_of(s) * scale_of(s) * hull_of(s).inertia; }
double shortest(const Shape& s) { return scale_of(s) * hull_of(s).smallest; }
double sharp(const Shape&) { return 0; }

Vec3 support(const Shape& s, const Vec3& d) {
  const Hull& hull = hull_of(s);
  std::size_t best = 0;
  double most = d.dot(hull.corners[0]);
  for (std::size_t i = 1; i < hull.corners.size(); ++i)
    if (const double along = d.dot(hull.corners[i]); along > most) most = along, best = i;
  return scale_of(s) * hull.corners[best];
}

Vec3 extents(const Shape& s, const Mat3& rotation) {
  Vec3 most = Vec3::Zero();
  for (const Vec3& x : hull_of(s).corners) most = most.cwiseMax((rotation * x).cwiseAbs());
  return scale_of(s) * most;
}

void feature(const Shape& s, const Vec3& d, SupportFeature& f) {
  const Hull& hull = hull_of(s);
  const Hull::Face* best = &hull.faces[0];
  for (const Hull::Face& face : hull.faces)
    if (face.normal.dot(d) > best->normal.dot(d)) best = &face;
  const double scale = scale_of(s);
  for (std::uint32_t k = 0; k < best->count; ++k) f.add(scale * hull.corners[hull.face_corners[best->first + k]]);
  f.normal = best->normal;
}
bool contains(const Shape& s, const Vec3& p) {
  const Hull& hull = hull_of(s);
  const Vec3 at = p / scale_of(s);
  return std::ranges::all_of(
      hull.faces, [&](const Hull::Face& face) { return face.normal.dot(at - hull.corners[hull.face_corners[face.first]]) <= 0; });
}
constexpr ConvexFunctions convex{sharp, support, feature, contains};

}  // namespace

const ShapeType hull_type{ShapeKind::hull, {}, nullptr, bounding, extents, solid_volume, solid_inertia, shortest, &convex};

}  // namespace unibody
