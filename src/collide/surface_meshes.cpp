// Meshes on the faces of surfaces: their nodes on faces and edges, their edges across edges. The nodes of surfaces touch the
// triangles as the particles that they are.
//
// A mesh says by its triangles on which side of it a face belongs: a node or edge of it touches only in directions that lie
// between the normals of the triangles around it, so that of a smooth surface few of many touch a face. What lies flat among its
// neighbours touches nothing: the nodes of the surface, and what bounds the flat, say as much. Of a mesh of two sides what stands
// out on either touches, to the side where the face is.
#include <algorithm>
#include <cmath>

#include "collide/mesh_side.hpp"
#include "collide/surface_contacts.hpp"
#include "collide/triangle_distance.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr double lean_on_mesh = 1e-6;  // as of bodies on it (convex_pairs.cpp)
constexpr double deepest = 4;          // in radii: what is deeper behind the mesh may have its way out elsewhere

Vec3 across_of(const Vec3& x, const Vec3& along) { return x - along * (along.dot(x) / along.squaredNorm()); }

Vec3 mean(const TriangleNodes& x, const Vec3& weights) { return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2]; }

Vec3 weights_on_edge(std::size_t edge, double share) {
  Vec3 weights = Vec3::Zero();
  weights[static_cast<Eigen::Index>(edge)] = 1 - share, weights[static_cast<Eigen::Index>((edge + 1) % 3)] = share;
  return weights;
}

}  // namespace

// One mesh and one face. Normals here lead out of the mesh, to the face.
class SurfaceCollider::MeshFace {
 public:
  MeshFace(SurfaceCollider& collider, const Proxy& body, const SurfaceFace& face)
      : collider_(collider),
        settings_(collider.settings_),
        body_(body),
        mesh_(shape_library().meshes[body.data]),
        face_(face),
        spin_(collider.world_.angular_velocity_of(static_cast<std::size_t>(body.slot))),
        now_(collider.places(face, 0)),
        radius_(collider.radius(face.nodes[0])),
        is_closed_(collider.surfaces_.is_closed(face.surface)) {
    pair_.slots = {body.slot, face.nodes[0], face.nodes[1], face.nodes[2]};
    pair_.radii = radius_, pair_.spin = body.turn_reach();
    double fastest = body.speed, travel = 0;
    for (const Slot s : face.nodes) {
      const double relative = (collider.velocity(s) - body.velocity).norm();
      fastest = std::max({fastest, collider.velocity(s).norm(), relative});
      travel = std::max(travel, settings_.step * relative + body.turn_reach());
    }
    is_fast_ = travel > radius_;
    const double fall = settings_.gravity.norm() * settings_.step * settings_.step;
    still_ = radius_ + settings_.margin + body.turn_reach() + fall;
    reach_ = std::max(still_ + settings_.step * fastest, deepest * radius_);
  }

  void run() {
    const Mat3 back = body_.rotation.transpose();
    Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
    for (std::size_t k = 0; k < 3; ++k) {
      local_[k] = back * (now_[k] - body_.position);
      low = low.cwiseMin(local_[k]), high = high.cwiseMax(local_[k]);
    }
    low.array() -= reach_, high.array() += reach_;
    std::vector<std::int32_t> found;
    mesh_.find(low, high, found);
    set_sides();
    std::vector<std::array<unsigned, 3>> beyond;  // of each triangle's nodes
    std::vector<Corner> corners;                  // of a node in the box all triangles are found
    for (const std::int32_t t : found) {
      beyond.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t node = triangle(t).nodes[k];
        const Vec3& x = mesh_.nodes[static_cast<std::size_t>(node)];
        const unsigned where = beyond.back()[k] = sides_beyond(x);
        if (where == 0 && (x.array() >= low.array()).all() && (x.array() <= high.array()).all()) corners.push_back({node, t, k});
      }
    }
    std::sort(corners.begin(), corners.end(),
              [](const Corner& a, const Corner& b) { return std::pair(a.node, a.triangle) < std::pair(b.node, b.triangle); });
    for (auto from = corners.begin(); from != corners.end();) {
      const auto to = std::find_if(from, corners.end(), [&](const Corner& c) { return c.node != from->node; });
      add_node({from, to});
      from = to;
    }
    for (std::size_t i = 0; i < found.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        if (triangle(found[i]).speaks_for_edge[k] && (beyond[i][k] & beyond[i][(k + 1) % 3]) == 0) add_edge(found[i], k);
  }

 private:
  struct Corner {
    std::int32_t node, triangle;
    std::size_t place;  // of the node in the triangle
  };

