#include "run.hpp"

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "build.hpp"
#include "core/errors.hpp"
#include "core/phases.hpp"
#include "partition/balance.hpp"
#include "report/checkpoint.hpp"
#include "report/fclib_file.hpp"
#include "report/joint_report.hpp"
#include "report/output.hpp"
#include "report/progress.hpp"
#include "report/report.hpp"
#include "report/state_hash.hpp"
#include "report/strain.hpp"
#include "report/summary.hpp"
#include "report/surface_report.hpp"
#include "step.hpp"

namespace unibody {

namespace {

// PETSc from here to there, with the options that are its own.
class PetscSession {
 public:
  explicit PetscSession(const std::vector<std::string>& options) {
    words_ = {"unibody"};
    words_.insert(words_.end(), options.begin(), options.end());
    for (std::string& word : words_) argv_.push_back(word.data());
    argv_.push_back(nullptr);
    int argc = static_cast<int>(words_.size());
    char** argv = argv_.data();
    if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) throw InputError("PETSc does not take its options: see above");
  }
  ~PetscSession() { PetscFinalize(); }
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

 private:
  std::vector<std::string> words_;
  std::vector<char*> argv_;
};

// How the bodies are moved: steps and solver. With -start_from it may differ from that of the checkpoint's run.
std::string settings_of(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  const SolverSettings& s = scene.solver;
  text << scene.time.step << ' ' << scene.time.substeps << ' ' << s.name << ' ' << s.iterations << ' ' << s.tolerance << ' '
       << static_cast<int>(s.stages) << ' ' << s.warm_start << ' ' << s.leak << ' ' << static_cast<int>(s.friction) << ' '
       << static_cast<int>(s.gap) << ' ' << static_cast<int>(s.form) << ' ' << static_cast<int>(s.order) << ' ' << s.scaling
       << ' ' << s.recovery_time << ' ' << s.recovery_speed << ' ' << s.margin << '\n';
  if (s.level == Level::velocity) text << "velocity level " << s.stabilisation << '\n';
  return text.str();
}

// What is moved.
std::string physics_of(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  text << scene.gravity.transpose() << ' ' << scene.planar << '\n';
  for (const std::string& material : scene.materials) text << material << ' ';
  for (const double mu : scene.friction) text << mu << ' ';
  for (const auto& [what, values] :
       {std::pair("bounce", &scene.restitution), {"roll", &scene.rolling}, {"spin", &scene.spinning}})
    if (has_any(*values))
      for (const double value : *values) text << what << ' ' << value << '\n';
  for (const BodyGroup& group : scene.groups) text << group.name << ' ' << group.count << ' ' << group.is_static << '\n';
  text << "air " << scene.wind.transpose() << ' ' << scene.air_density << '\n';
  for (const Surface& surface : scene.surfaces) text << "drag " << surface.drag << '\n';
  for (const Pin& pin : scene.pins) text << "pin " << pin.id << ' ' << pin.release << ' ' << pin.body << '\n';
  for (const Attachment& a : scene.attachments) text << "tie " << a.node << ' ' << a.body << ' ' << a.release << '\n';
  for (const Joint& j : scene.joints) {
    text << "joint " << static_cast<int>(j.kind) << ' ' << j.collide << ' ' << j.ids[0] << ' ' << j.ids[1] << ' ' << j.compliance
         << ' ' << j.turning << ' ' << j.damping << ' ' << j.length << ' ' << j.lower << ' ' << j.upper << ' ' << j.swing << ' '
         << j.tree << ' ' << static_cast<int>(j.motor) << ' ' << j.target << ' ' << j.strength << ' ' << j.friction;
    for (std::size_t e = 0; e < 2; ++e) text << ' ' << j.anchor[e].transpose() << ' ' << j.frame[e].coeffs().transpose();
    text << '\n';
  }
  for (const ConstraintGroup& group : scene.constraint_groups)  // all of a group follow one law: two bodies show it
    for (const Id id : {group.first, group.first + group.count / 2}) {
      ConstraintSet constraints;
      group.touching(id, constraints);
      for_each_type(constraints, [&](auto, const auto& list) {
        for (const auto& c : list) {
          for (const Id i : c.ids) text << i << ' ';
          for (const double p : c.parameters) text << p << ' ';
          for (const double e : c.compliance) text << e << ' ';
          text << c.damping << '\n';
        }
      });
    }
  return text.str();
}

// What must not change between a checkpoint and the run that goes on from it, the settings last. How long the run is, and what it
// writes, may.
std::string mark_of(const Scene& scene, bool with_settings = true) {
  return fingerprint(physics_of(scene)) + (with_settings ? fingerprint(settings_of(scene)) : "");
}

// The world at the checkpoint: each rank reads its share of the moving bodies, and all statics.
std::int64_t restore(MPI_Comm comm, const Scene& scene, const Options& options, Simulation& simulation) {
  const Checkpoint checkpoint(comm, options.restart, mark_of(scene, !options.other_settings));
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const Id begin = checkpoint.body_count() * rank / size, end = checkpoint.body_count() * (rank + 1) / size;
  std::vector<Body> homes, statics;
  for (const BodyGroup& group : scene.groups) {
    const Id first = group.is_static ? group.first : std::max(group.first, begin);
    const Id last = group.is_static ? group.first + group.count : std::min(group.first + group.count, end);
    if (first >= last) continue;
    auto& to = group.is_static ? statics : homes;
    const auto bodies = checkpoint.read_bodies(first, last);
    to.insert(to.end(), bodies.begin(), bodies.end());
  }
  simulation.world = make_world(homes, statics, scene.has_rotations());
  simulation.multipliers = checkpoint.read_multipliers(simulation.world);
  simulation.make_constraints();
  simulation.constraint_multipliers = checkpoint.read_constraint_multipliers(simulation.constraints);
  simulation.joint_impulses = checkpoint.read_joint_impulses(simulation.joints);
  return checkpoint.frame();
}

// Where the wall time of a frame went, the slowest rank's figure for each phase.
class FrameTimes {
 public:
  FrameTimes(MPI_Comm comm, const PhaseClock& clock) : comm_(comm), clock_(clock), before_(clock.seconds()) {
    for (std::size_t i = 0; i < phases.size(); ++i) phases[i].name = phase_names[i];
  }
  void frame_done(FrameReport& report) {
    std::array<double, phase_names.size()> spent = clock_.seconds();
    for (std::size_t i = 0; i < spent.size(); ++i) spent[i] -= before_[i];
    before_ = clock_.seconds();
    MPI_Allreduce(MPI_IN_PLACE, spent.data(), static_cast<int>(spent.size()), MPI_DOUBLE, MPI_MAX, comm_);
    for (std::size_t i = 0; i < spent.size(); ++i) phases[i].seconds.push_back(spent[i]);
    const auto of = [&](Phase phase) { return spent[static_cast<std::size_t>(phase)]; };
    report.wall_collide = of(Phase::collide), report.wall_solve = of(Phase::solve);
    report.wall_halo = of(Phase::halo), report.wall_output = of(Phase::output);
  }
  std::vector<PhaseTimes> phases = std::vector<PhaseTimes>(phase_names.size());

