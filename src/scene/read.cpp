// read_scene: the sections of the file. A new section is one function and one line in `sections`.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "joints/coupling_set.hpp"
#include "joints/joint_set.hpp"
#include "scene/body_entry.hpp"
#include "scene/bonds.hpp"
#include "scene/couplings.hpp"
#include "scene/events.hpp"
#include "scene/flexible.hpp"
#include "scene/in_time.hpp"
#include "scene/joints.hpp"
#include "scene/materials.hpp"
#include "scene/outlets.hpp"
#include "scene/periodic.hpp"
#include "scene/probes.hpp"
#include "scene/resolution.hpp"
#include "scene/sections.hpp"
#include "scene/settings.hpp"
#include "scene/stiffness.hpp"
#include "scene/touching.hpp"

namespace unibody {

namespace {

constexpr RenamedKey renamed_time_keys[] = {{"step", "frame"}};  // which was the length of a frame all along

// What one of the two levels has no use for is refused there. (recovery_time and recovery_speed are of the position level alone,
// but any scene may have them.)
void check_level(const Value& value, const SolverSettings& solver) {
  const auto refuse = [&](const char* key, bool wrong, const std::string& expected) {
    const Value* found = value.find(key);
    if (found && wrong) found->fail_expected(expected);
  };
  if (solver.level == Level::position) {
    refuse("warm_start", solver.warm_start.value_or(0) > 0.5, position_shares);
    return refuse("stabilisation", true, "level: velocity beside it (position has recovery_time)");
  }
  refuse("warm_start", solver.warm_start.value_or(0) > 1, "auto or a number in [0, 1]");
  refuse("name", solver.name == "newton", "an iterative solver at level: velocity");
  refuse("stages", solver.stages != Stages::automatic, "auto at level: velocity, which has one stage");
  refuse("velocity_share", solver.velocity_share.has_value(), "auto at level: velocity, which has one stage");
  refuse("leak", solver.leak.has_value(), "auto at level: velocity, which has one stage");
  refuse("gap", solver.gap == Gap::reevaluated, "frozen at level: velocity, whose constraints are linear in a step");
  refuse("form", solver.form == Form::total, "incremental at level: velocity, whose constraints are linear in a step");
  refuse("coarse", solver.coarse, "false at level: velocity, whose constraints are linear in a step");
}

void check_accuracy(const Value& value, const SolverSettings& solver) {
  const Value* accuracy = value.find("accuracy");
  if (accuracy == nullptr || !solver.accuracy) return;
  if (solver.tolerance) value.find("tolerance")->fail_expected("auto beside an accuracy, which sets the tolerance");
  if (solver.name == "newton") accuracy->fail_expected("auto for newton, whose steps are solved as far as they go");
}

void check_coarse(const Value& value, const SolverSettings& solver) {
  if (!solver.coarse) return;
  const Value& coarse = *value.find("coarse");
  if (solver.name == "newton") coarse.fail_expected("false for newton, whose steps are solved as far as they go");
  if (solver.form == Form::total) coarse.fail_expected("false for form: total");
}

void read_solver(const Value& value, Scene& scene) {
  SolverSettings& solver = scene.solver;
  read_settings(value, solver_settings(), solver);
  check_level(value, solver);
  if (solver.name == "newton") solver.form = Form::incremental;  // its own steps have neither
  const Value* iterations = value.find("iterations");
  check_accuracy(value, solver);
  check_coarse(value, solver);
  const bool one_stage = solver.stages == Stages::position || solver.level == Level::velocity;
  if (solver.iterations && !one_stage && *solver.iterations < 2)
    iterations->fail_expected("an integer >= 2 (two stages; stages: position needs 1)");
}

void read_gravity(const Value& value, Scene& scene) {
  if (!is_vector_in_time(value)) {
    scene.gravity = read_vector(value, scene, "m/s^2");
    return;
  }
  const TimeVector gravity = read_planar_in_time(value, scene, "m/s^2", false);
  scene.gravity = gravity.at(0);
  if (gravity.changes()) scene.gravity_in_time = gravity;
}

Key gravity_key() { return keys::vector_in_time("gravity", "m/s^2", "[0, 0, -9.81]", "acceleration of all bodies"); }

void read_wind(const Value& value, Scene& scene) {
  if (is_vector_in_time(value)) {
    scene.wind = read_planar_in_time(value, scene, "m/s", false);
    return;
  }
  const Vec3 wind = read_vector(value, scene, "m/s");
  for (std::size_t k = 0; k < 3; ++k) scene.wind[k] = wind[static_cast<Eigen::Index>(k)];
}

Key wind_key() {
  return keys::vector_in_time("wind", "m/s", "[0, 0, 0]", "velocity of the air, felt by cloths and solids with drag");
}
Key air_density_key() { return keys::number("air_density", "kg/m^3", not_negative, 1.2, "density of the air"); }

Key settings_key(const char* name, const char* about, const std::function<Json()>& schema) {
  return keys::other(name, "", "a map", "as its keys say", about, schema);
}

void read_time(const Value& value, Scene& scene) {
  refuse_renamed(value, renamed_time_keys);
  read_settings(value, time_settings(), scene.time);
}

Key list_key(const char* name, KeysOf table, const char* about) {
  return keys::list_of_maps(name, table, "a list", "none", about);
}

// newton solves equations between the nodes of one flexible body, and knows no contacts.
void check_newton(const Value& name, const Scene& scene) {
  const std::string expected = "an iterative solver (newton is for one cloth, thread or solid alone, without contacts)";
  if (scene.constraint_groups.empty() || scene.groups.size() > scene.constraint_groups.size())
    name.fail("newton in a scene with bodies", expected);
  if (scene.constraint_groups.size() > 1) name.fail("newton in a scene with several flexible bodies", expected);
  if (std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [](const Surface& s) { return s.self_collision; }))
    name.fail("newton beside self_collision", expected);
  const ConstraintGroup& group = scene.constraint_groups.front();
  ConstraintSet some;
  group.touching(group.first, some);
  for_each_type(some, [&]<class C>(auto, const ConstraintList<C>& list) {
    if (is_unilateral<C> && !list.empty()) name.fail("newton beside constraints of type " + std::string(C::name), expected);
  });
}

// The total form is refused where it is known to diverge.
void check_form(const Value& root, const Scene& scene) {
  if (scene.solver.form != Form::total) return;
  const auto check = [&](double number, double most, const std::string& what, const std::string& instead) {
    if (number <= most) return;
    std::ostringstream found, expected;
    found << "total with " << scene.solver.name << " and " << what << ' ' << number;
    expected << "at most " << most << ", where it is known to converge: form: incremental, " << instead << "more substeps";
    root.find("solver")->find("form")->fail(found.str(), expected.str());
  };
  check(edge_motion(scene), most_edge_motion, "edges whose ends move in a step, as a share of their length, by", "or ");
  if (scene.solver.name == "gauss_seidel") return;
  check(stiffness_number(scene), stiffest_for_total, "constraints of stiffness number", "name: gauss_seidel, or ");
}

}  // namespace

