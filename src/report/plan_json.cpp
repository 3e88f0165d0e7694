#include "report/plan_json.hpp"

#include <array>

namespace unibody {

Json json_of(const StepPlan& plan) {
  constexpr std::array<std::string_view, 3> islands_names{"all", "free", "constrained"};
  const auto acceleration = [](Acceleration a) { return acceleration_names[static_cast<std::size_t>(a)]; };
  Json json = Json::object();
  json.set("islands", islands_names[static_cast<std::size_t>(plan.islands)]);
  json.set("form", form_names[static_cast<std::size_t>(plan.form)]);
  json.set("stages", stages_names[static_cast<std::size_t>(plan.stages)]);
  json.set("iterations", plan.iterations).set("tolerance (m)", plan.tolerance).set("margin (m)", plan.margin);
  if (plan.least_position_iterations > 0) {
    json.set("aim (m)", plan.aim).set("least_velocity_iterations", plan.least_velocity_iterations);
    json.set("least_position_iterations", plan.least_position_iterations);
  }
  json.set("recovery_speed (m/s)", plan.recovery_speed).set("recovery_time (s)", plan.recovery_time);
  json.set("surface_recovery_time (s)", plan.surface_recovery_time);
  json.set("has_velocity_stage", plan.two_stages).set("velocity_iterations", plan.velocity_iterations);
  json.set("velocity_share", plan.velocity_share).set("leak", plan.leak).set("swelling", plan.swelling);
  json.set("most_weights", plan.most_weights);
  json.set("contacts_share", plan.contacts_share).set("share", plan.share).set("uneven_share", plan.uneven_share);
  json.set("solids_start_cold", plan.solids_start_cold);
  json.set("velocity_acceleration", acceleration(plan.velocity_acceleration));
  json.set("position_acceleration", acceleration(plan.position_acceleration));
  return json.set("most_stiffness", plan.most_stiffness);
}

}  // namespace unibody
