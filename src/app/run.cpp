#include "app/run.hpp"

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <optional>

#include "app/column_events.hpp"
#include "app/frame_columns.hpp"
#include "app/frame_times.hpp"
#include "app/machine_memory.hpp"
#include "app/overview.hpp"
#include "app/petsc_session.hpp"
#include "app/running_scene.hpp"
#include "app/stop_request.hpp"
#include "app/strict.hpp"
#include "app/wishes.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "report/breaks.hpp"
#include "report/changing_bodies.hpp"
#include "report/contact_file.hpp"
#include "report/damaged_files.hpp"
#include "report/elastic_energy.hpp"
#include "report/folder_lock.hpp"
#include "report/joint_report.hpp"
#include "report/output.hpp"
#include "report/probes.hpp"
#include "report/progress.hpp"
#include "report/report.hpp"
#include "report/state_hash.hpp"
#include "report/summary.hpp"
#include "report/version.hpp"
#include "scene/schema.hpp"
#include "scene/settings.hpp"
#include "step/mesh_sides.hpp"

namespace unibody {

namespace {

// A run, from the scene to its last frame. All members are collective.
class Run {
 public:
  Run(MPI_Comm comm, Scene& scene, const Options& options)
      : comm_(comm),
        scene_(scene),
        options_(options),
        running_(comm, scene, options),
        times_(comm, running_.clock),
        probes_(scene.probes, scene.time.frame, scene.period) {
    check_mpi(MPI_Comm_rank(comm, &rank_));
  }

  struct End {
    std::uint64_t hash;
    bool stopped;  // as asked, before the last frame
  };
  End simulate() {
    StopRequest stop(comm_, options_.wall_limit);
    start_world();
    check_wishes(comm_, scene_, options_, summary_.first_frame);
    tell_overview();
    if (!scene_.events.empty()) check_event_columns(scene_, further_columns({}, {}));
    if (options_.check) return {state_hash(comm_, simulation_.world), false};
    const FolderLock lock(comm_, options_.output);
    prepare_output_directory(comm_, options_.output, options_.overwrite, options_.restart, options_.appends);
    warn_of_crowds(summary_.first_frame);
    open_files();
    write(summary_.first_frame);
    checkpoint_in_turn(summary_.first_frame);
    last_frame_ = summary_.first_frame;
    Progress progress(rank_, summary_.first_frame, scene_.time.frames, summary_.dynamic_bodies);
    for (std::int64_t frame = summary_.first_frame + 1; frame <= scene_.time.frames; ++frame) {
      running_.rebalance();
      FrameReport report = do_frame(frame);
      stop_if_not_finite(comm_, report);
      write(frame);
      dump(frame);
      times_.frame_done(report);
      report_file_->append(report);
      const Event* end = note_events(scene_, report, simulation_.history.past);
      checkpoint_in_turn(frame);  // last: a run that goes on from it finds the rest of the frame written
      progress.frame_done(report);
      summary_.add(report), last_frame_ = frame;
      if (frame == scene_.time.frames) break;
      if (end != nullptr) {
        end_by(*end, frame);
        break;
      }
      if (const std::string reason = stop.reason(); !reason.empty()) {
        stop_at(frame, reason);
        break;
      }
    }
    finish();
    return {summary_.state_hash, stopped_};
  }

 private:
  void start_world();
  void tell_overview();
  FrameReport do_frame(std::int64_t frame);
  std::vector<NamedValue> further_columns(const StepReport& step, const FrameReport& report);
  void open_files();
  void write(std::int64_t frame);
  void checkpoint_in_turn(std::int64_t frame);
  bool is_due_by_wall(std::int64_t frame);
  void checkpoint(std::int64_t frame);
  void end_by(const Event& event, std::int64_t frame);
  void stop_at(std::int64_t frame, const std::string& reason);
  void dump(std::int64_t frame);
  void finish();

  // Once: nobody means it.
  void warn_of_crowds(std::int64_t frame) {
    if (!simulation_.is_crowded() || warned_of_crowds_) return;
    warned_of_crowds_ = true;
    const CrowdCount count = count_crowds(simulation_);
    if (rank_ != 0) return;
    std::fprintf(
        stderr,
        "unibody: frame %lld: %lld bodies are where there is room for a few, up to %lld at one place, among them body %lld "
        "(%s): until they are apart each touches some of the others only\n",
        static_cast<long long>(frame), static_cast<long long>(count.bodies), static_cast<long long>(count.most),
        static_cast<long long>(count.one), scene_.body_name(count.one).c_str());
  }

