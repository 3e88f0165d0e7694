#include "app/bad_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"
#include "report/measure.hpp"
#include "world/limits.hpp"

namespace unibody {

namespace {

std::string named(const Scene& scene, Id id) { return "body " + std::to_string(id) + " (" + scene.body_name(id) + ")"; }

template <std::size_t n>
bool holds(const std::array<Id, n>& ids, Id id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

template <std::size_t n>
bool all_finite(const std::array<double, n>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

// All bodies of a constraint but one, in words.
template <std::size_t n>
std::string others(const Scene& scene, const std::array<Id, n>& ids, Id id) {
  std::string text;
  for (const Id other : ids)
    if (other >= 0 && other != id) text += (text.empty() ? " with " : ", ") + named(scene, other);
  return text;
}

std::optional<std::string> contact_of(const Scene& scene, const Simulation& simulation, Id id) {
  for (const Manifold& m : simulation.contacts.manifolds)
    if (m.id_a == id || m.id_b == id) return "contact" + others(scene, std::array{m.id_a, m.id_b}, id);
  for (const SurfaceContact& c : simulation.contacts.surface)
    if (holds(c.ids, id)) return "contact of a surface" + others(scene, c.ids, id);
  return std::nullopt;
}

// One whose multiplier is not finite, or else the first.
std::optional<std::string> constraint_of(const Scene& scene, const Simulation& simulation, Id id) {
  std::optional<std::string> found;
  bool guilty = false;
  for_each_type(simulation.ties.constraints, [&]<class C>(auto, const ConstraintList<C>& list) {
    const auto& multipliers = simulation.history.of<ConstraintBatch<C>>();
    for (std::size_t i = 0; i < list.size() && !guilty; ++i) {
      if (!holds(list[i].ids, id)) continue;
      guilty = i < multipliers.size() && !all_finite(multipliers[i]);
      if (guilty || !found) found = std::string(C::name) + others(scene, list[i].ids, id);
    }
  });
  for (std::size_t i = 0; i < simulation.ties.joints.size() && !guilty; ++i) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(simulation.ties.joints[i])];
    if (!holds(joint.ids, id)) continue;
    guilty = i < simulation.history.joints().size() && !all_finite(simulation.history.joints()[i].value);
    if (guilty || !found)
      found = "joint " + std::to_string(simulation.ties.joints[i]) + " (" +
              std::string(joint_names[static_cast<std::size_t>(joint.kind)]) + ")" + others(scene, joint.ids, id);
  }
  return found;
}

// What is wrong with the body.
std::string fault_of(const Scene& scene, const World& world, Id id) {
  const BodyState state = world.state(static_cast<std::size_t>(world.find(id)));
  const double place = state.position.cwiseAbs().maxCoeff(), speed = state.velocity.norm();
  if (place > farthest)
    return named(scene, id) + " is " + exponent_text(place) + " m from the origin, beyond " + exponent_text(farthest) + " m; ";
  if (speed >= fastest && std::isfinite(speed))
    return named(scene, id) + " moves at " + exponent_text(speed) + " m/s, faster than light; ";
  return "the state of " + named(scene, id) + " is no longer finite; ";
}

std::string describe(const Scene& scene, const Simulation& simulation, Id id, const std::string& when) {
  const std::string text = when + ": " + fault_of(scene, simulation.world, id);
  if (const auto constraint = constraint_of(scene, simulation, id)) return text + "constraint: " + *constraint;
  if (const auto contact = contact_of(scene, simulation, id)) return text + "constraint: " + *contact;
  return text + "no constraint acts on it";
}

}  // namespace

void stop_if_not_finite(MPI_Comm comm, const Scene& scene, const Simulation& simulation, std::int64_t frame, int substep) {
  const Id bad = first_bad_body(comm, simulation.world);
  if (bad < 0) return;
  int rank = 0, teller = 0;  // rank 0 tells of a kinematic body, which is home nowhere
  check_mpi(MPI_Comm_rank(comm, &rank));
  const auto homes_end = simulation.world.id.begin() + static_cast<std::ptrdiff_t>(simulation.world.homes);
  if (std::binary_search(simulation.world.id.begin(), homes_end, bad)) teller = rank;  // it knows all that acts on the body
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &teller, 1, MPI_INT, MPI_MAX, comm));
  std::array<char, 512> text{};
  std::string when = "frame " + std::to_string(frame);
  if (scene.time.substeps > 1) when += ", step " + std::to_string(substep + 1) + " of " + std::to_string(scene.time.substeps);
  if (teller == rank) describe(scene, simulation, bad, when).copy(text.data(), text.size() - 1);
  check_mpi(MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, teller, comm));
  throw RunError(text.data());
}

}  // namespace unibody
