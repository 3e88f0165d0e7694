#include "scene/stiffness.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "constraints/constraint_types.hpp"

namespace unibody {

namespace {

// h^2 D^T W D / E of the rows of one constraint, the largest.
template <class C>
double stiffness_of(const Constraint<C>& c, const Scene& scene, double step) {
  std::array<Vec4d, C::parameter_names.size()> parameters;
  for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] = broadcast(c.parameters[p]);
  std::array<Vec3x4, C::stencil> x;
  std::array<double, C::stencil> inverse_mass;
  for (std::size_t e = 0; e < C::stencil; ++e) {
    const Body body = scene.body(c.ids[e]);
    const Vec3& at = body.state.position;
    x[e] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())};
    inverse_mass[e] = body.properties.is_dynamic() ? 1 / body.properties.mass : 0;
  }
  Rows<C::stencil, C::rows> rows;
  C::evaluate(parameters, x, rows);
  double worst = 0;
  for (std::size_t k = 0; k < C::rows; ++k) {
    double moved = 0;  // 1/kg
    for (std::size_t e = 0; e < C::stencil; ++e) moved += inverse_mass[e] * dot(rows.gradient[k][e], rows.gradient[k][e])[0];
    if (moved > 0)
      worst =
          c.compliance[k] > 0 ? std::max(worst, step * step * moved / c.compliance[k]) : std::numeric_limits<double>::infinity();
  }
  return worst;
}

// f(constraint) of every one of the scene, once, with the first of its bodies.
template <typename F>
void for_each_constraint(const Scene& scene, F&& f) {
  ConstraintSet touching;
  for (const ConstraintGroup& group : scene.constraint_groups)
    for (Id id = group.first; id < group.first + group.count; ++id) {
      for_each_type(touching, [](auto, auto& list) { list.clear(); });
      group.touching(id, touching);
      for_each_type(touching, [&]<class C>(auto, const std::vector<Constraint<C>>& list) {
        for (const auto& c : list)
          if (*std::min_element(c.ids.begin(), c.ids.end()) == id) f(c);
      });
    }
}

// Place (m) and velocity (m/s) after a step of free motion; nothing of a node that another body holds.
std::optional<std::pair<Vec3, Vec3>> free_motion(const Scene& scene, Id id, double step) {
  const Body body = scene.body(id);
  const auto pin = std::ranges::lower_bound(scene.pins, id, {}, &Pin::id);
  const bool pinned = pin != scene.pins.end() && pin->id == id && pin->release > 0;
  if (pinned && pin->body >= 0) return std::nullopt;
  const Vec3 gained = step * (scene.gravity + body.properties.force / body.properties.mass);
  return std::pair{body.state.position, pinned ? Vec3(Vec3::Zero()) : Vec3(body.state.velocity + gained)};
}

}  // namespace

double stiffness_number(const Scene& scene) {
  const double step = scene.time.frame / scene.time.substeps;
  double worst = 0;
  for_each_constraint(scene, [&](const auto& c) { worst = std::max(worst, stiffness_of(c, scene, step)); });
  return worst;
}

double stiffness_number(const Scene& scene, const ConstraintSet& constraints, double enough) {
  const double step = scene.time.frame / scene.time.substeps;
  double worst = 0;
  for_each_type(constraints, [&]<class C>(auto, const ConstraintList<C>& list) {
    if constexpr (fills_space<C>)
      for (auto c = list.begin(); c != list.end() && worst <= enough; ++c) worst = std::max(worst, stiffness_of(*c, scene, step));
  });
  return worst;
}

double edge_motion(const Scene& scene) {
  const double step = scene.time.frame / scene.time.substeps;
  double worst = 0;
  for_each_constraint(scene, [&]<class C>(const Constraint<C>& c) {
    if constexpr (joins_edges<C>) {
      std::array<std::optional<std::pair<Vec3, Vec3>>, C::stencil> ends;
      for (std::size_t e = 0; e < C::stencil; ++e) ends[e] = free_motion(scene, c.ids[e], step);
      for (std::size_t e = 1; e < C::stencil; ++e)
        for (std::size_t f = 0; f < e; ++f) {
          if (!ends[e] || !ends[f]) continue;
          const double moved = step * (ends[e]->second - ends[f]->second).norm();
          if (moved > 0) worst = std::max(worst, moved / (ends[e]->first - ends[f]->first).norm());
        }
    }
  });
  return worst;
}

}  // namespace unibody
