#include "app/frame_columns.hpp"

#include <iterator>

#include "report/breaks.hpp"
#include "report/changing_bodies.hpp"
#include "report/joint_report.hpp"
#include "report/strain.hpp"
#include "report/stretch.hpp"
#include "report/surface_report.hpp"
#include "step/liquid.hpp"

namespace unibody {

namespace {

// The columns of -error_estimate; without a step that was asked for it, empty cells.
void add_error_columns(const StepReport& step, std::vector<NamedValue>& columns) {
  const StepError error = step.error.value_or(StepError{});
  const bool known = step.error.has_value();
  columns.push_back({"error_estimate (m)", error.distance, known});
  columns.push_back({"error_relative (1)", error.relative, known});
  columns.push_back({"error_reference_residual (m)", error.reference_residual, known});
}

}  // namespace

std::vector<NamedValue> further_columns(const ColumnSources& from, const StepReport& step, const FrameReport& report) {
  const Scene& scene = from.scene;
  Simulation& simulation = from.simulation;
  const MPI_Comm comm = simulation.comm();
  const World& world = simulation.world;
  auto columns = constraint_columns(comm, scene, world, simulation.ties.constraints, step.constraint_residuals());
  const auto add = [&](std::vector<NamedValue> more) { std::move(more.begin(), more.end(), std::back_inserter(columns)); };
  add(strain_columns(comm, scene, world, simulation.ties.constraints));
  columns.push_back({"impacts (1)", static_cast<double>(step.impacts)});
  columns.push_back({"held_bodies (1)", static_cast<double>(step.held_bodies)});
  if (!scene.constraint_groups.empty() || simulation.traits.complies)
    columns.push_back({"elastic_energy (J)", report.measures.elastic_energy});
  if (simulation.coarse.exists()) {
    columns.push_back({"coarse_touching (1)", static_cast<double>(report.coarse.touching)});
    columns.push_back({"coarse_gaining (1)", static_cast<double>(report.coarse.gaining)});
  }
  if (simulation.traits.has_centre_constraints) columns.push_back({"turning (m)", report.turning});
  if (scene.solver.form == Form::total) columns.push_back({"form_left (1)", static_cast<double>(report.form_left)});
  add(joint_columns(comm, scene.joints, simulation.ties.joints, simulation.ties.joint_slots, simulation.joint_states(),
                    step.residual_of<JointBatch>()));
  if (simulation.traits.is_wet) columns.push_back({"liquid_bridges (1)", static_cast<double>(count_bridges(simulation))});
  add(break_columns(scene, simulation.history.past));
  if (simulation.traits.has_attachments) columns.push_back({"residual_attachment (m)", step.residual_of<AttachmentBatch>()});
  if (scene.solver.accuracy) columns.push_back({"estimated_error (m)", report.estimated_error});
  if (from.options.error_estimate > 0) add_error_columns(step, columns);
  add(from.probes.columns(comm, world));
  add(past_columns(comm, scene, world, simulation.history.past));
  if (!simulation.has_surfaces()) return columns;
  columns.push_back({"held_pairs (1)", static_cast<double>(step.guard.pairs)});
  if (!scene.output.crossings) return columns;
  const PhaseClock::Scope scope(from.clock, Phase::output);
  columns.push_back({"crossings (1)", static_cast<double>(count_crossings(comm, world, simulation.search.surfaces))});
  return columns;
}

}  // namespace unibody
