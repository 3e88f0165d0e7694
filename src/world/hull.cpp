#include "world/hull.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "world/shape_library.hpp"
#include "world/shape_type.hpp"
#include "world/solid_moments.hpp"

namespace unibody {

namespace {

using Triangle = std::array<std::int32_t, 3>;
constexpr std::size_t most_corners = 48;

// Triangles of the hull, by adding one point after the other. Points within `rounding` of a face belong to it.
class Builder {
 public:
  Builder(std::span<const Vec3> points, double extent) : points_(points), rounding_(1e-10 * extent), flat_(1e-6 * extent) {}

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
    Vec3 normal;
    double offset;
  };
  const Vec3& at(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }

  Facet facet(std::int32_t i, std::int32_t j, std::int32_t k) const {
    Vec3 n = (at(j) - at(i)).cross(at(k) - at(i));
    const double length = n.norm();
    n = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    return {{i, j, k}, n, n.dot(at(i))};
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
    const Facet base = facet(a, b, c);
    const auto off_plane = [&](const Vec3& x) { return std::abs(base.normal.dot(x) - base.offset); };
    const std::int32_t d = furthest(off_plane);
    if (!(off_line(at(c)) > flat_) || !(off_plane(at(d)) > flat_)) throw std::invalid_argument("points that lie in one plane");
    const bool below = base.normal.dot(at(d)) < base.offset;
    const std::int32_t e = below ? b : c, f = below ? c : b;
    facets_ = {facet(a, e, f), facet(a, d, e), facet(e, d, f), facet(f, d, a)};
  }

  void add(std::int32_t p) {
    std::vector<std::array<std::int32_t, 2>> edges;
    const auto seen = [&](const Facet& f) { return f.normal.dot(at(p)) - f.offset > rounding_; };
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
  double rounding_, flat_;
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

// Faces of all corners in one plane.
void merge_faces(Hull& hull, const std::vector<Triangle>& triangles, double tolerance) {
  const auto at = [&](std::int32_t i) -> const Vec3& { return hull.corners[static_cast<std::size_t>(i)]; };
  for (const Triangle& t : triangles) {
    const Vec3 cross = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    const double longest = std::max({(at(t[1]) - at(t[0])).norm(), (at(t[2]) - at(t[1])).norm(), (at(t[0]) - at(t[2])).norm()});
    if (!(cross.norm() > 10 * tolerance * longest)) continue;  // a sliver, whose normal means nothing: it lies in another face
    const Vec3 n = cross.normalized();
    if (std::any_of(hull.corners.begin(), hull.corners.end(),
                    [&](const Vec3& x) { return n.dot(x - at(t[0])) > 10 * tolerance; }))
      continue;
    const auto same = [&](const Hull::Face& f) {
      const double offset = f.normal.dot(hull.corners[hull.face_corners[f.first]]);
      return f.normal.dot(n) > 0 &&
             std::all_of(t.begin(), t.end(), [&](std::int32_t i) { return std::abs(f.normal.dot(at(i)) - offset) <= tolerance; });
    };
    if (std::any_of(hull.faces.begin(), hull.faces.end(), same)) continue;
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
  const std::vector<Triangle> triangles = Builder(points, extent).run();

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
  merge_faces(hull, renumbered, 1e-7 * extent);

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
