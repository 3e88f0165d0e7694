#include "report/summary.hpp"

#include <sys/resource.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/disk.hpp"
#include "core/errors.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/json.hpp"
#include "report/breaks.hpp"
#include "report/changing_bodies.hpp"
#include "report/plan_json.hpp"
#include "report/version.hpp"
#include "scene/settings.hpp"

namespace unibody {

namespace {

Json vector(const Vec3& v) { return Json::array().push(v[0]).push(v[1]).push(v[2]); }

Json versions_json() {
  Json json = Json::object();
  for (const auto& [what, which] : versions()) json.set(what, which);
  return json;
}

Json scene_json(const Scene& scene, const Summary& summary) {
  Json overrides = Json::object();
  for (const Override& o : summary.overrides) overrides.set(o.path, o.value);
  return Json::object()
      .set("path", scene.path)
      .set("title", scene.title)
      .set("overrides", overrides)
      .set("bodies", scene.body_count())
      .set("dynamic_bodies", summary.dynamic_bodies)
      .set("planar", scene.planar)
      .set("gravity", vector(scene.gravity));
}

Json settings_json(const Scene& scene, const SolverSettings& used) {
  return Json::object()
      .set("time", json_of(time_settings(), scene.time))
      .set("solver", json_of(solver_settings(), used))
      .set("output", json_of(output_settings(), scene.output));
}

// The memory of the whole process, libraries and all, at its largest so far. What the arrays' count (bytes_per_body) leaves out
// is in it.
Json peak_memory(MPI_Comm comm) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto here = std::int64_t{1024} * used.ru_maxrss;
  std::int64_t most = 0, sum = 0;
  check_mpi(MPI_Allreduce(&here, &most, 1, MPI_INT64_T, MPI_MAX, comm));
  check_mpi(MPI_Allreduce(&here, &sum, 1, MPI_INT64_T, MPI_SUM, comm));
  return Json::object().set("largest_rank (B)", most).set("all_ranks (B)", sum);
}

Json timings(const Summary& summary) {
  Json phases = Json::object();
  for (const PhaseTimes& p : summary.phases)
    phases.set(p.name, Json::object()
                           .set("total (s)", p.seconds.total())
                           .set("median a frame (s)", p.seconds.median())
                           .set("least of a rank (s)", p.least_rank)
                           .set("mean of the ranks (s)", p.mean_rank)
                           .set("most of a rank (s)", p.most_rank));
  return Json::object().set("wall_total (s)", summary.wall_total).set("phases", phases);
}

Json final_json(const FrameReport& r) {
  const Measures& m = r.measures;
  Json j = Json::object();
  j.set("time (s)", r.time).set("natural_residual (m)", r.natural_residual).set("converged", r.converged);
  j.set("penetration_max (m)", m.penetration_max).set("penetration_rms (m)", m.penetration_rms);
  j.set("penetration_l2 (m)", m.penetration_l2).set("contact_pairs", m.pairs).set("contacts", m.contacts);
  j.set("sliding_contacts", r.sliding_contacts);
  j.set("kinetic_energy (J)", m.kinetic_energy).set("potential_energy (J)", m.potential_energy);
  j.set("elastic_energy (J)", m.elastic_energy);
  j.set("linear_momentum (kg m/s)", vector(m.linear_momentum)).set("angular_momentum (kg m^2/s)", vector(m.angular_momentum));
  j.set("bytes_per_body (B)", m.bytes_per_body).set("bytes_of_largest_rank (B)", m.bytes_of_largest_rank);
  return j.set("imbalance (max/mean)", r.imbalance);
}

Json error_json(std::int64_t frame, const StepError& error) {
  return Json::object()
      .set("frame", frame)
      .set("error_estimate (m)", error.distance)
      .set("error_relative (1)", error.relative)
      .set("error_reference_residual (m)", error.reference_residual);
}

}  // namespace

void ErrorSamples::add(std::int64_t frame, const StepError& error) {
  if (++count == 1 || error.distance > worst.distance) worst = error, worst_frame = frame;
  last = error, last_frame = frame;
}

void Summary::add(const FrameReport& report) {
  final = report;
  if (report.error) errors.add(report.step, *report.error);
  form_left += report.form_left, coarse.add(report.coarse);
  convergence.add(report), side_faults.add(report);
}