 private:
  MPI_Comm comm_;
  const PhaseClock& clock_;
  std::array<double, phase_names.size()> before_;
};

std::string describe_bad_body(const Scene& scene, const Simulation& simulation, Id id, const std::string& when) {
  std::string text = when + ": the state of body " + std::to_string(id) + " (" + scene.body_name(id) + ") is no longer finite; ";
  const auto touches = [&](const Manifold& m) { return m.id_a == id || m.id_b == id; };
  const Contacts& contacts = simulation.contacts;
  const auto it = std::find_if(contacts.manifolds.begin(), contacts.manifolds.end(), touches);
  if (it == contacts.manifolds.end()) return text + "no constraint acts on it";
  return text + "constraint: contact with body " + std::to_string(it->id_a == id ? it->id_b : it->id_a) + " (" +
         scene.body_name(it->id_a == id ? it->id_b : it->id_a) + ")";
}

// Stops the run, naming the body with the smallest id of those that went wrong. Its home rank knows its contacts.
[[noreturn]] void stop_at_bad_body(MPI_Comm comm, const Scene& scene, const Simulation& simulation, Id bad, std::int64_t frame,
                                   int substep) {
  int rank = 0, teller = 0;  // rank 0 tells of a kinematic body, which is home nowhere
  MPI_Comm_rank(comm, &rank);
  const auto homes_end = simulation.world.id.begin() + static_cast<std::ptrdiff_t>(simulation.world.homes);
  if (std::binary_search(simulation.world.id.begin(), homes_end, bad)) teller = rank;
  std::array<char, 512> text{};
  std::string when = "frame " + std::to_string(frame);
  if (scene.time.substeps > 1) when += ", step " + std::to_string(substep + 1) + " of " + std::to_string(scene.time.substeps);
  if (teller == rank) describe_bad_body(scene, simulation, bad, when).copy(text.data(), text.size() - 1);
  MPI_Allreduce(MPI_IN_PLACE, &teller, 1, MPI_INT, MPI_MAX, comm);
  MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, teller, comm);
  throw RunError(text.data());
}

