#include "report/stretch.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/checked.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"

namespace unibody {

namespace {

Vec3 position_of(const World& world, Id id) { return world.position[static_cast<std::size_t>(world.find(id))]; }

void stretches_of(const World& world, const Constraint<Distance>& c, std::vector<double>& out) {
  const double length = (position_of(world, c.ids[0]) - position_of(world, c.ids[1])).norm();
  out.push_back(length / c.parameters[0] - 1);
}

void stretches_of(const World& world, const Constraint<Membrane>& c, std::vector<double>& out) {
  const Vec3 a = position_of(world, c.ids[0]), d1 = position_of(world, c.ids[1]) - a, d2 = position_of(world, c.ids[2]) - a;
  const Vec3 f1 = c.parameters[0] * d1, f2 = c.parameters[1] * d1 + c.parameters[2] * d2;
  const double mean = 0.5 * (f1.dot(f1) + f2.dot(f2)), half = 0.5 * (f1.dot(f1) - f2.dot(f2));
  const double radius = std::hypot(half, f1.dot(f2));  // Mohr's circle of F^T F
  out.push_back(std::sqrt(mean + radius) - 1);
  out.push_back(std::sqrt(std::max(0.0, mean - radius)) - 1);
}

template <class C>
void stretches_of(const World&, const Constraint<C>&, std::vector<double>&) {}

}  // namespace

std::vector<Stretch> measure_stretch(MPI_Comm comm, const World& world, const ConstraintSet& constraints,
                                     std::size_t material_count) {
  std::vector<ExactSum> squares(material_count);
  std::vector<double> largest(material_count, 0);
  std::vector<std::int64_t> counts(material_count, 0);
  std::vector<double> found;
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list) {
      if (!counts_here(world, c)) continue;
      found.clear();
      stretches_of(world, c, found);
      const auto material = static_cast<std::size_t>(world.properties[static_cast<std::size_t>(world.find(c.ids[0]))].material);
      for (const double s : found) {
        squares[material] += s * s;
        largest[material] = std::max(largest[material], std::abs(s));
        ++counts[material];
      }
    }
  });
  const auto total = all_sums(comm, squares);
  make_largest(comm, largest);
  const int n = mpi_count(material_count);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), n, MPI_INT64_T, MPI_SUM, comm));
  std::vector<Stretch> result(material_count);
  for (std::size_t m = 0; m < material_count; ++m)
    result[m] = {largest[m], counts[m] > 0 ? std::sqrt(total[m] / static_cast<double>(counts[m])) : 0, counts[m]};
  return result;
}

std::vector<NamedValue> constraint_columns(MPI_Comm comm, const Scene& scene, const World& world,
                                           const ConstraintSet& constraints, std::span<const double> residuals) {
  std::vector<NamedValue> columns;
  if (scene.constraint_groups.empty()) return columns;
  const auto stretches = measure_stretch(comm, world, constraints, scene.materials.size());
  for (std::size_t m = 0; m < stretches.size(); ++m) {
    if (stretches[m].count == 0) continue;
    columns.push_back({"stretch_max[" + scene.materials[m] + "] (1)", stretches[m].max});
    columns.push_back({"stretch_rms[" + scene.materials[m] + "] (1)", stretches[m].rms});
  }
  std::array<std::int64_t, ConstraintTypes::size> counts{};
  for_each_type(constraints, [&](auto type, const auto& list) { counts[type.value] = static_cast<std::int64_t>(list.size()); });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, MPI_SUM, comm));
  for_each_type(constraints, [&](auto type, const auto& list) {
    if (counts[type.value] == 0) return;
    using Type = typename std::remove_cvref_t<decltype(list)>::value_type::type;
    columns.push_back({"residual_" + std::string(Type::name) + " (m)", residuals[type.value]});
  });
  return columns;
}

}  // namespace unibody
