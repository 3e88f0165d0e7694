#include "report/convergence.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/report.hpp"
#include "report/side_faults.hpp"

namespace unibody {

namespace {

std::string of_all(std::int64_t count, const Convergence& c) {
  const std::string all = std::to_string(c.residuals.count());
  return (count == c.residuals.count() ? "all of " : std::to_string(count) + " of ") + all + " frames";
}

std::string spread(const Figures& figures, double unit, const std::string& name) {
  const auto part = [&](double share) { return exponent_text(figures.within(share) / unit) + name; };
  return "half within " + part(0.5) + ", 95 % within " + part(0.95) + ", all within " + part(1);
}

// What may be done where not all frames of the run are within the accuracy.
std::string advice(const Convergence& c) {
  if (c.asked && c.unconverged > 0)
    return "in " + of_all(c.unconverged, c) +
           " the solve ended short of it, its iterations used up or hardly of use: more of them, or more time.substeps, may do\n";
  if (c.asked) return "";
  return "no accuracy is asked for: with solver.accuracy the program picks the iterations (docs/accuracy.md)\n";
}

std::string verdict(const Convergence& c) {
  const std::string size = " of the smallest moving body's size (" + exponent_text(c.allowed()) + " m)";
  std::string text = c.asked ? "accuracy " + number_text(c.accuracy) + size + " asked: held in " + of_all(c.held, c)
                             : "accuracy: " + of_all(c.held, c) + " are within " + number_text(c.accuracy) + size;
  text += "\nwhat they are off by, over that size: " + spread(c.offs, c.smallest_size, "");
  if (c.most_off.length > 0)
    text += " (frame " + std::to_string(c.most_off_frame) + ", " +
            std::string(fault_names[static_cast<std::size_t>(c.most_off.fault)]) + ")";
  return text + "\n" + (c.held < c.offs.count() ? advice(c) : "");
}

std::string told_residuals(const Convergence& c) {
  std::string text = "natural residual: " + spread(c.residuals, 1, " m");
  if (c.asked) return text + "\n";
  if (c.tolerance == 0) return text + "; the tolerance is 0: all iterations were made\n";
  const std::int64_t converged = c.residuals.count() - c.unconverged;
  return text + "; " + of_all(converged, c) + " converged to the tolerance of " + exponent_text(c.tolerance) + " m\n";
}

}  // namespace

Off off_by(const FrameReport& report, bool asked) {
  Off off{report.natural_residual, Fault::residual};
  const auto take = [&](double length, Fault fault) {
    if (length > off.length) off = {length, fault};
  };
  if (asked) off = {report.estimated_error, Fault::error};
  take(report.turning, Fault::turning);
  take(report.measures.penetration_max, Fault::penetration);
  take(report_value(report, "joint_drift_max").value_or(0), Fault::joint_drift);
  return off;
}

void Convergence::add(const FrameReport& report) {
  const Off off = off_by(report, asked);
  offs.add(off.length), residuals.add(report.natural_residual), rates.add(report.residual_rate);
  held += off.length <= allowed() && side_faults(report).empty() ? 1 : 0;
  if (off.length > most_off.length) most_off = off, most_off_frame = report.step;
  unconverged += report.converged ? 0 : 1;
  if (report.natural_residual <= worst_residual) return;
  // A step is asked for the name where its residual is above all that were before it.
  worst = report.worst;
  worst_residual = report.natural_residual;
  worst_frame = report.step;
}

bool Convergence::judges() const { return std::isfinite(smallest_size) && smallest_size > 0 && offs.count() > 0; }

double Convergence::allowed() const { return accuracy * smallest_size; }

std::string told(const WorstConstraint& worst, const Scene& scene) {
  std::string text(worst.kind), link = " of ";
  for (const Id id : worst.bodies) {
    if (id == WorstConstraint::none) continue;
    text += link + scene.body_name(id);
    link = " and ";
  }
  return text;
}

std::string told(const Convergence& c, const Scene& scene) {
  if (c.residuals.count() == 0) return "";
  std::string text = (c.judges() ? verdict(c) : "") + told_residuals(c);
  text += "what should rest may creep by so much a second: " + spread(c.rates, 1, " m") + "\n";
  if (c.worst) text += "farthest from solved: frame " + std::to_string(c.worst_frame) + ", " + told(*c.worst, scene) + "\n";
  return text;
}

Json json_of(const Convergence& c, const Scene& scene) {
  Json json = Json::object();
  if (c.judges()) {
    json.set("accuracy", c.accuracy).set("accuracy_asked", c.asked).set("frames_within_accuracy", c.held);
    json.set("median_off (m)", c.offs.within(0.5)).set("off_of_95_percent (m)", c.offs.within(0.95));
    json.set("most_off (m)", c.most_off.length).set("most_off_frame", c.most_off_frame);
    json.set("most_off_by", std::string(fault_names[static_cast<std::size_t>(c.most_off.fault)]));
  }
  json.set("tolerance (m)", c.tolerance).set("frames_not_converged", c.unconverged);
  json.set("median_natural_residual (m)", c.residuals.within(0.5));
  json.set("natural_residual_of_95_percent (m)", c.residuals.within(0.95));
  json.set("median_natural_residual_rate (m/s)", c.rates.within(0.5));
  json.set("worst_natural_residual_rate (m/s)", c.rates.within(1));
  json.set("worst_natural_residual (m)", c.worst_residual).set("worst_frame", c.worst_frame);
  if (std::isfinite(c.smallest_size)) json.set("smallest_size (m)", c.smallest_size);
  if (!c.worst) return json;
  Json ids = Json::array(), names = Json::array();
  for (const Id id : c.worst->bodies)
    if (id != WorstConstraint::none) ids.push(id), names.push(scene.body_name(id));
  return json.set("worst_constraint",
                  Json::object().set("kind", std::string(c.worst->kind)).set("bodies", ids).set("names", names));
}

}  // namespace unibody
