#include "collide/triangle_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

// How far a direction may lean out of the range in which two edges, or a corner and a face, touch properly. Without it a box that
// lies flat would lose points by a turn in the last bit.
constexpr double lean = 0.05;

void add(TriangleContacts& out, const TriangleReach& reach, const Vec3& on_triangle, const Vec3& normal, const Vec3& weights,
         double gap, int feature) {
  if (!(gap >= -reach.depth && gap <= reach.margin)) return;
  out.points[static_cast<std::size_t>(out.count++)] = {on_triangle + 0.5 * gap * normal, normal, weights, gap,
                                                       static_cast<std::uint32_t>(feature)};
}

// A box and a triangle, in the box's frame with its centre at 0.
class BoxTriangle {
 public:
  BoxTriangle(const Vec3& half, const TriangleNodes& nodes, std::span<const Vec3> beyond, const TriangleReach& reach,
              TriangleContacts& out)
      : half_(half), nodes_(nodes), beyond_(beyond), reach_(reach), out_(out), rounding_(1e-9 * half.maxCoeff()) {}

  void run() {
    const Vec3 low = nodes_[0].cwiseMin(nodes_[1]).cwiseMin(nodes_[2]), high = nodes_[0].cwiseMax(nodes_[1]).cwiseMax(nodes_[2]);
    if (is_far(low, high)) return;
    const double widest = std::max(reach_.margin, reach_.depth);  // of the two points of a contact
    low_ = low.array() - widest, high_ = high.array() + widest;
    normal_ = face_normal(nodes_);
    const double length = normal_.norm();
    if (length > 0) normal_ /= normal_.dot(nodes_[0]) > 0 ? -length : length;  // towards the centre
    for (int corner = 0; corner < 8; ++corner) add_corner(corner);
    for (int node = 0; node < 3; ++node) add_node(node);
    for (int edge = 0; edge < 12; ++edge) add_edges(edge);
    drop_overstated();
  }

 private:
  const Vec3& half_;
  const TriangleNodes& nodes_;
  std::span<const Vec3> beyond_;
  const TriangleReach& reach_;
  TriangleContacts& out_;
  double rounding_;  // m
  Vec3 normal_;
  Vec3 low_, high_;  // where the points on the box may be

  bool is_far(const Vec3& low, const Vec3& high) const {
    return ((low - half_).array() > reach_.margin).any() || ((-high - half_).array() > reach_.margin).any();
  }

  bool may_hold(double coordinate, Eigen::Index axis) const { return coordinate >= low_[axis] && coordinate <= high_[axis]; }

  // Where the body is beyond the triangle, the point of the triangle must lie within the body, or not much outside of it:
  // otherwise the two face away from each other.
  bool is_within(const Vec3& x, double depth) const { return ((x.cwiseAbs() - half_).array() <= rounding_ + 0.25 * depth).all(); }

  // A point deeper than the shortest way out of the overlap belongs to features that pass each other elsewhere.
  void drop_overstated();
  double overlap() const;  // m, the least over the axes of the separating axis test
  double overlap_along(const Vec3& axis) const;

  void add_corner(int corner) {
    const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vec3 v = sign.cwiseProduct(half_);
    if (!may_hold(v[0], 0) || !may_hold(v[1], 1) || !may_hold(v[2], 2)) return;
    const TrianglePoint near = closest_on_triangle(v, nodes_[0], nodes_[1], nodes_[2]);
    const Vec3& x = near.point;
    const unsigned feature = near.feature();
    const double gap = normal_.dot(v - x);
    // rounding can put the foot of a corner on the face of a triangle that has no area, whose normal means nothing
    if (feature == 7 && std::abs(gap) >= 0.999 * near.distance - rounding_) {
      if (normal_.dot(v) < 0 && (gap >= 0 || is_within(x, -gap))) add(out_, reach_, x, normal_, near.weights, gap, corner);
    } else if ((feature & (feature - 1)) != 0 && near.distance > rounding_) {
      // an edge: only if the corner is the box's nearest point as well
      if ((sign.cwiseProduct(x).array() < half_.array() - rounding_).any()) return;
      add(out_, reach_, x, (v - x) / near.distance, near.weights, near.distance, corner);
    }
  }

  void add_node(int node) {
    const Vec3& x = nodes_[static_cast<std::size_t>(node)];
    const Vec3 to_box = x.cwiseMax(-half_).cwiseMin(half_) - x;
    const double distance = to_box.norm();
    if (distance > 0) return add(out_, reach_, x, to_box / distance, Vec3::Unit(node), distance, 8 + node);
    Eigen::Index face = 0;
    const double depth = (half_ - x.cwiseAbs()).minCoeff(&face);
    add(out_, reach_, x, -std::copysign(1.0, x[face]) * Vec3::Unit(face), Vec3::Unit(node), -depth, 8 + node);
  }