const std::vector<Section>& sections() {
  static const std::vector<Section> list{
      {keys::text("title", "a text", "empty", "it stands in the report"),
       [](const Value& v, Scene& s) { s.title = v.string("a text"); }},
      {settings_key("time", "frames and steps", [] { return schema_of(time_settings()); }), read_time},
      {keys::flag("planar", false, "motion in x and z and turns about y alone"),
       [](const Value& v, Scene& s) { s.planar = v.boolean(); }},
      {keys::map("periodic", periodic_keys, "a map of x, y and z", "none", "directions in which the scene repeats itself"),
       read_periodic},
      {gravity_key(), read_gravity},
      {wind_key(), read_wind},
      {air_density_key(),
       [](const Value& v, Scene& s) { s.air_density = v.number(air_density_key().range, air_density_key().unit); }},
      {settings_key("solver", "how steps are solved", [] { return schema_of(solver_settings()); }), read_solver},
      {settings_key("output", "what is written", [] { return schema_of(output_settings()); }),
       [](const Value& v, Scene& s) { read_settings(v, output_settings(), s.output); }},
      {materials_key(), read_materials},
      {list_key("bodies", body_keys, "bodies, and generators of bodies"), read_bodies},
      {list_key("cloths", cloth_keys, "cloths"), read_cloths},
      {list_key("threads", thread_keys, "threads"), read_threads},
      {list_key("solids", solid_keys, "soft solids"), read_solids},
      {list_key("joints", joint_keys, "joints between bodies"), read_joints},
      {list_key("bonds", bond_keys,
                "fixed joints that may break, between all bodies of some entries that lie next to each other"),
       read_bonds},
      {list_key("couplings", coupling_keys, "joints whose angles or offsets go with each other, as by gears"), read_couplings},
      {list_key("probes", probe_keys, "what report.csv measures beside its usual columns"), read_probes},
      {list_key("outlets", outlet_keys, "boxes in which bodies leave the scene"), read_outlets},
      {list_key("events", event_keys, "what happens at a time, or when something else has happened"), read_events},
  };
  return list;
}

