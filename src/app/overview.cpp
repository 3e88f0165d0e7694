#include "app/overview.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/contact_times.hpp"
#include "app/misplaced.hpp"
#include "app/round_laws.hpp"
#include "collide/collide.hpp"
#include "core/checked.hpp"
#include "core/exact_sum.hpp"
#include "core/largest.hpp"
#include "core/text.hpp"
#include "report/changing_bodies.hpp"
#include "world/shapes.hpp"

namespace unibody {

namespace {

constexpr double least_overlap = 0.01;                    // of the smaller body's size: less is how bodies rest on each other
constexpr double largest_usual = 50, least_usual = 1e-4;  // m: beyond these a scene is probably in other units

std::string place(const double* at) {
  std::string text = "[";
  for (int k = 0; k < 3; ++k) text += (k == 0 ? "" : ", ") + number_text(at[k] == 0 ? 0 : at[k], 3);
  return text + "]";
}

std::string counted(std::int64_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 || one.ends_with("ic") || one.ends_with("fixed") ? "" : "s");
}

// What there is to tell of the bodies of all ranks. The nodes of cloths, threads and solids are not counted among them, but
// their places and sizes are in the extents.
struct Bodies {
  std::array<std::int64_t, 3> moved{};                    // dynamic, kinematic, fixed
  std::array<std::int64_t, shape_names.size()> shapes{};  // of dynamic ones
  std::int64_t nodes = 0;
  double mass = 0;                          // kg, with nodes
  double smallest = HUGE_VAL, largest = 0;  // m, of dynamic ones: least extent; longest side of a bounding box
  std::array<double, 3> low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // m, of dynamic ones
};

Bodies count_bodies(const Simulation& simulation) {
  const World& world = simulation.world;
  const Scene& scene = simulation.scene;
  Bodies found;
  Id end = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) end = std::min(end, group.first), found.nodes += group.count;
  ExactSum mass;
  std::array<double, 8> extremes;  // negative where the least counts
  extremes.fill(-HUGE_VAL);
  for (std::size_t i = 0; i < world.homes; ++i) {
    const BodyProperties& body = world.properties[i];
    const Vec3 half = bounding_half_extents(body.shape, world.orientation_of(i));
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      extremes[at] = std::max(extremes[at], half[k] - world.position[i][k]);
      extremes[3 + at] = std::max(extremes[3 + at], half[k] + world.position[i][k]);
    }
    extremes[6] = std::max(extremes[6], -smallest_size(body.shape)), extremes[7] = std::max(extremes[7], 2 * half.maxCoeff());
    mass += body.mass;
    if (world.id[i] < end) ++found.shapes[static_cast<std::size_t>(body.shape.kind)];
  }
  make_largest(simulation.comm(), extremes);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, found.shapes.data(), found.shapes.size(), MPI_INT64_T, MPI_SUM, simulation.comm()));
  found.mass = all_sums(simulation.comm(), std::span(&mass, 1))[0];
  for (std::size_t k = 0; k < 3; ++k) found.low[k] = -extremes[k], found.high[k] = extremes[3 + k];
  found.smallest = -extremes[6], found.largest = extremes[7];
  for (const std::int64_t count : found.shapes) found.moved[0] += count;
  for (std::size_t i = world.first_static(); i < world.size(); ++i)  // on every rank
    ++found.moved[world.properties[i].motion == Motion::kinematic ? 1 : 2];
  return found;
}

// Pairs that overlap at the start by more than `least_overlap`, and the deepest of them.
struct Overlaps {
  std::int64_t count = 0;
  double depth = 0;  // m
  std::array<Id, 2> deepest{};
};

Overlaps find_overlaps(const Simulation& simulation) {
  const World& world = simulation.world;
  Overlaps here;
  std::array<Id, 2> before{-1, -1};
  for (const Manifold& m : simulation.contacts.manifolds) {
    if (!counts_here(world, m) || m.time > 0) continue;
    double depth = 0;
    for (std::uint32_t k = 0; k < m.count; ++k) depth = std::max(depth, -simulation.contacts.points[m.first + k].gap);
    double size = HUGE_VAL;
    for (const Slot slot : {m.slot_a, m.slot_b})
      if (!world.is_static(slot)) size = std::min(size, smallest_size(world.properties[static_cast<std::size_t>(slot)].shape));
    if (!(depth > least_overlap * size)) continue;
    const std::array<Id, 2> pair{m.id_a, m.id_b};
    if (pair != before) ++here.count, before = pair;
    if (depth > here.depth || (depth == here.depth && pair < here.deepest)) here.depth = depth, here.deepest = pair;
  }
  Overlaps all;
  const MPI_Comm comm = simulation.comm();
  check_mpi(MPI_Allreduce(&here.count, &all.count, 1, MPI_INT64_T, MPI_SUM, comm));
  all.depth = largest_of_ranks(comm, here.depth);
  constexpr Id no_body = std::numeric_limits<Id>::max();
  bool is_first = here.depth == all.depth && here.depth > 0;
  for (std::size_t k = 0; k < 2; ++k) {
    all.deepest[k] = is_first ? here.deepest[k] : no_body;
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all.deepest[k], 1, MPI_INT64_T, MPI_MIN, comm));
    is_first = is_first && all.deepest[k] == here.deepest[k];
  }
  return all;
}

std::string shapes_text(const Bodies& bodies) {
  std::string text;
  for (std::size_t k = 0; k < bodies.shapes.size(); ++k)
    if (bodies.shapes[k] > 0)
      text += (text.empty() ? " (" : ", ") + std::to_string(bodies.shapes[k]) + " " + std::string(shape_names[k]);
  return text.empty() ? "" : text + ")";
}