std::string told(const Summary& summary, const Scene& scene) {
  std::string text = told(summary.convergence, scene) + told(summary.side_faults);
  text += told(summary.past, scene) + told_breaks(scene, summary.past);
  std::array<char, 256> line{};
  if (const ErrorSamples& e = summary.errors; e.count > 0) {
    std::snprintf(line.data(), line.size(),
                  "error of a step, estimated in %lld frames: at worst %.2e m (frame %lld), in the last %.2e m (frame %lld)\n",
                  static_cast<long long>(e.count), e.worst.distance, static_cast<long long>(e.worst_frame), e.last.distance,
                  static_cast<long long>(e.last_frame));
    text += line.data();
  }
  if (const CoarseCounts& c = summary.coarse; c.all() > 0) {
    std::snprintf(
        line.data(), line.size(),
        "coarse level: counting each cloth, thread and solid once a step, it solved %lld of %lld; sweeps alone solved %lld"
        " that touched something, and %lld that would have gained energy\n",
        static_cast<long long>(c.solved), static_cast<long long>(c.all()), static_cast<long long>(c.touching),
        static_cast<long long>(c.gaining));
    text += line.data();
  }
  if (summary.form_left > 0) {
    std::snprintf(line.data(), line.size(),
                  "form: %lld of %lld steps were taken in the incremental form, edges moved too far in them for the total one\n",
                  static_cast<long long>(summary.form_left), static_cast<long long>(summary.frames() * scene.time.substeps));
    text += line.data();
  }
  return text;
}

std::string summary_text(MPI_Comm comm, const Scene& scene, const Summary& summary) {
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  Json files = Json::array();
  for (const auto& file : summary.files) files.push(file);
  Json j = Json::object();
  j.set("status", summary.status).set("scene", scene_json(scene, summary)).set("settings", settings_json(scene, summary.solver));
  Json plans = Json::array();
  for (const StepPlan& plan : summary.plans) plans.push(json_of(plan));
  j.set("plans", plans).set("versions", versions_json()).set("ranks", ranks);
  j.set("first_frame", summary.first_frame).set("last_frame", summary.last_frame);
  if (!summary.restarted_from.empty()) j.set("restarted_from", summary.restarted_from);
  if (!summary.continued_from.empty()) j.set("continued_from", summary.continued_from);
  j.set("convergence", json_of(summary.convergence, scene));
  if (!summary.side_faults.kinds.empty()) j.set("side_faults", json_of(summary.side_faults));
  if (const ErrorSamples& e = summary.errors; e.count > 0)
    j.set("error_estimates", Json::object()
                                 .set("samples", e.count)
                                 .set("worst", error_json(e.worst_frame, e.worst))
                                 .set("last", error_json(e.last_frame, e.last)));
  if (!scene.events.empty() || scene.bodies_come_and_go()) j.set("changes", json_of(summary.past, scene));
  if (scene.joints_break()) j.set("broken_joints", static_cast<std::int64_t>(summary.past.breaks.size()));
  j.set("peak_memory", peak_memory(comm));
  if (const CoarseCounts& c = summary.coarse; c.all() > 0)
    j.set("coarse_level", Json::object().set("solved", c.solved).set("touching", c.touching).set("gaining", c.gaining));
  if (scene.solver.form == Form::total) j.set("steps_in_incremental_form", summary.form_left);
  j.set(
      "borders_of_ranks",
      Json::object().set("guests_per_body (1)", summary.borders.guests).set("repeated_work (1)", summary.borders.repeated_work));
  j.set("timings", timings(summary)).set("final", final_json(summary.final)).set("files", files);
  return j.set("state_hash", hex(summary.state_hash)).text() + "\n";
}

void write_summary(MPI_Comm comm, const std::string& path, const Scene& scene, const Summary& summary) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const std::string text = summary_text(comm, scene, summary), part = path + ".part";
  std::string fault;
  try {
    if (rank == 0) {
      std::ofstream file(part);
      file << text << std::flush;
      if (!file) throw std::runtime_error("cannot write '" + path + "': is the disk full?");
      file.close();
      publish_file(part, path);
    }
  } catch (const std::exception& e) {
    fault = e.what();
  }
  fault = first_fault(comm, fault);
  if (!fault.empty()) throw RunError(fault);
}

}  // namespace unibody