  // Planes of the mesh's frame around all that the face may touch in the step: beside its edges, over and under it.
  void set_sides() {
    const Vec3 up = (local_[1] - local_[0]).cross(local_[2] - local_[0]).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 aside = (local_[(k + 1) % 3] - local_[k]).cross(up).normalized();
      sides_[k] = {aside, aside.dot(local_[k]) + still_ + farthest_towards(aside)};
    }
    for (std::size_t k = 3; k < 5; ++k) {
      const Vec3 away = k == 3 ? up : Vec3(-up);
      const double travel = std::max(farthest_towards(up), farthest_towards(-up));
      sides_[k] = {away, away.dot(local_[0]) + std::max(still_ + travel, deepest * radius_)};
    }
  }
  // The farthest that the body, or a node of the face by itself or against it, moves along a direction in the step (m).
  double farthest_towards(const Vec3& direction) const {
    const Vec3 turned = body_.rotation * direction;
    double most = std::max(0.0, -settings_.step * turned.dot(body_.velocity));
    for (const Slot s : face_.nodes) {
      const Vec3& own = collider_.velocity(s);
      most = std::max({most, settings_.step * turned.dot(own), settings_.step * turned.dot(own - body_.velocity)});
    }
    return most;
  }
  unsigned sides_beyond(const Vec3& x) const {
    unsigned result = 0;
    for (std::size_t k = 0; k < 5; ++k) result |= static_cast<unsigned>(sides_[k].first.dot(x) > sides_[k].second) << k;
    return result;
  }

  const MeshSurface::Triangle& triangle(std::int32_t t) const { return mesh_.triangles[static_cast<std::size_t>(t)]; }
  Vec3 arm(std::int32_t node) const { return body_.rotation * mesh_.nodes[static_cast<std::size_t>(node)]; }
  Vec3 velocity_at(const Vec3& arm) const { return body_.velocity + spin_.cross(arm); }
  MovingPoint path(const Vec3& arm) const {
    return {body_.position + arm, body_.position + arm + settings_.step * velocity_at(arm)};
  }
  Vec3 velocity_of_face(const Vec3& weights) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) sum += weights[static_cast<Eigen::Index>(k)] * collider_.velocity(face_.nodes[k]);
    return sum;
  }

  // Whether a normal lies between those of the triangles around a node.
  bool is_between(std::span<const Corner> around, const Vec3& normal) const {
    const Vec3 local = body_.rotation.transpose() * normal;
    const Vec3& x = mesh_.nodes[static_cast<std::size_t>(around[0].node)];
    Vec3 outwards = mesh_.node_normals[static_cast<std::size_t>(around[0].node)];
    const bool on_border = outwards == Vec3::Zero();
    for (const Corner& c : around) {
      const MeshSurface::Triangle& t = triangle(c.triangle);
      if (on_border) outwards += t.normal;
      for (const std::size_t next : {(c.place + 1) % 3, (c.place + 2) % 3}) {
        const Vec3 along = mesh_.nodes[static_cast<std::size_t>(t.nodes[next])] - x;
        if (local.dot(along) > lean_on_mesh * along.norm()) return false;
      }
    }
    return mesh_.two_sided || local.dot(outwards) > 0;
  }
  bool is_flat(std::span<const Corner> around) const {
    if (mesh_.node_normals[static_cast<std::size_t>(around[0].node)] == Vec3::Zero()) return false;  // on a border
    const Vec3& first = triangle(around[0].triangle).normal;
    return std::all_of(around.begin(), around.end(),
                       [&](const Corner& c) { return first.cross(triangle(c.triangle).normal).norm() <= lean_on_mesh; });
  }

  // Where two points are now, and by what they are that: those of the mesh with its arm, those of the face by weights.
  struct Touch {
    Vec3 arm, weights;  // m, to the point of the mesh
    std::uint32_t feature;
  };

  // Two points as they are now, the face's `height` (m) along the normal over the mesh's; less than 0: it is behind.
  void add_standing(const Touch& touch, const Vec3& normal, double height, bool watched) {
    const double h = settings_.step;
    Pair pair = pair_;
    pair.weights = {1, -touch.weights[0], -touch.weights[1], -touch.weights[2]}, pair.watched = watched;
    const double gap = height - radius_;
    if (gap > collider_.margin(pair, normal)) return;
    const Vec3 place = mean(now_, touch.weights) - body_.position;
    double beyond = 0;
    if (height < 0) {  // it may be on the other side of a thin part
      if (-height > deepest * radius_) return;
      const double was = height - h * normal.dot(velocity_of_face(touch.weights) - velocity_at(touch.arm));
      const bool has_passed = settings_.has_past && was > 0;
      MeshPlace behind;
      if (!has_passed && !is_behind(mesh_, body_.rotation.transpose() * place, deepest * radius_, behind)) return;
      if (has_passed && !is_closed_) beyond = -height + 0.1 * radius_;
    }
    collider_.add(pair, place, -normal, gap, touch.feature, beyond);
  }

  // Two points as they will meet at a share of the step, the gap opened by what they close until then.
  void add_meeting(const Touch& touch, const Vec3& normal, double distance, double time, bool each_face) {
    Pair pair = pair_;
    pair.weights = {1, -touch.weights[0], -touch.weights[1], -touch.weights[2]}, pair.meets = each_face;
    const double closing = normal.dot(velocity_at(touch.arm) - velocity_of_face(touch.weights));
    const double closed = std::max(0.0, time * settings_.step * closing);
    const Vec3 place =
        mean(collider_.places(face_, time), touch.weights) - body_.position - time * settings_.step * body_.velocity;
    collider_.add(pair, place, -normal, distance - radius_ + closed, touch.feature);
  }

  // The way from the mesh's point to the face's (m), at a share of the step.
  Vec3 apart(const Touch& touch, double time) const {
    return mean(collider_.places(face_, time), touch.weights) - body_.position - touch.arm -
           time * settings_.step * velocity_at(touch.arm);
  }

  void add_node(std::span<const Corner> around) {
    Touch touch{arm(around[0].node), Vec3::Zero(), 2 * static_cast<std::uint32_t>(around[0].node)};
    const Vec3 x = body_.position + touch.arm;
    const TrianglePoint near = closest_on_triangle(x, now_[0], now_[1], now_[2]);
    if (near.distance > reach_ || is_flat(around)) return;
    const auto fits = [&](const Vec3& normal) {  // on the far side of a thin part of a solid is no wall
      return is_between(around, normal) && !(is_closed_ && collider_.is_inwards(face_, touch.weights, -normal));
    };
    bool watched = false;
    if (is_fast_) {
      const auto of_face = [&](std::size_t k) { return collider_.path(face_.nodes[k]); };
      const ContinuousHit hit = point_meets_triangle(path(touch.arm), of_face(0), of_face(1), of_face(2), continuous(radius_));
      watched = !hit.hit;
      if (hit.hit && hit.time > 0) {
        touch.weights = without_twin(face_, {hit.weights[1], hit.weights[2], hit.weights[3]});
        const Vec3 between = apart(touch, hit.time);
        const double distance = between.norm();
        if (!is_one_node(touch.weights) && distance > 0 && fits(between / distance))
          return add_meeting(touch, between / distance, distance, hit.time, true);
      }
    }
    touch.weights = without_twin(face_, near.weights);
    if (is_one_node(touch.weights) || !collider_.owns(face_, touch.weights)) return;
    Vec3 normal = near.point - x;
    if ((touch.weights.array() > 0).all()) {  // also where the two are at the same place
      normal = (now_[1] - now_[0]).cross(now_[2] - now_[0]).normalized();
    } else {
      if (!(near.distance > 0)) return;
      normal /= near.distance;
      if (!collider_.is_nearest(face_, touch.weights, -normal, lean_of_points)) return;
    }
    if (mesh_.two_sided && normal.dot(near.point - x) < 0) normal = -normal;  // where both fit, to where the face is
    if (!fits(normal)) normal = -normal;
    if (!fits(normal)) return;
    add_standing(touch, normal, normal.dot(near.point - x), watched);
  }

  // An edge of the mesh; here all but points is in its frame.
  void add_edge(std::int32_t number, std::size_t k) {
    const MeshSurface::Triangle& t = triangle(number);
    const auto node = [&](std::int32_t n) -> const Vec3& { return mesh_.nodes[static_cast<std::size_t>(n)]; };
    const Vec3 &from = node(t.nodes[k]), &to = node(t.nodes[(k + 1) % 3]), along = to - from;
    Vec3 beyond = Vec3::Zero(), outwards = t.normal;
    if (t.across[k] >= 0) {
      const Vec3 other = node(t.across[k]) - from;
      beyond = across_of(other, along).normalized();
      const double rise = t.normal.dot(beyond);
      if (mesh_.two_sided ? std::abs(rise) <= lean_on_mesh : rise >= -lean_on_mesh) return;  // flat, or a valley
      outwards += beyond.cross(along).normalized();
    }
    const Vec3 inwards = t.normal.cross(along).normalized();
    const auto is_ridge = [&](const Vec3& normal) {
      return normal.dot(inwards) <= lean_on_mesh && normal.dot(beyond) <= lean_on_mesh &&
             (mesh_.two_sided || normal.dot(outwards) > 0);
    };
    for (std::size_t i = 0; i < (face_.is_segment() ? 1 : 3); ++i) {
      const Vec3 &start = local_[i], &end = local_[(i + 1) % 3];
      const Vec3 low = start.cwiseMin(end) - from.cwiseMax(to), high = from.cwiseMin(to) - start.cwiseMax(end);
      if (low.maxCoeff() > reach_ || high.maxCoeff() > reach_) continue;
      const Vec3 side = end - start;
      Vec3 normal = along.cross(side);
      const double length = normal.norm();
      const bool crosses = length > 1e-8 * along.norm() * side.norm();  // of two that are parallel the nodes say it all
      if (mesh_.two_sided && normal.dot(start - from) < 0) normal = -normal;
      if (crosses) normal /= is_ridge(normal / length) ? length : -length;
      const bool fits = crosses && is_ridge(normal);
      if (!(is_fast_ || fits) || !collider_.owns(face_, weights_on_edge(i, 0.5))) continue;
      const std::uint32_t feature = 2 * (3 * static_cast<std::uint32_t>(number) + static_cast<std::uint32_t>(k)) + 1;
      add_edges(body_.rotation * from, body_.rotation * to, i, feature, fits ? Vec3(body_.rotation * normal) : Vec3(Vec3::Zero()),
                [&](const Vec3& then) { return is_ridge(body_.rotation.transpose() * then); });
    }
  }

  // Whether the face, and what is beyond its edge, does not rise towards the mesh.
  bool is_edge_nearest(std::size_t edge, const Vec3& normal) const {
    const Vec3 &start = now_[edge], side = now_[(edge + 1) % 3] - start;
    if (!face_.is_segment()) {
      const Vec3 into = across_of(now_[(edge + 2) % 3] - start, side);
      if (-normal.dot(into) > lean_of_boxes * into.norm()) return false;
    }
    return collider_.is_nearest(face_, weights_on_edge(edge, 0.5), -normal, lean_of_boxes);
  }

  // An edge of the mesh, between two arms, and one of the face. `normal`: as they are now; 0: they do not look at each other.
  template <class IsRidge>
  void add_edges(const Vec3& first, const Vec3& second, std::size_t edge, std::uint32_t feature, const Vec3& normal,
                 IsRidge is_ridge) {
    const Slot a = face_.nodes[edge], b = face_.nodes[(edge + 1) % 3];
    const SegmentPoints near =
        closest_of_segments(body_.position + first, body_.position + second, collider_.place(a), collider_.place(b));
    if (near.distance > reach_) return;
    bool watched = false;
    if (is_fast_) {
      const ContinuousHit hit =
          edge_meets_edge(path(first), path(second), collider_.path(a), collider_.path(b), continuous(radius_));
      watched = !hit.hit;
      const bool within = std::all_of(hit.weights.begin(), hit.weights.end(), [](double w) { return w > 0; });
      if (hit.hit && hit.time > 0 && within) {
        const Touch touch{first + hit.weights[1] * (second - first), weights_on_edge(edge, hit.weights[3]), feature};
        const Vec3 between = apart(touch, hit.time);
        const double distance = between.norm();
        if (distance > 0 && is_ridge(between / distance) && is_edge_nearest(edge, between / distance))
          return add_meeting(touch, between / distance, distance, hit.time, false);
      }
    }
    if (!(near.s > 0 && near.s < 1 && near.t > 0 && near.t < 1)) return;  // nodes on faces say it
    if (normal == Vec3::Zero() || !is_edge_nearest(edge, normal)) return;
    add_standing({first + near.s * (second - first), weights_on_edge(edge, near.t), feature}, normal,
                 normal.dot(near.second - near.first), watched);
  }

  SurfaceCollider& collider_;
  const CollideSettings& settings_;
  const Proxy& body_;
  const MeshSurface& mesh_;
  const SurfaceFace& face_;
  Vec3 spin_;                                     // 1/s
  TriangleNodes now_, local_;                     // of the face; in the mesh's frame
  double radius_, still_, reach_;                 // m; within the reach there may be contacts, within the other if nothing moves
  std::array<std::pair<Vec3, double>, 5> sides_;  // normals away from the face, m
  bool is_closed_, is_fast_;
  Pair pair_;
};

void SurfaceCollider::mesh_face(const Proxy& mesh, const SurfaceFace& face) { MeshFace(*this, mesh, face).run(); }

}  // namespace unibody