void tell_scene(const Simulation& simulation, const Bodies& bodies, std::vector<std::string>& lines) {
  const Scene& scene = simulation.scene;
  lines.push_back(scene.path + (scene.title.empty() ? "" : ": " + scene.title));
  lines.push_back("  bodies  " + counted(bodies.moved[0], "dynamic") + shapes_text(bodies) + ", " +
                  counted(bodies.moved[1], "kinematic") + ", " + counted(bodies.moved[2], "fixed") +
                  (bodies.nodes > 0 ? "; " + counted(bodies.nodes, "node") + " of cloths, threads and solids" : "") +
                  (scene.joints.empty() ? "" : "; " + counted(static_cast<std::int64_t>(scene.joints.size()), "joint")));
  if (bodies.moved[0] + bodies.nodes > 0)
    lines.push_back("  what moves  " + number_text(bodies.mass, 3) + " kg, from " + number_text(bodies.smallest, 3) +
                    " m (thinnest) to " + number_text(bodies.largest, 3) + " m (longest), between " + place(bodies.low.data()) +
                    " and " + place(bodies.high.data()) + " m");
  for (std::string& line : told_changes(scene)) lines.push_back(std::move(line));
}

std::string iterations_text(const SolverSettings& used) {
  if (used.iterations) return "at most " + counted(*used.iterations, "iteration") + " a step";
  const std::string most = counted(most_automatic_iterations, "iteration");
  if (used.accuracy) return "at most " + most + " a step";
  return "at most " + std::to_string(default_iterations) + " iterations a step (up to " + most + " where they cost little)";
}

std::string coarse_level_text(const Simulation& simulation) {
  if (!simulation.scene.solver.coarse) return "";
  return simulation.coarse.exists() ? ", a coarse level of what touches nothing"
                                    : ", no coarse level, since there are no cloths, threads or solids";
}

void tell_run(const Simulation& simulation, std::vector<std::string>& lines) {
  const Scene& scene = simulation.scene;
  const SolverSettings used = simulation.settings_used();
  int ranks = 1;
  check_mpi(MPI_Comm_size(simulation.comm(), &ranks));
  const double bytes = largest_of_ranks(simulation.comm(), static_cast<double>(simulation.bytes()));
  lines.push_back("  run  " + counted(scene.time.frames, "frame") + " of " + number_text(scene.time.frame, 3) + " s, " +
                  counted(scene.time.substeps, "step") + " each, on " + counted(ranks, "rank") + "; " +
                  number_text(bytes / 1e6, 3) + " MB on the largest at the start");
  lines.push_back("  plan  " + used.name + ", " + iterations_text(used) +
                  ", stages: " + std::string(stages_names[static_cast<std::size_t>(used.stages)]) + ", tolerance " +
                  number_text(*used.tolerance, 3) + " m" +
                  (used.accuracy ? " for an accuracy of " + number_text(*used.accuracy, 3) : "") + ", contacts from " +
                  number_text(*used.margin, 3) + " m on" + coarse_level_text(simulation));
}

void find_faults(const Simulation& simulation, const Bodies& bodies, std::vector<std::string>& warnings) {
  const Scene& scene = simulation.scene;
  if (const Overlaps overlaps = find_overlaps(simulation); overlaps.count > 0 && simulation.when.steps_done == 0)
    warnings.push_back(counted(overlaps.count, "pair") +
                       " of bodies overlap at the start by more than 1 % of the smaller one's size, the deepest by " +
                       number_text(overlaps.depth, 3) + " m: " + name_with_line(scene, overlaps.deepest[0]) + " and " +
                       name_with_line(scene, overlaps.deepest[1]) +
                       "; they will be pushed apart: move them, unless that is meant");
  if (simulation.when.steps_done == 0)
    for (std::string& warning : misplaced_bodies(simulation)) warnings.push_back(std::move(warning));
  if (scene.gravity.z() > 0)
    warnings.push_back("gravity points up (" + number_text(scene.gravity.z(), 3) +
                       " m/s^2 along z): most scenes have it along -z");
  const bool any = bodies.moved[0] + bodies.nodes > 0;
  const double step = scene.time.frame / scene.time.substeps, fall = scene.largest_gravity() * step * step;
  if (any && fall > bodies.smallest)
    warnings.push_back("a step of " + number_text(step, 3) + " s lets a body fall by " + number_text(fall, 3) +
                       " m, more than the smallest one's size of " + number_text(bodies.smallest, 3) +
                       " m: more time.substeps, or a shorter time.frame, would follow it");
  for (std::string& warning : unresolved_contacts(simulation)) warnings.push_back(std::move(warning));
  for (std::string& warning : laws_without_effect(simulation)) warnings.push_back(std::move(warning));
  if (any && (bodies.smallest > largest_usual || bodies.largest < least_usual))
    warnings.push_back("all that moves is " + std::string(bodies.smallest > largest_usual ? "thicker than " : "smaller than ") +
                       number_text(bodies.smallest > largest_usual ? largest_usual : least_usual, 3) +
                       " m: lengths are in metres; are these in another unit?");
  int ranks = 1;
  check_mpi(MPI_Comm_size(simulation.comm(), &ranks));
  if (any && !scene.bodies_come_and_go() && ranks > bodies.moved[0] + bodies.nodes)
    warnings.push_back(counted(ranks, "rank") + " for " + counted(bodies.moved[0] + bodies.nodes, "dynamic") +
                       " bodies: the others have nothing to do; fewer ranks are faster");
}

}  // namespace

Overview overview_of(const Simulation& simulation) {
  Overview overview;
  const Bodies bodies = count_bodies(simulation);
  tell_scene(simulation, bodies, overview.lines);
  tell_run(simulation, overview.lines);
  find_faults(simulation, bodies, overview.warnings);
  return overview;
}

}  // namespace unibody
