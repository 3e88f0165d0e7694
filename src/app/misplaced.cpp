#include "app/misplaced.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "core/checked.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"
#include "core/text.hpp"

namespace unibody {

namespace {

constexpr Id none = std::numeric_limits<Id>::max();

// How many there are, and the first of them.
struct Found {
  std::int64_t count = 0;
  Id first = none;

  void add(Id id) { ++count, first = std::min(first, id); }
  void unite(MPI_Comm comm) {
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, comm));
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, comm));
  }
};

void find_behind_planes(const Simulation& simulation, std::vector<std::string>& warnings) {
  const World& world = simulation.world;
  const TouchRules& rules = simulation.scene.touch_rules;
  const auto may_touch = [&](Id a, Id b) { return !rules.any() || rules.may_touch(a, b); };
  for (std::size_t p = world.first_static(); p < world.size(); ++p) {
    if (world.properties[p].shape.kind != ShapeKind::plane) continue;
    const Vec3 normal = world.orientation_of(p) * Vec3::UnitZ();
    Found behind;
    for (std::size_t i = 0; i < world.homes; ++i)
      if (normal.dot(world.position[i] - world.position[p]) < 0 && may_touch(world.id[i], world.id[p])) behind.add(world.id[i]);
    behind.unite(simulation.comm());
    if (behind.count == 0) continue;
    const bool one = behind.count == 1;
    warnings.push_back((one ? "a body starts" : std::to_string(behind.count) + " bodies start") + " behind the plane " +
                       name_with_line(simulation.scene, world.id[p]) + ", " + (one ? "" : "the first of them ") +
                       name_with_line(simulation.scene, behind.first) +
                       ": a plane is solid on the side that its normal leaves, and " +
                       (one ? "it will be pushed out" : "they will be pushed out"));
  }
}

// Where one of very many bodies is fifty times as far from the middle as they are in the mean, their extent says nothing of them.
void find_outlier(const Simulation& simulation, std::vector<std::string>& warnings) {
  constexpr double times_the_mean = 50, least_count = 200;
  const World& world = simulation.world;
  const MPI_Comm comm = simulation.comm();
  std::array<ExactSum, 4> sums;
  for (std::size_t i = 0; i < world.homes; ++i) {
    for (int k = 0; k < 3; ++k) sums[static_cast<std::size_t>(k)] += world.position[i][k];
    sums[3] += 1;
  }
  const std::vector<double> totals = all_sums(comm, sums);
  const double count = totals[3];
  if (count < least_count) return;
  const Vec3 middle = Vec3(totals[0], totals[1], totals[2]) / count;
  ExactSum distances;
  double farthest = 0;
  for (std::size_t i = 0; i < world.homes; ++i) {
    const double distance = (world.position[i] - middle).norm();
    distances += distance, farthest = std::max(farthest, distance);
  }
  const double mean = all_sums(comm, std::span(&distances, 1))[0] / count;
  farthest = largest_of_ranks(comm, farthest);
  if (!(farthest > times_the_mean * mean)) return;
  Found outlier;
  for (std::size_t i = 0; i < world.homes; ++i)
    if ((world.position[i] - middle).norm() == farthest) outlier.add(world.id[i]);
  outlier.unite(comm);
  warnings.push_back(name_with_line(simulation.scene, outlier.first) + " starts " + number_text(farthest, 3) +
                     " m from the middle of what moves, " + number_text(farthest / mean, 3) +
                     " times as far as the mean: is its position meant?");
}

}  // namespace

std::string name_with_line(const Scene& scene, Id id) {
  const int line = scene.group_of(id).line;
  return scene.body_name(id) + (line > 0 ? " (line " + std::to_string(line) + ")" : "");
}

std::vector<std::string> misplaced_bodies(const Simulation& simulation) {
  std::vector<std::string> warnings;
  find_behind_planes(simulation, warnings);
  find_outlier(simulation, warnings);
  return warnings;
}

}  // namespace unibody
