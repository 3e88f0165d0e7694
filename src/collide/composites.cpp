// Compounds and meshes: their parts and triangles, each as a body of its own with the whole body's motion.
#include <algorithm>
#include <cmath>

#include "collide/approach.hpp"
#include "collide/convex_pairs.hpp"
#include "collide/mesh_side.hpp"
#include "collide/mesh_triangles.hpp"
#include "collide/mesh_way.hpp"
#include "collide/narrowphase.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

using Found = std::function<void(const PairManifold&)>;

Proxy part_of(const Proxy& whole, const Compound::Part& part) {
  Proxy p = whole;
  p.of_part = whole.of_part + whole.rotation * part.place;
  p.position = whole.position + whole.rotation * part.place;
  p.rotation = whole.rotation * part.turn.toRotationMatrix();
  p.kind = part.shape.kind, p.data = part.shape.data;
  p.half = is_round(part.shape) ? Vec3::Constant(part.shape.size.x()) : part.shape.size;
  p.radius = bounding_radius(part.shape);
  p.half_size = 0.5 * smallest_size(part.shape);
  return p;  // its spin_reach is that of the whole, which moves the part's centre too
}

// Into a mesh that is not solid all the way, from how deep a body is pushed back, in units of its smallest size.
constexpr double deepest_behind = 3;

// A mesh's triangles in its own frame; b is the mesh. A body whose centre has got behind them, however that came, is pushed to
// the nearest point of the surface, as out of a half space; until then the triangles hold it. Those of a two-sided mesh hold it
// on the side where its centre is.
class OnMesh {
 public:
  OnMesh(const Proxy& a, const Proxy& b, const CollideSettings& settings)
      : a_(a), b_(b), settings_(settings), mesh_(shape_library().meshes[b.data]) {
    const Mat3 back = b.rotation.transpose();
    margin_ = pair_margin(a, b, settings);
    place_ = back * (a.position - b.position);
    velocity_ = back * (a.velocity - b.velocity), turn_ = back * b.turn;
    const Mat3 turn = back * a.rotation;
    extent_ = bounding_half_extents(a.shape(), turn).array() + margin_;
    body_ = convex_body(a.shape(), turn, Vec3::Zero());
  }

  void run(bool swapped, const Found& f) {
    const auto say = [&](PairManifold& m) {
      const Vec3 moved = place_ + m.time * velocity_, at = b_.position + m.time * b_.velocity;
      for (int i = 0; i < m.count; ++i) m.points[i].position = at + b_.rotation * (moved + m.points[i].position);
      m.normal = b_.rotation * m.normal;
      if (swapped) m.normal = -m.normal;
      m.part_a = swapped ? &b_ : &a_, m.part_b = swapped ? &a_ : &b_;
      f(m);
    };
    MeshPlace centre;
    if (is_behind(mesh_, place_, mesh_.is_solid ? HUGE_VAL : deepest_behind * body_.size, centre)) {
      PairManifold m;
      if (push_out(centre, m)) say(m);
      return;
    }
    std::vector<std::int32_t> triangles;
    mesh_.find(place_ - extent_, place_ + extent_, triangles);
    std::vector<MeshSurface::Triangle> turned;
    std::vector<const MeshSurface::Triangle*> near;
    if (mesh_.two_sided || !mesh_.branchings.empty()) {
      turned = facing(mesh_, triangles, place_);
      for (const MeshSurface::Triangle& t : turned) near.push_back(&t);
    } else {
      for (const std::int32_t t : triangles) near.push_back(&mesh_.triangles[static_cast<std::size_t>(t)]);
    }
    if (follows_way())
      way_ = triangles_on_way(
          {body_, a_.half_size, place_, velocity_seen(place_, velocity_, turn_, settings_.step), settings_.step}, mesh_, near);
    for (const MeshSurface::Triangle* t : near) {
      PairManifold m;
      m.triangle = t;
      if (collide(*t, m)) say(m);
    }
  }

 private:
  // Whether the body may pass several triangles in the step. Of balls, which touch with a single point, that is always asked
  // where the mesh does not turn.
  bool follows_way() const {
    constexpr double least = 0.25;  // of half the body's size
    if (is_round(a_.shape()) && turn_.isZero(0)) return true;
    return settings_.step * relative_speed(a_, b_) > least * a_.half_size;
  }

