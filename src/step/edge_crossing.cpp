#include "step/edge_crossing.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "step/plan.hpp"

namespace unibody {

namespace {

constexpr double falls = 0.1;   // of g h^2, and of g h: how far a body may be from what bears it, and how fast it may leave it
constexpr double opens = 1e-3;  // of g h: the speed from which on a body leaves a face for good
constexpr double lies = 5e-3;   // of g h^2: a gap up to which a face has been reached

// A manifold with something that does not move by forces, as its body sees it.
struct Face {
  std::size_t manifold;
  Slot body;
  Vec3 normal;    // towards the body
  Vec3 velocity;  // m/s, of the body's centre against the face
  double gap;     // m
  double share;   // of the step, after which the body reaches it; infinite: it does not, or lies on it
};

// What bears a weight (m/s) on these faces: it leaves nothing of the weight that points into one of them.
template <class Bears>
Vec3 support(const Vec3& weight, std::span<const Face> faces, Bears&& bears) {
  constexpr int sweeps = 20;
  Vec3 sum = Vec3::Zero();
  std::vector<double> pushes(faces.size(), 0.0);
  for (int k = 0; k < sweeps; ++k)
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (!bears(faces[i])) continue;
      const double push = std::max(0.0, pushes[i] - faces[i].normal.dot(weight + sum));
      sum += (push - pushes[i]) * faces[i].normal, pushes[i] = push;
    }
  return sum;
}

// The faces of the round bodies of this rank, and what a step would do wrong at them.
class Crossings {
 public:
  explicit Crossings(const RankState& state)
      : state_(state),
        world_(state.world),
        weight_(state.step() * state.drives.gravity),
        fall_(weight_.norm() * state.step()),
        touching_(std::max(lies * fall_, 2 * tolerance_of_contacts(state.traits))) {}

  // Of the bodies that reach something within the step, all faces, body by body.
  std::vector<Face> faces() const {
    std::vector<Slot> reach, touched;
    for (const Manifold& m : state_.contacts.manifolds) {
      const Slot body = roller_of(m);
      if (body >= 0 && face_of(m, body).share < 1) reach.push_back(body);
    }
    std::vector<Face> faces;
    if (reach.empty()) return faces;
    std::ranges::sort(reach);
    for (const Manifold& m : state_.contacts.manifolds) {
      const Slot body = roller_of(m);
      if (body >= 0 && std::ranges::binary_search(reach, body)) faces.push_back(face_of(m, body));
      if (world_.is_static(m.slot_a) || world_.is_static(m.slot_b) || least_gap(m) > falls * fall_) continue;
      touched.push_back(m.slot_a), touched.push_back(m.slot_b);
    }
    std::ranges::sort(touched);
    std::erase_if(faces, [&](const Face& f) {
      return std::ranges::binary_search(touched, f.body) || state_.is_tied(world_.id[static_cast<std::size_t>(f.body)]);
    });
    std::ranges::stable_sort(faces, {}, &Face::body);
    return faces;
  }

  // What the predicted velocity of a body lacks, of which these are the faces (m/s).
  Vec3 correction(std::span<const Face> faces) const {
    const Face& next = *std::ranges::min_element(faces, {}, &Face::share);
    const double near = falls * fall_, slow = falls * weight_.norm(), leaves = opens * weight_.norm();
    const auto bore = [&](const Face& f) { return f.gap <= near && !(f.share < 1) && f.normal.dot(f.velocity) <= slow; };
    const Vec3 after = next.velocity - next.normal.dot(next.velocity) * next.normal;
    const auto bears = [&](const Face& f) { return &f == &next || (bore(f) && f.normal.dot(after) <= leaves); };
    if (std::ranges::none_of(faces, bore)) return Vec3::Zero();
    const Vec3 shift = support(weight_, faces, bore) - support(weight_, faces, bears);
    const Vec3 correction = (next.share + 0.5) * (shift - next.normal.dot(shift) * next.normal);  // the rest is the rows'
    // What hardly moves is pulled back by its weight, into the edge.
    return after.norm() > 2 * correction.norm() ? correction : Vec3(Vec3::Zero());
  }

 private:
  // The round home body of a manifold with a static one; -1: it has none.
  Slot roller_of(const Manifold& m) const {
    if (m.time > 0 || world_.is_static(m.slot_a) == world_.is_static(m.slot_b)) return -1;
    const Slot body = world_.is_static(m.slot_a) ? m.slot_b : m.slot_a;
    const BodyProperties& of = world_.properties[static_cast<std::size_t>(body)];
    return world_.is_home(body) && of.is_dynamic() && is_round(of.shape) ? body : -1;
  }

  double least_gap(const Manifold& m) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) least = std::min(least, state_.contacts.points[k].gap);
    return least;
  }

  Vec3 velocity_at(Slot s, const Vec3& arm) const {
    const auto i = static_cast<std::size_t>(s);
    return world_.velocity[i] + world_.angular_velocity_of(i).cross(arm);
  }

  Face face_of(const Manifold& m, Slot body) const {
    const Slot other = body == m.slot_a ? m.slot_b : m.slot_a;
    Face face{static_cast<std::size_t>(&m - state_.contacts.manifolds.data()),
              body,
              body == m.slot_a ? m.normal : Vec3(-m.normal),
              Vec3::Zero(),
              std::numeric_limits<double>::infinity(),
              std::numeric_limits<double>::infinity()};
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      const ContactPoint& p = state_.contacts.points[k];
      const Vec3 ground = velocity_at(other, arm_of(world_, m, p, other));
      const double closing = -face.normal.dot(velocity_at(body, arm_of(world_, m, p, body)) - ground);
      if (p.gap < face.gap) face.gap = p.gap, face.velocity = world_.velocity[static_cast<std::size_t>(body)] - ground;
      if (p.gap > touching_ && p.gap < state_.step() * closing)
        face.share = std::min(face.share, p.gap / (state_.step() * closing));
    }
    return face;
  }

  const RankState& state_;
  const World& world_;
  Vec3 weight_;             // m/s, that of a step
  double fall_, touching_;  // m
};

}  // namespace

void correct_crossings(RankState& state, System& system) {
  state.rows.crossings.clear();
  if (state.traits.complies || state.scene.solver.level == Level::velocity || state.drives.gravity.isZero(0)) return;
  const Crossings crossings(state);
  const std::vector<Face> faces = crossings.faces();
  for (std::size_t from = 0, to; from < faces.size(); from = to) {
    for (to = from; to < faces.size() && faces[to].body == faces[from].body;) ++to;
    const std::span<const Face> of_body = std::span(faces).subspan(from, to - from);
    const Vec3 correction = crossings.correction(of_body);
    if (correction.isZero(0)) continue;
    const Face& bearing = *std::ranges::min_element(of_body, {}, &Face::gap);
    const auto body = static_cast<std::size_t>(bearing.body);
    Eigen::Map<Vec3>(system.bodies[body].v) += correction;
    const double mass = state.contacts.manifolds[bearing.manifold].slot_a == bearing.body ? state.world.properties[body].mass
                                                                                          : -state.world.properties[body].mass;
    state.rows.crossings.push_back({bearing.manifold, mass * correction});
  }
  std::ranges::sort(state.rows.crossings, {}, &CrossingImpulse::manifold);
}

}  // namespace unibody
