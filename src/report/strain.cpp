#include "report/strain.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/checked.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"

namespace unibody {

namespace {

// F of one tetrahedron: see Tetrahedron.
template <class C>
Eigen::Matrix3d deformation_gradient(const World& world, const Constraint<C>& c) {
  const auto place = [&](std::size_t e) -> const Vec3& { return world.position[static_cast<std::size_t>(world.find(c.ids[e]))]; };
  Eigen::Matrix3d edges, X;
  edges << place(1) - place(0), place(2) - place(0), place(3) - place(0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) X(i, j) = c.parameters[static_cast<std::size_t>(3 * i + j)];
  return edges * X;
}

// The elastic energy (J), the sum of c_k^2 / 2 E_k over the rows: with the rows' eigenvectors, of one volumetric and five
// deviatoric strains.
template <class C>
double energy_of(const Constraint<C>& c, const Eigen::Matrix3d& strain, double volume) {
  const double length = c.parameters[9], trace = strain.trace();
  const double volumetric = trace * trace / 3, deviatoric = std::max(0.0, strain.squaredNorm() - volumetric);
  double weight = 0.5 * length * length;
  if constexpr (std::is_same_v<C, TetrahedronCurrentVolume>) weight *= std::max(volume, C::least_share);
  return weight * (volumetric / c.compliance[0] + deviatoric / c.compliance[1]);
}

}  // namespace

std::vector<Strain> measure_strain(MPI_Comm comm, const World& world, const ConstraintSet& constraints,
                                   std::size_t material_count) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<ExactSum> energy(material_count);
  std::vector<double> extremes(3 * material_count, -infinity);  // of each: strain, volume, -volume
  std::vector<std::int64_t> counts(2 * material_count, 0);      // of each: all, inverted
  const auto measure = [&](const auto& c) {
    if (!counts_here(world, c)) return;
    const auto m = static_cast<std::size_t>(world.properties[static_cast<std::size_t>(world.find(c.ids[0]))].material);
    const Eigen::Matrix3d F = deformation_gradient(world, c);
    const Eigen::Matrix3d strain = 0.5 * (F.transpose() * F - Eigen::Matrix3d::Identity());
    const Vec3 principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(strain, Eigen::EigenvaluesOnly).eigenvalues();
    const double volume = F.determinant();
    extremes[3 * m] = std::max(extremes[3 * m], principal.cwiseAbs().maxCoeff());
    extremes[3 * m + 1] = std::max(extremes[3 * m + 1], volume);
    extremes[3 * m + 2] = std::max(extremes[3 * m + 2], -volume);
    energy[m] += energy_of(c, strain, volume);
    ++counts[2 * m];
    counts[2 * m + 1] += volume < 0 ? 1 : 0;
  };
  for_each_solid_type(constraints, [&](const auto& list) { std::for_each(list.begin(), list.end(), measure); });
  const auto energies = all_sums(comm, energy);
  make_largest(comm, extremes);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, MPI_SUM, comm));
  std::vector<Strain> result(material_count);
  for (std::size_t m = 0; m < material_count; ++m)
    if (counts[2 * m] > 0)
      result[m] = {extremes[3 * m], -extremes[3 * m + 2], extremes[3 * m + 1], counts[2 * m], counts[2 * m + 1], energies[m]};
  return result;
}

std::vector<NamedValue> strain_columns(MPI_Comm comm, const Scene& scene, const World& world, const ConstraintSet& constraints) {
  std::vector<NamedValue> columns;
  if (scene.constraint_groups.empty()) return columns;
  const auto strains = measure_strain(comm, world, constraints, scene.materials.size());
  for (std::size_t m = 0; m < strains.size(); ++m) {
    if (strains[m].count == 0) continue;
    const std::string of = "[" + scene.materials[m] + "]";
    columns.push_back({"strain_max" + of + " (1)", strains[m].max});
    columns.push_back({"volume_min" + of + " (1)", strains[m].volume_min});
    columns.push_back({"volume_max" + of + " (1)", strains[m].volume_max});
    columns.push_back({"inverted" + of + " (1)", static_cast<double>(strains[m].inverted)});
    columns.push_back({"elastic_energy" + of + " (J)", strains[m].energy});
  }
  return columns;
}

}  // namespace unibody
