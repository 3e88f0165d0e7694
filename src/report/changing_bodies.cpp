#include "report/changing_bodies.hpp"

#include "core/checked.hpp"
#include "core/text.hpp"
#include "scene/events.hpp"

namespace unibody {

std::optional<ChangingBodies> changing_bodies(const Scene& scene) {
  if (!scene.bodies_come_and_go()) return {};
  Id first_node = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) first_node = std::min(first_node, group.first);
  return ChangingBodies{[&scene](Id id) { return scene.body(id); }, first_node};
}

namespace {

std::string when_of(const Event& event) {
  if (!event.when) return "at " + number_text(event.time, 4) + " s";
  return "when " + event.when->column + (event.when->above ? " is above " : " is below ") + number_text(event.when->value, 4);
}

std::string bodies_of(Id number, double mass) {
  return std::to_string(number) + (number == 1 ? " body (" : " bodies (") + number_text(mass, 4) + " kg)";
}

// Calls f(group, past) for each inlet.
template <class F>
void for_each_inlet(const Scene& scene, const Past& past, F&& f) {
  std::size_t inlet = 0;
  for (const BodyGroup& group : scene.groups)
    if (group.inlet) f(group, past.inlets[inlet++]);
}

}  // namespace

std::vector<std::string> told_changes(const Scene& scene) {
  std::vector<std::string> lines;
  for (const BodyGroup& group : scene.groups)
    if (group.inlet) lines.push_back("  inlet  " + group.name + ": up to " + std::to_string(group.count) + " bodies come in");
  for (const Outlet& outlet : scene.outlets) lines.push_back("  outlet  " + outlet.name + ": bodies leave there");
  for (const Event& event : scene.events) lines.push_back("  event  " + text_of(event, scene) + " " + when_of(event));
  return lines;
}

std::string told(const Past& past, const Scene& scene) {
  std::string text;
  for_each_inlet(scene, past, [&](const BodyGroup& group, const InletPast& inlet) {
    text += "inlet " + group.name + ": " + bodies_of(inlet.placed, inlet.placed_mass) + " came in";
    if (!inlet.waiting.empty()) text += ", " + std::to_string(inlet.waiting.size()) + " that are due have found no room yet";
    text += "\n";
  });
  for (std::size_t o = 0; o < past.outlets.size(); ++o)
    text +=
        "outlet " + scene.outlets[o].name + ": " + bodies_of(past.outlets[o].removed, past.outlets[o].removed_mass) + " left\n";
  for (std::size_t e = 0; e < past.events.size(); ++e) {
    if (scene.events[e].action == Event::Action::end) continue;
    const std::int64_t frame = past.events[e];
    const std::string happened = frame > 0 ? "from frame " + std::to_string(frame) + " on" : "has not happened";
    text += "event " + text_of(scene.events[e], scene) + " " + when_of(scene.events[e]) + ": " + happened + "\n";
  }
  return text;
}

Json json_of(const Past& past, const Scene& scene) {
  Json inlets = Json::array(), outlets = Json::array(), events = Json::array();
  for_each_inlet(scene, past, [&](const BodyGroup& group, const InletPast& inlet) {
    inlets.push(Json::object()
                    .set("name", group.name)
                    .set("placed", inlet.placed)
                    .set("placed_mass (kg)", inlet.placed_mass)
                    .set("waiting", static_cast<std::int64_t>(inlet.waiting.size())));
  });
  for (std::size_t o = 0; o < past.outlets.size(); ++o)
    outlets.push(Json::object()
                     .set("name", scene.outlets[o].name)
                     .set("removed", past.outlets[o].removed)
                     .set("removed_mass (kg)", past.outlets[o].removed_mass));
  for (std::size_t e = 0; e < past.events.size(); ++e)
    events.push(Json::object().set("event", text_of(scene.events[e], scene)).set("first_frame", past.events[e]));
  return Json::object().set("inlets", inlets).set("outlets", outlets).set("events", events);
}

std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past) {
  std::vector<NamedValue> columns;
  if (!scene.bodies_come_and_go()) return columns;
  auto bodies = static_cast<std::int64_t>(world.homes);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &bodies, 1, MPI_INT64_T, MPI_SUM, comm));
  bodies += static_cast<std::int64_t>(world.size() - world.first_static());
  columns.push_back({"bodies (1)", static_cast<double>(bodies)});
  std::size_t inlet = 0;
  for (const BodyGroup& group : scene.groups) {
    if (!group.inlet) continue;
    const InletPast of = inlet < past.inlets.size() ? past.inlets[inlet] : InletPast{};
    ++inlet;
    const std::string name = "inlet_" + group.name;
    columns.push_back({name + "_placed (1)", static_cast<double>(of.placed)});
    columns.push_back({name + "_placed_mass (kg)", of.placed_mass});
    columns.push_back({name + "_waiting (1)", static_cast<double>(of.waiting.size())});
  }
  for (std::size_t o = 0; o < scene.outlets.size(); ++o) {
    const OutletPast of = o < past.outlets.size() ? past.outlets[o] : OutletPast{};
    const std::string name = "outlet_" + scene.outlets[o].name;
    columns.push_back({name + "_removed (1)", static_cast<double>(of.removed)});
    columns.push_back({name + "_removed_mass (kg)", of.removed_mass});
  }
  return columns;
}

}  // namespace unibody