// The columns of -error_estimate; without a step that was asked for it, empty cells.
void add_error_columns(const StepReport& step, std::vector<NamedValue>& columns) {
  const StepError error = step.error.value_or(StepError{});
  const bool known = step.error.has_value();
  columns.push_back({"error_estimate (m)", error.distance, known});
  columns.push_back({"error_relative (1)", error.relative, known});
  columns.push_back({"error_reference_residual (m)", error.reference_residual, known});
}

// Throws InputError where the scene or its solver cannot do what an option asks for.
void check_wishes(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t first_frame) {
  if (options.error_estimate > 0 && scene.solver.name == "newton")
    throw InputError("option -error_estimate: found solver.name newton, expected an iterative solver (newton converges)");
  if (options.dump_fclib.empty()) return;
  if (!scene.constraint_groups.empty() || !scene.attachments.empty() || !scene.joints.empty())
    throw InputError("option -dump_fclib: found joints, cloths, threads or solids in " + scene.path +
                     ", expected rigid bodies that touch, alone");
  if (has_any(scene.rolling) || has_any(scene.spinning))
    throw InputError("option -dump_fclib: found rolling or spinning friction in " + scene.path + ", expected none");
  if (scene.planar) throw InputError("option -dump_fclib: found a planar scene, expected bodies free in space");
  if (options.dump_step > scene.time.frames || (options.dump_step >= 0 && options.dump_step <= first_frame))
    throw InputError("option -dump_step: found " + std::to_string(options.dump_step) + ", expected a frame of the run, " +
                     std::to_string(first_frame + 1) + " to " + std::to_string(scene.time.frames));
  check_fclib_path(comm, options.dump_fclib, options.overwrite);
}

// Whether there was anything to write.
bool dump_problem(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t frame, const ContactProblem& problem) {
  int contacts = static_cast<int>(problem.contacts.size());
  MPI_Bcast(&contacts, 1, MPI_INT, 0, comm);
  if (contacts == 0) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    if (rank == 0)
      std::fprintf(stderr, "unibody: -dump_fclib: frame %lld has no contacts: no file\n", static_cast<long long>(frame));
    return false;
  }
  const std::string text = "Unibody, last step of frame " + std::to_string(frame) + " of " + scene.path;
  write_fclib(comm, options.dump_fclib, problem, scene.title, text);
  return true;
}

