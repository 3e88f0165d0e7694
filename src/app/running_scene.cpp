#include "app/running_scene.hpp"

#include "app/bad_body.hpp"
#include "app/continued.hpp"
#include "app/restart.hpp"
#include "changes/changes.hpp"
#include "checkpoint/checkpoint.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "step/accuracy.hpp"
#include "step/build.hpp"
#include "step/step_parts.hpp"

namespace unibody {

void check_ranks_of_solver(MPI_Comm comm, const Scene& scene) {
  int size = 1;
  check_mpi(MPI_Comm_size(comm, &size));
  if (size == 1) return;
  if (scene.solver.name == "gauss_seidel" && scene.solver.order == Order::sequential)
    throw InputError(scene.path + ": key 'solver.order': found sequential on " + std::to_string(size) +
                     " ranks, expected coloured (a sequential sweep runs on one rank only)");
  if (scene.solver.name == "newton")
    throw InputError(scene.path + ": key 'solver.name': found newton on " + std::to_string(size) +
                     " ranks, expected an iterative solver (newton runs on one rank only)");
}

RunningScene::RunningScene(MPI_Comm comm, Scene& scene, const Options& options)
    : simulation(comm, scene, clock, options.shared_memory),
      comm_(comm),
      scene_(scene),
      options_(options),
      balance_(comm, options.random_partition, options.rebalance, scene.constraint_groups) {}

std::int64_t RunningScene::start() {
  std::int64_t frame = 0;
  if (!scene_.events.empty()) fix_scene();  // as it is before they change it
  if (options_.restart.empty()) {
    start_past(scene_, simulation.history);
    if (options_.continue_from.empty())
      simulation.world = build_world(comm_, scene_);
    else
      told_ = continue_from(comm_, options_.continue_from, scene_, simulation);
  } else {
    frame = restore(comm_, scene_, options_, simulation);
    repeat_past(scene_, simulation.history);
  }
  simulation.when.steps_done = frame * scene_.time.substeps;
  simulation.resolve_automatic_settings();
  check_accuracy(simulation);
  if (options_.restart.empty()) simulation.make_constraints();
  simulation.move_homes(balance_.homes(parts_of(simulation)));
  return frame;
}

void RunningScene::start_frame(std::int64_t frame) {
  if (scene_.events.empty() && !scene_.bodies_come_and_go()) return;
  if (change_scene(simulation, scene_, frame) != Changed::much) return;
  simulation.move_homes(balance_.homes(parts_of(simulation)));
  balance_.changed();
}

StepReport RunningScene::step(const StepRequest& request, std::int64_t frame, int substep) {
  StepReport report = simulation.step(request);
  stop_if_not_finite(comm_, scene_, simulation, frame, substep);  // before anything looks for contacts among such bodies
  stop_if_not_held(report, frame);
  return report;
}

void RunningScene::stop_if_not_held(const StepReport& report, std::int64_t frame) const {
  const auto [first, second] = report.guard.not_held;
  if (first < 0) return;
  const auto name = [&](Id id) { return "body " + std::to_string(id) + " (" + scene_.body_name(id) + ")"; };
  throw RunError("frame " + std::to_string(frame) + ": " + name(first) + " and the surface of " + name(second) +
                 " pass through each other, and could not be held apart: the step asks for more than it can do, as a motion that "
                 "leaves no room; a shorter time.frame or more time.substeps may do");
}

void RunningScene::rebalance() {
  if (!balance_.due()) return;
  simulation.move_homes(balance_.homes(parts_of(simulation)));
  balance_.changed();
}

BorderCosts RunningScene::borders() const { return border_costs(comm_, parts_of(simulation)); }

double RunningScene::imbalance() { return balance_.imbalance(parts_of(simulation)); }

void RunningScene::fix_scene() {
  if (mark_.empty()) mark_ = mark_of(scene_);
}

void RunningScene::write_checkpoint(const std::string& path, std::int64_t frame) {
  fix_scene();
  simulation.detect();  // the history then knows which joints the last step has broken
  SceneOutline outline = outline_of(scene_);
  for (const Break& one : simulation.history.past.breaks) {
    const Joint& joint = scene_.joints[static_cast<std::size_t>(one.joint)];
    outline.broken.push_back({joint.ids, static_cast<int>(joint.kind)});
  }
  unibody::write_checkpoint(comm_, path, mark_, frame, static_cast<double>(frame) * scene_.time.frame, scene_.body_count(),
                            simulation.elements(), simulation.history, &outline);
}

}  // namespace unibody