  void add_edges(int edge) {
    const Eigen::Index k = edge / 4, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    const double side1 = edge & 1 ? 1 : -1, side2 = edge & 2 ? 1 : -1;
    if (!may_hold(side1 * half_[k1], k1) || !may_hold(side2 * half_[k2], k2)) return;
    Vec3 start, end;
    start[k] = -half_[k], end[k] = half_[k];
    start[k1] = end[k1] = side1 * half_[k1], start[k2] = end[k2] = side2 * half_[k2];
    for (int i = 0; i < 3; ++i) {
      const auto i0 = static_cast<std::size_t>(i), i1 = (i0 + 1) % 3;
      const Vec3 &p = nodes_[i0], &q = nodes_[i1], along = q - p;
      if (is_far(p.cwiseMin(q), p.cwiseMax(q))) continue;
      const SegmentPoints near = closest_of_segments(start, end, p, q);
      if (!(near.s > 0 && near.s < 1 && near.t > 0 && near.t < 1)) continue;
      const Vec3 &y = near.first, &x = near.second;
      Vec3 normal = Vec3::Unit(k).cross(along);
      const double length = normal.norm();
      if (!(length > 1e-8 * along.norm())) continue;   // parallel: corners and nodes say it all
      normal /= normal.dot(y) > 0 ? -length : length;  // from the box's edge inwards
      if (side1 * normal[k1] > lean || side2 * normal[k2] > lean) continue;
      Vec3 inwards = nodes_[(i0 + 2) % 3] - x;  // from the triangle's edge: the triangle may not rise towards the body
      inwards -= along * (along.dot(inwards) / along.squaredNorm());
      if (normal.dot(inwards) > lean * inwards.norm() + 1e-8 * along.norm()) continue;
      const double gap = normal.dot(y - x);
      if (gap < 0 && !is_within(x, -gap)) continue;
      Vec3 weights = Vec3::Zero();
      weights[i] = 1 - near.t, weights[static_cast<Eigen::Index>(i1)] = near.t;
      add(out_, reach_, x, normal, weights, gap, 11 + 3 * edge + i);
    }
  }
};

void BoxTriangle::drop_overstated() {
  double least = 0;
  for (int i = 0; i < out_.count; ++i) least = std::min(least, out_.points[static_cast<std::size_t>(i)].gap);
  if (least == 0) return;
  const double depth = overlap() * (1 + 1e-9) + rounding_;
  if (-least <= depth) return;
  int kept = 0;
  for (int i = 0; i < out_.count; ++i) {
    const TriangleContact& c = out_.points[static_cast<std::size_t>(i)];
    if (-c.gap <= depth) out_.points[static_cast<std::size_t>(kept++)] = c;
  }
  out_.count = kept;
}

double BoxTriangle::overlap() const {
  double least = normal_.isZero() ? HUGE_VAL : overlap_along(normal_);
  for (Eigen::Index k = 0; k < 3; ++k) {
    least = std::min(least, overlap_along(Vec3::Unit(k)));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 edge = nodes_[(i + 1) % 3] - nodes_[i], axis = Vec3::Unit(k).cross(edge);
      const double length = axis.norm();
      if (length > 1e-8 * edge.norm()) least = std::min(least, overlap_along(axis / length));
    }
  }
  return least;
}

double BoxTriangle::overlap_along(const Vec3& axis) const {
  double low = HUGE_VAL, high = -HUGE_VAL;
  const auto note = [&](const Vec3& x) { low = std::min(low, axis.dot(x)), high = std::max(high, axis.dot(x)); };
  for (const Vec3& x : nodes_) note(x);
  for (const Vec3& x : beyond_) note(x);
  return axis.cwiseAbs().dot(half_) + std::min(high, -low);
}

}  // namespace

void box_triangle(const Vec3& centre, const Mat3& rotation, const Vec3& half, const TriangleNodes& triangle,
                  const TriangleReach& reach, TriangleContacts& out, std::span<const Vec3> beyond) {
  out.count = 0;
  const auto local_of = [&](const Vec3& x) -> Vec3 { return rotation.transpose() * (x - centre); };
  const TriangleNodes local{local_of(triangle[0]), local_of(triangle[1]), local_of(triangle[2])};
  std::array<Vec3, 3> behind;
  const std::size_t count = std::min(beyond.size(), behind.size());
  std::transform(beyond.begin(), beyond.begin() + static_cast<std::ptrdiff_t>(count), behind.begin(), local_of);
  BoxTriangle(half, local, std::span(behind).first(count), reach, out).run();
  for (int i = 0; i < out.count; ++i) {
    TriangleContact& c = out.points[static_cast<std::size_t>(i)];
    c.position = centre + rotation * c.position;
    c.normal = rotation * c.normal;
  }
}

}  // namespace unibody