  // The residual (m) above which a step names its worst constraint: the largest of the run so far; with -strict the limit at
  // which the run stops.
  double name_above(const FrameReport& frame) const {
    if (options_.strict) return least_named(summary_.convergence);
    return std::max(summary_.convergence.worst_residual, frame.natural_residual);
  }

  bool wants_error(std::int64_t frame) const {
    const int every = options_.error_estimate;
    return every > 0 && (frame % every == 0 || frame == scene_.time.frames);
  }

  bool writes_contacts(std::int64_t frame) const {
    return contact_file_ && frame > summary_.first_frame && frame % scene_.output.contacts == 0;
  }

  // The frame whose last step is to be written as a problem; -1: none.
  std::int64_t dumped_frame() const {
    if (options_.dump_fclib.empty()) return -1;
    return options_.dump_step >= 0 ? options_.dump_step : scene_.time.frames;
  }

  MPI_Comm comm_;
  int rank_ = 0;
  const double start_ = MPI_Wtime();
  const Scene& scene_;
  const Options& options_;
  RunningScene running_;
  Simulation& simulation_ = running_.simulation;
  FrameTimes times_;
  Probes probes_;
  Summary summary_;
  std::optional<ReportFile> report_file_;
  std::optional<Output> frames_;
  std::optional<JointFiles> joint_files_;
  std::optional<BreakFile> break_file_;
  std::optional<ContactFile> contact_file_;
  std::vector<ContactImpulse> contact_impulses_;  // of the frame's last step, where they are to be written
  ContactProblem problem_;
  double checkpoint_wall_ = start_;  // s, when the last checkpoint was written, or the run began
  bool dumped_ = false, warned_of_crowds_ = false, stopped_ = false;
  std::int64_t checkpointed_ = -1, last_frame_ = 0;  // the last frame of which there is a checkpoint; that has been computed
};

void Run::start_world() {
  summary_.first_frame = running_.start();
  for (const std::string& line : running_.told())
    if (rank_ == 0) std::printf("%s\n", line.c_str());
  if (summary_.first_frame > scene_.time.frames)
    throw InputError("'" + options_.restart + "' is of frame " + std::to_string(summary_.first_frame) +
                     ": key 'time.frames': found " + std::to_string(scene_.time.frames) + ", expected no fewer");
  summary_.convergence.tolerance = *simulation_.settings_used().tolerance;
  summary_.convergence.smallest_size = simulation_.traits.smallest_size;
  summary_.convergence.accuracy = scene_.solver.accuracy.value_or(default_accuracy);
  summary_.convergence.asked = scene_.solver.accuracy.has_value();
  if (options_.strict) check_tolerance(summary_.convergence);
  for (const BodyGroup& group : scene_.groups) summary_.dynamic_bodies += group.is_static ? 0 : group.count;
}

void Run::tell_overview() {
  simulation_.detect();  // guests are there
  const Overview overview = overview_of(simulation_);
  if (rank_ == 0) {
    for (const std::string& line : overview.lines) std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    for (const std::string& warning : overview.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
  if (options_.strict && !overview.warnings.empty()) throw InputError("option -strict: " + overview.warnings.front());
}

FrameReport Run::do_frame(std::int64_t frame) {
  FrameReport report;
  report.step = frame, report.time = static_cast<double>(frame) * scene_.time.frame;
  report.converged = true;
  StepReport last;
  SurfaceGuard::Held held;
  std::int64_t impacts = 0, held_bodies = 0;
  running_.start_frame(frame);
  probes_.start_frame(simulation_.world);
  for (int s = 0; s < scene_.time.substeps; ++s) {
    const bool last_step = s + 1 == scene_.time.substeps;
    const bool dumps = last_step && frame == dumped_frame();
    const bool writes = last_step && writes_contacts(frame);
    const StepRequest request{last_step && wants_error(frame), dumps ? &problem_ : nullptr, name_above(report),
                              writes || probes_.wants_impulses()};
    StepReport step = running_.step(request, frame, s);
    probes_.add_step(step.impulses);
    if (writes) contact_impulses_ = std::move(step.impulses);
    step.impulses.clear(), last = step;
    held.pairs += step.guard.pairs, impacts += step.impacts, held_bodies += step.held_bodies;
    if (options_.strict) stop_if_wrong(scene_, summary_.convergence, step, frame);
    report.iterations += step.iterations, report.sliding_contacts = step.sliding;
    if (step.residual > report.natural_residual) report.worst = step.worst;
    report.natural_residual = std::max(report.natural_residual, step.residual);
    report.turning = std::max(report.turning, step.turning);
    report.estimated_error += step.estimated_error;
    report.residual_rate += step.residual / scene_.time.frame;
    report.converged &= step.converged, report.form_left += step.form_left;
    report.coarse.add(step.coarse);
  }
  simulation_.detect();
  warn_of_crowds(frame);
  report.error = last.error;
  report.measures = measure(comm_, simulation_.world, simulation_.contacts, scene_.gravity_at(report.time),
                            static_cast<double>(simulation_.bytes()), &scene_.pairs);
  if (!scene_.constraint_groups.empty())
    report.measures.elastic_energy = elastic_energy(comm_, simulation_.world, simulation_.ties.constraints);
  if (simulation_.traits.complies)
    report.measures.elastic_energy += contact_energy(comm_, simulation_.world, simulation_.contacts, scene_.pairs);
  last.guard = held, last.impacts = impacts, last.held_bodies = held_bodies;
  summary_.plans = last.plans;
  report.constraint_columns = further_columns(last, report);
  if (options_.strict) stop_if_sides_are_lost(report);
  report.imbalance = running_.imbalance();
  return report;
}

std::vector<NamedValue> Run::further_columns(const StepReport& step, const FrameReport& report) {
  return unibody::further_columns({scene_, options_, simulation_, probes_, running_.clock}, step, report);
}

void Run::open_files() {
  const std::int64_t kept_to = options_.appends ? summary_.first_frame : -1;
  if (options_.appends) {
    ReportFile::check_columns(comm_, options_.output + "/report.csv", further_columns({}, {}));
    for (const std::string& warning : set_aside_damaged_files(comm_, options_.output))
      if (rank_ == 0) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
  if (scene_.output.every > 0)
    frames_.emplace(comm_, options_.output, scene_.output, scene_.body_count(), simulation_.world, scene_.surfaces, kept_to,
                    changing_bodies(scene_));
  report_file_.emplace(comm_, options_.output + "/report.csv", further_columns({}, {}), kept_to);
  if (scene_.output.joints && simulation_.traits.has_joints) joint_files_.emplace(comm_, options_.output, scene_.joints, kept_to);
  if (scene_.joints_break()) break_file_.emplace(comm_, options_.output, scene_);
  if (scene_.output.contacts > 0) contact_file_.emplace(comm_, options_.output, scene_, kept_to);
}

void Run::write(std::int64_t frame) {
  const PhaseClock::Scope scope(running_.clock, Phase::output);
  const double time = static_cast<double>(frame) * scene_.time.frame;
  if (frames_ && frame % scene_.output.every == 0 && !frames_->holds(frame)) frames_->write(frame, time, simulation_.world);
  if (joint_files_ && frame % std::max(1, scene_.output.every) == 0 && !joint_files_->holds(frame))
    joint_files_->write(frame, time, simulation_.ties.joints, simulation_.ties.joint_slots, simulation_.joint_states());
  if (break_file_) break_file_->write(simulation_.history.past.breaks);
  if (writes_contacts(frame))
    contact_file_->write(frame, time, std::exchange(contact_impulses_, {}), simulation_.when.whole_step);
}

void Run::checkpoint_in_turn(std::int64_t frame) {
  const PhaseClock::Scope scope(running_.clock, Phase::output);
  const int every = scene_.output.checkpoint_every;
  const bool in_turn = every > 0 && frame % every == 0 && frame > summary_.first_frame;
  if (every >= 0 && (in_turn || frame == scene_.time.frames || is_due_by_wall(frame))) checkpoint(frame);
}

// Whether a checkpoint is due by the wall time. The clock of rank 0 decides, since the ranks' clocks differ.
bool Run::is_due_by_wall(std::int64_t frame) {
  const double seconds = 60 * scene_.output.checkpoint_minutes;
  if (seconds == 0 || frame == summary_.first_frame) return false;
  int due = MPI_Wtime() - checkpoint_wall_ >= seconds ? 1 : 0;
  check_mpi(MPI_Bcast(&due, 1, MPI_INT, 0, comm_));
  return due != 0;
}

void Run::checkpoint(std::int64_t frame) {
  running_.write_checkpoint(options_.output + "/checkpoint.h5", frame);
  checkpointed_ = frame, checkpoint_wall_ = MPI_Wtime();
}

void Run::end_by(const Event& event, std::int64_t frame) {
  if (scene_.output.checkpoint_every >= 0 && checkpointed_ != frame) checkpoint(frame);
  summary_.status = "ended by the scene: " + told(event);
  if (rank_ == 0) std::printf("\n%s, after frame %lld\n", summary_.status.c_str(), static_cast<long long>(frame));
}

// Stops the run after a frame, and writes a checkpoint of it unless the scene wants none at all.
void Run::stop_at(std::int64_t frame, const std::string& reason) {
  const PhaseClock::Scope scope(running_.clock, Phase::output);
  const bool keeps = scene_.output.checkpoint_every >= 0;
  if (keeps && checkpointed_ != frame) checkpoint(frame);
  summary_.status = "stopped as asked by " + reason, stopped_ = true;
  if (rank_ != 0) return;
  std::printf("\nstopped as asked by %s after frame %lld of %lld: %s\n", reason.c_str(), static_cast<long long>(frame),
              static_cast<long long>(scene_.time.frames),
              keeps ? ("it goes on with -restart " + options_.output + "/checkpoint.h5").c_str()
                    : "output.checkpoint_every is -1, so that there is no checkpoint to go on from");
}

void Run::dump(std::int64_t frame) {
  if (frame == dumped_frame()) dumped_ = dump_problem(comm_, scene_, options_, frame, std::exchange(problem_, {}));
}

void Run::finish() {
  report_file_->close();
  if (frames_) frames_->close();
  if (joint_files_) joint_files_->close();
  if (break_file_) break_file_->close();
  if (contact_file_) contact_file_->close();
  summary_.state_hash = state_hash(comm_, simulation_.world);
  summary_.solver = simulation_.settings_used(), summary_.overrides = options_.overrides;
  summary_.restarted_from = options_.restart;
  if (options_.restart.empty()) summary_.continued_from = options_.continue_from;
  summary_.last_frame = last_frame_, summary_.past = simulation_.history.past;
  summary_.wall_total = MPI_Wtime() - start_;
  times_.finish();
  summary_.phases = times_.phases;
  summary_.files = {"report.csv"};
  if (frames_) summary_.files.insert(summary_.files.end(), {"frames.h5", "frames.xdmf"});
  if (joint_files_) summary_.files.insert(summary_.files.end(), {"joints.csv", "joints.h5"});
  if (break_file_) summary_.files.push_back("breaks.csv");
  if (contact_file_) summary_.files.insert(summary_.files.end(), {"contacts.h5", "contacts.xdmf"});
  if (scene_.output.checkpoint_every >= 0) summary_.files.push_back("checkpoint.h5");
  if (dumped_) summary_.files.push_back(options_.dump_fclib);
  summary_.files.push_back("summary.json");
  summary_.borders = running_.borders();
  write_summary(comm_, options_.output + "/summary.json", scene_, summary_);
  if (rank_ != 0) return;
  std::fputs(told(summary_, scene_).c_str(), stdout);
  std::printf("wrote in %s:", options_.output.c_str());
  for (const std::string& file : summary_.files) std::printf(" %s", file.c_str());
  std::printf("\n");
}

}  // namespace

int run(MPI_Comm comm, const Options& given) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const Options options = resolved(comm, given);
  if (options.help) {
    if (rank == 0) std::fputs(help_text().c_str(), stdout);
    return 0;
  }
  if (options.schema || options.settings) {
    if (rank == 0) std::fputs((options.schema ? scene_schema() : keys_reference()).c_str(), stdout);
    return 0;
  }
  if (options.version) {
    if (rank == 0) std::fputs(version_text().c_str(), stdout);
    return 0;
  }
  end_run_out_of_memory();
  Scene scene = read_scene(options.scene, options.overrides, room_of(comm));
  tell_bodies_in_scene(scene.body_count());
  check_ranks_of_solver(comm, scene);
  std::vector<std::string> notes = scene.notes;
  decide_mesh_sides(comm, scene, notes);
  if (rank == 0)
    for (const std::string& note : notes) std::printf("%s\n", note.c_str());
  Run::End end{};
  {
    const PetscSession petsc(comm, options.petsc);
    check_petsc_counts(scene);
    end = Run(comm, scene, options).simulate();
    petsc.name_unused_options();
  }
  if (rank == 0) std::printf("state %016llx\n", static_cast<unsigned long long>(end.hash));
  return end.stopped ? exit_stopped : 0;
}

}  // namespace unibody