  MeshTriangle in_place(const MeshSurface::Triangle& t, const Vec3& centre) const {
    MeshTriangle result{{}, {}, &t, t.normal, &mesh_, centre};
    for (std::size_t k = 0; k < 3; ++k) {
      result.nodes[k] = mesh_.nodes[static_cast<std::size_t>(t.nodes[k])] - centre;
      if (t.across[k] >= 0) result.across[k] = mesh_.nodes[static_cast<std::size_t>(t.across[k])] - centre;
    }
    return result;
  }

  // Positions from the body's centre, here and below.
  bool push_out(const MeshPlace& centre, PairManifold& m) const {
    const bool deep = centre.depth > 1e-6 * body_.size;
    const Vec3 way = centre.point - place_, normal = deep ? Vec3(way / centre.depth) : centre.normal;
    half_space_manifold(body_, way, normal, margin_, m);
    tidy(m, std::min(margin_, margin_along(b_.rotation * normal, a_, b_, settings_)));
    return m.count > 0;
  }

  bool collide(const MeshSurface::Triangle& t, PairManifold& m) {
    const double travel = settings_.step * relative_speed(a_, b_);
    if (way_.size() > 1 && std::ranges::find(way_, &t) != way_.end()) return comes_to(t, m);
    double time = 0;
    if (travel > a_.half_size && velocity_.dot(t.normal) < 0) time = first_touch(t);
    if (time == 0 && travel > least_approach * a_.half_size) {
      const Vec3 velocity = b_.rotation.transpose() * approach_velocity(a_, b_, settings_);
      ConvexDistance nearest;
      const double passed = passes(t, velocity);
      if (passed > 0 && has_no_nearer_neighbour(body_, in_place(t, place_ + passed * velocity), margin_, nearest))
        return pass(t, velocity, passed, nearest, m);
    }
    const MeshTriangle triangle = in_place(t, place_ + time * velocity_);
    if (!triangle_manifold(body_, triangle, margin_, m)) return comes_to(t, m);
    const double closed = time * std::max(0.0, -m.normal.dot(velocity_));
    m.time = time;
    for (int i = 0; i < m.count; ++i) m.points[i].gap += closed;
    tidy(m, time > 0 ? margin_ : std::min(margin_, margin_along(b_.rotation * m.normal, a_, b_, settings_)));
    return m.count > 0;
  }

  // Whether the body, which may be over another triangle now, comes to lie on this one within the step. The contact has the
  // normal that the triangle has when the step ends, since a row of the solver keeps one normal for the whole step.
  bool comes_to(const MeshSurface::Triangle& t, PairManifold& m) const {
    if (std::ranges::find(way_, &t) == way_.end()) return false;
    const double rate = turn_.norm();
    const Mat3 turned = rate > 0 ? Eigen::AngleAxisd(settings_.step * rate, turn_ / rate).toRotationMatrix() : Mat3::Identity();
    const Vec3 normal = rate > 0 ? Vec3(turned * t.normal) : t.normal;
    const Vec3& node = mesh_.nodes[static_cast<std::size_t>(t.nodes[0])];
    m.count = 0;
    half_space_manifold(body_, (rate > 0 ? Vec3(turned * node) : node) - place_, normal, HUGE_VAL, m);
    for (int i = 0; rate > 0 && i < m.count; ++i)
      m.points[i].gap += settings_.step * normal.dot(turn_.cross(place_ + m.points[i].position));
    tidy(m, margin_);
    return m.count > 0;
  }

  // When the body is nearest to a triangle that it passes by (s); 0: it may touch it. Where a neighbour is nearer then, that
  // one may be touched, and the triangle is taken as the body stands.
  double passes(const MeshSurface::Triangle& t, const Vec3& velocity) const {
    const double far = margin_ + settings_.step * velocity.norm();
    const auto separation_at = [&](double time, Separation& separation) {
      const MeshTriangle triangle = in_place(t, place_ + time * velocity);
      ConvexDistance distance;
      if (distance_of_cores(body_, convex_triangle(triangle.nodes, body_.size), far, distance) != Cores::apart) return false;
      separation = {distance.gap, -distance.normal.dot(velocity)};
      return true;
    };
    const Encounter encounter = encounter_of(settings_.step, 1e-6 * body_.size, separation_at);
    return encounter.passes() ? encounter.time : 0;
  }

