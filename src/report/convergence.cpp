#include "report/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "report/report.hpp"

namespace unibody {

namespace {

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2e", x);
  return text.data();
}

std::string verdict(const Convergence& c) {
  const std::string all = std::to_string(c.residuals.size()), tolerance = number(c.tolerance) + " m";
  if (c.tolerance == 0) return "tolerance 0: all iterations were made";
  if (c.unconverged == 0) return "converged: all of " + all + " frames, to the tolerance of " + tolerance;
  return "not converged: " + std::to_string(c.unconverged) + " of " + all + " frames, to the tolerance of " + tolerance;
}

}  // namespace

void Convergence::add(const FrameReport& report) {
  residuals.push_back(report.natural_residual);
  unconverged += report.converged ? 0 : 1;
  if (report.natural_residual <= worst_residual) return;
  // A step is asked for the name where its residual is above all that were before it.
  worst = report.worst;
  worst_residual = report.natural_residual;
  worst_frame = report.step;
}

double Convergence::within(double share) const {
  if (residuals.empty()) return 0;
  const double count = std::ceil(share * static_cast<double>(residuals.size()));
  std::vector<double> sorted = residuals;
  const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(std::max(count, 1.0)) - 1;
  std::nth_element(sorted.begin(), place, sorted.end());
  return *place;
}

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
  std::string text = verdict(c) + "\n";
  if (c.residuals.empty()) return text;
  text += "natural residual: half of the frames within " + number(c.within(0.5)) + " m, 95 % within " + number(c.within(0.95)) +
          " m, all within " + number(c.worst_residual) + " m";
  if (std::isfinite(c.smallest_size) && c.smallest_size > 0)
    text += ", which is " + number(c.worst_residual / c.smallest_size) + " of the smallest moving body's size";
  text += "\n";
  if (c.worst) text += "farthest from solved: frame " + std::to_string(c.worst_frame) + ", " + told(*c.worst, scene) + "\n";
  return text;
}

Json json_of(const Convergence& c, const Scene& scene) {
  Json json = Json::object();
  json.set("tolerance (m)", c.tolerance).set("frames_not_converged", c.unconverged);
  json.set("median_natural_residual (m)", c.within(0.5)).set("natural_residual_of_95_percent (m)", c.within(0.95));
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
