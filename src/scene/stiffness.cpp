#include "scene/stiffness.hpp"

#include <algorithm>
#include <limits>

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

}  // namespace

double stiffness_number(const Scene& scene) {
  const double step = scene.time.step / scene.time.substeps;
  double worst = 0;
  ConstraintSet touching;
  for (const ConstraintGroup& group : scene.constraint_groups)
    for (Id id = group.first; id < group.first + group.count; ++id) {
      for_each_type(touching, [](auto, auto& list) { list.clear(); });
      group.touching(id, touching);
      for_each_type(touching, [&]<class C>(auto, const std::vector<Constraint<C>>& list) {
        for (const auto& c : list)  // once, with the first of its bodies
          if (*std::min_element(c.ids.begin(), c.ids.end()) == id) worst = std::max(worst, stiffness_of(c, scene, step));
      });
    }
  return worst;
}

}  // namespace unibody