  // As leave_way() in narrowphase.cpp; the mesh does not fall. Where the triangle's own normal would be in the way after all, the
  // nearest points say it.
  bool pass(const MeshSurface::Triangle& t, const Vec3& velocity, double time, const ConvexDistance& nearest,
            PairManifold& m) const {
    if (!triangle_manifold(body_, in_place(t, place_ + time * velocity), margin_, m)) return false;
    double least = HUGE_VAL;
    for (int i = 0; i < m.count; ++i) least = std::min(least, m.points[i].gap);
    if (least + (settings_.step - time) * m.normal.dot(velocity) < 0) {
      m.normal = nearest.normal, m.count = 0;
      m.add(0.5 * (nearest.on_a + nearest.on_b), nearest.gap, 0);
    }
    const double closed = time * std::max(0.0, -m.normal.dot(velocity));
    for (int i = 0; i < m.count; ++i) m.points[i].gap += closed, m.points[i].position -= 0.5 * closed * m.normal;
    tidy(m, margin_);
    return m.count > 0;
  }

  // s; 0 where it is not within the step, or they touch already.
  double first_touch(const MeshSurface::Triangle& t) const {
    double time = 0;
    for (int i = 0; i < 32; ++i) {
      const MeshTriangle triangle = in_place(t, place_ + time * velocity_);
      const ConvexBody face = convex_triangle(triangle.nodes, body_.size);
      ConvexDistance distance;
      if (distance_of_cores(body_, face, 4 * (a_.radius + settings_.step * velocity_.norm() + margin_), distance) != Cores::apart)
        return time;
      if (distance.gap <= 1e-6 * body_.size) return time;
      const double closing = -distance.normal.dot(velocity_);
      if (closing <= 0) return 0;
      time += distance.gap / closing;
      if (!(time <= settings_.step)) return 0;
    }
    return time;
  }

  const Proxy &a_, &b_;
  const CollideSettings& settings_;
  const MeshSurface& mesh_;
  double margin_;
  Vec3 place_, velocity_, turn_, extent_;
  ConvexBody body_;
  std::vector<const MeshSurface::Triangle*> way_;
};

bool may_touch(const Proxy& a, const Proxy& b, const CollideSettings& settings) {
  if (a.kind == ShapeKind::plane || b.kind == ShapeKind::plane || is_composite(a.kind) || is_composite(b.kind)) return true;
  const double reach = a.radius + b.radius + pair_margin(a, b, settings);
  return (a.position - b.position).squaredNorm() <= reach * reach;
}

}  // namespace

void for_each_part(const Proxy& whole, const std::function<void(const Proxy&)>& f) {
  if (whole.kind != ShapeKind::compound) return f(whole);
  for (const Compound::Part& part : shape_library().compounds[whole.data].parts) f(part_of(whole, part));
}

void collide_composites(const Proxy& a, const Proxy& b, const CollideSettings& settings, const Found& f) {
  for (const bool second : {false, true}) {
    const Proxy &whole = second ? b : a, &other = second ? a : b;
    if (whole.kind != ShapeKind::compound) continue;
    for (const Compound::Part& part : shape_library().compounds[whole.data].parts) {
      const Proxy p = part_of(whole, part);
      if (!may_touch(p, other, settings)) continue;
      second ? collide_composites(other, p, settings, f) : collide_composites(p, other, settings, f);
    }
    return;
  }
  const bool mesh_a = a.kind == ShapeKind::mesh, mesh_b = b.kind == ShapeKind::mesh;
  if (mesh_a && mesh_b) return;
  if (mesh_a || mesh_b) {
    const Proxy& other = mesh_a ? b : a;
    if (other.kind == ShapeKind::plane) return;
    return OnMesh(other, mesh_a ? a : b, settings).run(mesh_a, f);
  }
  collide_simple(a, b, settings, f);
}

}  // namespace unibody