const Keys& scene_keys() {
  static const Keys table = [] {
    Keys keys{"scene", "The sections of a scene file.", {}};
    for (const Section& section : sections()) keys.keys.push_back(section.key);
    return keys;
  }();
  return table;
}

std::optional<Id> BodyGroup::number_of(const std::string& part) const {
  if (const auto found = std::ranges::find(names, part); found != names.end()) return found - names.begin();
  const auto other = std::ranges::find(other_names, part, &std::pair<std::string, Id>::first);
  return other == other_names.end() ? std::nullopt : std::optional(other->second);
}

const BodyGroup& Scene::group_of(Id id) const {
  if (id < 0 || id >= body_count())
    throw std::out_of_range("body " + std::to_string(id) + " of a scene with " + std::to_string(body_count()));
  const auto after = std::upper_bound(groups.begin(), groups.end(), id, [](Id i, const BodyGroup& g) { return i < g.first; });
  return *std::prev(after);
}

Id Scene::body_count() const { return groups.empty() ? 0 : groups.back().first + groups.back().count; }

bool Scene::has_rotations() const {
  const auto is_fixed = [](const BodyGroup& g) { return g.is_static && g.make(0).properties.motion == Motion::fixed; };
  return std::any_of(groups.begin(), groups.end(), [&](const BodyGroup& g) { return g.rotates && !is_fixed(g); });
}

Body Scene::body(Id id) const {
  const BodyGroup& group = group_of(id);
  return group.make(id - group.first);
}

bool Scene::bodies_come_and_go() const {
  const auto removes = [](const Event& event) { return event.action == Event::Action::remove; };
  return lacks_bodies || !outlets.empty() || std::ranges::any_of(events, removes) ||
         std::ranges::any_of(groups, [](const BodyGroup& g) { return g.start == Start::absent; });
}

bool Scene::joints_break() const {
  const auto releases = [](const Event& event) { return event.action == Event::Action::release && !event.joints.empty(); };
  return std::ranges::any_of(events, releases) || std::ranges::any_of(joints, [](const Joint& j) { return j.bears.any(); });
}

std::string Scene::body_name(Id id) const {
  const BodyGroup& group = group_of(id);
  const auto number = static_cast<std::size_t>(id - group.first);
  if (number < group.names.size()) return group.name + "/" + group.names[number];
  if (group.name.empty()) return "body " + std::to_string(id);
  return group.count == 1 ? group.name : group.name + "[" + std::to_string(id - group.first) + "]";
}

namespace {

// What has broken stays so, and whether a joint breaks hangs on what it bears: where the scene leaves the iterations open, they
// are as many as an accuracy takes. With the coarsest a bar that is loaded at once may swing so far that its joints bear 4 % too
// much.
void take_care_of_breaking(Scene& scene) {
  constexpr double accuracy_of_breaking = named_accuracies[1].share;
  SolverSettings& solver = scene.solver;
  const bool breaks = std::ranges::any_of(scene.joints, [](const Joint& joint) { return joint.bears.any(); });
  if (breaks && !solver.accuracy && !solver.iterations && !solver.tolerance && solver.name != "newton")
    solver.accuracy = accuracy_of_breaking;
}

void read_sections(const Value& root, Scene& scene) {
  const KeyedMap map(root, scene_keys());
  for (const Section& section : sections())
    if (const Value* value = map.find(section.key.name)) section.read(*value, scene);
}

Scene read_root(const Value& root, const std::string& path, const Room& room) {
  Scene scene;
  scene.path = path;
  scene.room = room;
  read_sections(root, scene);
  if (scene.groups.empty()) root.fail_missing("bodies", "a list of bodies and generators");
  take_care_of_breaking(scene);
  check_starts(root, scene);
  read_touching(root, scene);
  check_periodic(root, scene);
  check_resolution(scene);
  check_form(root, scene);
  const auto is_static = [&](Id id) { return scene.group_of(id).is_static; };
  scene.joint_colours = colour_joints(scene.joints, is_static);
  scene.coupling_colours = colour_couplings(scene.couplings, is_static);
  if (scene.solver.joints == JointSolve::direct) scene.joint_trees = plant_trees(scene.joints, is_static);
  if (scene.solver.name == "newton") check_newton(*root.find("solver")->find("name"), scene);
  return scene;
}

}  // namespace

Scene read_scene(const std::string& path, const std::vector<Override>& overrides, const Room& room) {
  return read_root(load_value(path, overrides), path, room);
}

Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides,
                      const Room& room) {
  return read_root(value_of_text(text, path, overrides), path, room);
}

}  // namespace unibody