std::uint64_t simulate(MPI_Comm comm, const Scene& scene, const Options& options) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const double start = MPI_Wtime();
  PhaseClock clock;
  Simulation simulation(comm, scene, clock);
  Summary summary;
  if (options.restart.empty())
    simulation.world = build_world(comm, scene);
  else
    summary.first_frame = restore(comm, scene, options, simulation);
  simulation.steps_done = summary.first_frame * scene.time.substeps;
  if (summary.first_frame > scene.time.frames)
    throw InputError("'" + options.restart + "' is of frame " + std::to_string(summary.first_frame) +
                     ": key 'time.frames': found " + std::to_string(scene.time.frames) + ", expected no fewer");
  simulation.set_tolerance_from_bodies();
  Balance balance(comm, options.random_partition, options.rebalance, scene.constraint_groups);
  if (options.restart.empty()) simulation.make_constraints();
  simulation.move_homes(balance.homes(simulation.world, {}, &simulation.constraints, scene.joints, simulation.joints));

  check_wishes(comm, scene, options, summary.first_frame);
  prepare_output_directory(comm, options.output, options.overwrite, options.restart);
  const std::string checkpoint_path = options.output + "/checkpoint.h5";
  simulation.detect();  // guests are there
  const auto further_columns = [&](const StepReport& step, std::int64_t held) {
    auto columns = constraint_columns(comm, scene, simulation.world, simulation.constraints, step.constraint_residuals);
    for (NamedValue& column : strain_columns(comm, scene, simulation.world, simulation.constraints))
      columns.push_back(std::move(column));
    for (NamedValue& column :
         joint_columns(comm, scene.joints.size(), simulation.slots_of_joints(), simulation.joint_states(), step.joint_residual))
      columns.push_back(std::move(column));
    if (simulation.has_attachments()) columns.push_back({"residual_attachment (m)", step.attachment_residual});
    if (options.error_estimate > 0) add_error_columns(step, columns);
    if (!simulation.has_surfaces()) return columns;
    columns.push_back({"held_pairs (1)", static_cast<double>(held)});
    if (!scene.output.crossings) return columns;
    const PhaseClock::Scope scope(clock, Phase::output);
    columns.push_back({"crossings (1)", static_cast<double>(count_crossings(comm, simulation.world, simulation.surfaces()))});
    return columns;
  };
  ReportFile report_file(comm, options.output + "/report.csv", further_columns({}, 0));
  std::optional<Output> frames;
  if (scene.output.every > 0)
    frames.emplace(comm, options.output, scene.output, scene.body_count(), simulation.world, scene.surfaces);
  std::optional<JointFiles> joint_files;
  if (scene.output.joints && simulation.has_joints()) joint_files.emplace(comm, options.output, scene.joints);
  const auto write = [&](std::int64_t frame) {
    const PhaseClock::Scope scope(clock, Phase::output);
    const double time = static_cast<double>(frame) * scene.time.step;
    if (frames && frame % scene.output.every == 0) frames->write(frame, time, simulation.world);
    if (joint_files && frame % std::max(1, scene.output.every) == 0)
      joint_files->write(frame, time, simulation.joints, simulation.slots_of_joints(), simulation.joint_states());
    const int every = scene.output.checkpoint_every;
    if (frame > summary.first_frame && every >= 0 && ((every > 0 && frame % every == 0) || frame == scene.time.frames))
      write_checkpoint(comm, checkpoint_path, mark_of(scene), frame, time, scene.body_count(), simulation.world,
                       simulation.multipliers, simulation.constraints, simulation.constraint_multipliers,
                       joint_row_block(comm, static_cast<std::int64_t>(scene.joints.size()), simulation.joints,
                                       simulation.slots_of_joints(), simulation.joint_impulses));
  };
  write(summary.first_frame);

  for (const BodyGroup& group : scene.groups) summary.dynamic_bodies += group.is_static ? 0 : group.count;
  Progress progress(rank, summary.first_frame, scene.time.frames, summary.dynamic_bodies);
  FrameTimes times(comm, clock);
  const std::int64_t dumped_frame =
      options.dump_fclib.empty() ? -1 : (options.dump_step >= 0 ? options.dump_step : scene.time.frames);
  ContactProblem problem;
  bool dumped = false;
  for (std::int64_t frame = summary.first_frame + 1; frame <= scene.time.frames; ++frame) {
    if (balance.due()) {
      simulation.move_homes(
          balance.homes(simulation.world, simulation.contacts, &simulation.constraints, scene.joints, simulation.joints));
      balance.changed();
    }
    FrameReport report;
    report.step = frame, report.time = static_cast<double>(frame) * scene.time.step;
    report.converged = true;
    StepReport last;
    std::int64_t held = 0;
    for (int s = 0; s < scene.time.substeps; ++s) {
      const bool last_step = s + 1 == scene.time.substeps;
      const StepWishes wishes{last_step && options.error_estimate > 0 && frame % options.error_estimate == 0,
                              last_step && frame == dumped_frame ? &problem : nullptr};
      const StepReport step = last = simulation.step(wishes);
      // Before anything looks for contacts among such bodies.
      if (const Id bad = first_bad_body(comm, simulation.world); bad >= 0)
        stop_at_bad_body(comm, scene, simulation, bad, frame, s);
      held += step.held;
      report.iterations += step.iterations, report.sliding_contacts = step.sliding;
      report.natural_residual = std::max(report.natural_residual, step.residual);
      report.converged &= step.converged;
    }
    simulation.detect();
    report.constraint_columns = further_columns(last, held);
    report.measures =
        measure(comm, simulation.world, simulation.contacts, scene.gravity, static_cast<double>(simulation.bytes()));
    report.imbalance = balance.imbalance(simulation.world, simulation.contacts, constraint_count(simulation.constraints));
    write(frame);
    if (frame == dumped_frame) dumped = dump_problem(comm, scene, options, frame, std::exchange(problem, {}));
    times.frame_done(report);
    report_file.append(report);
    progress.frame_done(report);
    summary.final = report;
  }

  summary.state_hash = state_hash(comm, simulation.world);
  summary.overrides = options.overrides, summary.restarted_from = options.restart;
  summary.last_frame = scene.time.frames;
  summary.wall_total = MPI_Wtime() - start;
  summary.phases = times.phases;
  summary.files = {"report.csv"};
  if (frames) summary.files.insert(summary.files.end(), {"frames.h5", "frames.xdmf"});
  if (joint_files) summary.files.insert(summary.files.end(), {"joints.csv", "joints.h5"});
  if (scene.output.checkpoint_every >= 0 && scene.time.frames > summary.first_frame) summary.files.push_back("checkpoint.h5");
  if (dumped) summary.files.push_back(options.dump_fclib);
  summary.files.push_back("summary.json");
  write_summary(comm, options.output + "/summary.json", scene, summary);
  if (rank == 0) {
    std::printf("wrote in %s:", options.output.c_str());
    for (const std::string& file : summary.files) std::printf(" %s", file.c_str());
    std::printf("\n");
  }
  return summary.state_hash;
}

}  // namespace

int run(MPI_Comm comm, const Options& options) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (options.help) {
    if (rank == 0) std::fputs(help_text().c_str(), stdout);
    return 0;
  }
  const Scene scene = read_scene(options.scene, options.overrides);
  int size = 1;
  MPI_Comm_size(comm, &size);
  if (scene.solver.name == "gauss_seidel" && scene.solver.order == Order::sequential && size > 1)
    throw InputError(scene.path + ": key 'solver.order': found sequential on " + std::to_string(size) +
                     " ranks, expected coloured (a sequential sweep runs on one rank only)");
  if (scene.solver.name == "newton" && size > 1)
    throw InputError(scene.path + ": key 'solver.name': found newton on " + std::to_string(size) +
                     " ranks, expected an iterative solver (newton runs on one rank only)");
  std::uint64_t hash = 0;
  {
    const PetscSession petsc(options.petsc);
    hash = simulate(comm, scene, options);
  }
  if (rank == 0) std::printf("state %016llx\n", static_cast<unsigned long long>(hash));
  return 0;
}

}  // namespace unibody
