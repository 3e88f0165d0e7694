// read_scene: the sections of the file, each a table of its keys. A new section is one function and one line in `sections`.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "joints/joint_set.hpp"
#include "scene/body_entry.hpp"
#include "scene/events.hpp"
#include "scene/flexible.hpp"
#include "scene/in_time.hpp"
#include "scene/joints.hpp"
#include "scene/outlets.hpp"
#include "scene/probes.hpp"
#include "scene/resolution.hpp"
#include "scene/settings.hpp"
#include "scene/stiffness.hpp"

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
}

void check_accuracy(const Value& value, const SolverSettings& solver) {
  const Value* accuracy = value.find("accuracy");
  if (accuracy == nullptr || !solver.accuracy) return;
  if (solver.tolerance) value.find("tolerance")->fail_expected("auto beside an accuracy, which sets the tolerance");
  if (solver.name == "newton") accuracy->fail_expected("auto for newton, whose steps are solved as far as they go");
}

void read_solver(const Value& value, Scene& scene) {
  SolverSettings& solver = scene.solver;
  read_settings(value, solver_settings(), solver);
  check_level(value, solver);
  if (solver.name == "newton") solver.form = Form::incremental;  // its own steps have neither
  const Value* iterations = value.find("iterations");
  check_accuracy(value, solver);
  if (solver.accuracy && !iterations) solver.iterations = iterations_of_accuracy;
  const bool one_stage = solver.stages == Stages::position || solver.level == Level::velocity;
  if (iterations && !one_stage && solver.iterations < 2)
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

double read_or(const Value& map, const char* key, const Range& range, const char* unit, double otherwise) {
  const Value* value = map.find(key);
  return value ? value->number(range, unit) : otherwise;
}

TimeValue read_friction(const Value& map) { return read_in_time(map.need("friction", "a number >= 0"), not_negative, ""); }

// What a pair of materials may say beside its friction, and of a pair that isn't listed, what it has from its two materials.
struct PairKey {
  const char *key, *unit;
  Range range;
  std::vector<double> Scene::*values;
  double (*mix)(double, double);
};
double smaller(double a, double b) { return std::min(a, b); }
double geometric_mean(double a, double b) { return std::sqrt(a * b); }
const PairKey pair_keys[] = {{"restitution", "", {0, 1}, &Scene::restitution, smaller},
                             {"rolling_friction", "m", not_negative, &Scene::rolling, geometric_mean},
                             {"spinning_friction", "m", not_negative, &Scene::spinning, geometric_mean}};

std::vector<std::string> material_keys(std::vector<std::string> keys) {
  keys.emplace_back("friction");
  for (const PairKey& k : pair_keys) keys.emplace_back(k.key);
  return keys;
}

using Pairs = std::set<std::pair<std::size_t, std::size_t>>;

void read_pair(const Value& pair, Scene& scene, Pairs& listed, FrictionInTime& friction) {
  pair.map(material_keys({"between"}));
  const Value* between = pair.find("between");
  if (!between) pair.fail_missing("between", "a list of 2 materials");
  if (between->kind != Value::Kind::list || between->entries.size() != 2) between->fail_expected("a list of 2 materials");
  const std::size_t a = between->entries[0].choice(scene.materials), b = between->entries[1].choice(scene.materials);
  if (a == b) between->fail_expected("two different materials");
  if (!listed.emplace(std::min(a, b), std::max(a, b)).second)
    between->fail(between->found() + " a second time", "each pair once");
  const std::size_t n = scene.materials.size();
  bool other = false;
  for (const PairKey& k : pair_keys) {
    std::vector<double>& values = scene.*k.values;
    values[a * n + b] = values[b * n + a] = read_or(pair, k.key, k.range, k.unit, values[a * n + b]);
    other |= pair.find(k.key) != nullptr;
  }
  if (pair.find("friction") || !other) friction.pairs[a * n + b] = friction.pairs[b * n + a] = read_friction(pair);
}

// Names with what they are, and the key `pairs`. A pair that isn't listed has the geometric mean of its two materials; its
// restitution is the smaller of the two.
void read_materials(const Value& value, Scene& scene) {
  if (value.kind != Value::Kind::map) value.fail_expected("a map of materials");
  scene.materials.clear();
  FrictionInTime friction;
  std::array<std::vector<double>, std::size(pair_keys)> others;
  for (const auto& [name, material] : value.children) {
    if (name == "pairs") continue;
    scene.materials.push_back(name);
    friction.materials.push_back(read_friction(material.map(material_keys({}))));
    for (std::size_t k = 0; k < others.size(); ++k)
      others[k].push_back(read_or(material, pair_keys[k].key, pair_keys[k].range, pair_keys[k].unit, 0));
  }
  if (friction.materials.empty()) value.fail("no material", "at least one, as wood: {friction: 0.5}");
  const std::size_t n = friction.materials.size();
  friction.pairs.resize(n * n);
  const auto mix = [n](const std::vector<double>& own, double (*rule)(double, double)) {
    std::vector<double> all;
    for (std::size_t i = 0; i < n * n; ++i) all.push_back(i / n == i % n ? own[i / n] : rule(own[i / n], own[i % n]));
    return all;
  };
  for (std::size_t k = 0; k < others.size(); ++k) scene.*pair_keys[k].values = mix(others[k], pair_keys[k].mix);
  Pairs listed;
  if (const Value* pairs = value.find("pairs"))
    for (const Value& pair : pairs->list("pairs of materials")) read_pair(pair, scene, listed, friction);
  scene.friction = friction.at(0);
  if (friction.changes()) scene.friction_in_time = std::move(friction);
}

// The sections in the order in which they are read: `planar` and `materials` stand before the bodies that lean on them.
const Field<Scene> sections[] = {
    {"title", [](const Value& v, Scene& s) { s.title = v.string("a text"); }},
    {"time",
     [](const Value& v, Scene& s) {
       refuse_renamed(v, renamed_time_keys);
       read_settings(v, time_settings(), s.time);
     }},
    {"planar", [](const Value& v, Scene& s) { s.planar = v.boolean(); }},
    {"gravity", read_gravity},
    {"wind", [](const Value& v, Scene& s) { s.wind = read_vector(v, s, "m/s"); }},
    {"air_density", [](const Value& v, Scene& s) { s.air_density = v.number(not_negative, "kg/m^3"); }},
    {"solver", read_solver},
    {"output", [](const Value& v, Scene& s) { read_settings(v, output_settings(), s.output); }},
    {"materials", read_materials},
    {"bodies", read_bodies},
    {"cloths", read_cloths},
    {"threads", read_threads},
    {"solids", read_solids},
    {"joints", read_joints},
    {"probes", read_probes},
    {"outlets", read_outlets},
    {"events", read_events},
};

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
  return !outlets.empty() || std::ranges::any_of(events, removes) ||
         std::ranges::any_of(groups, [](const BodyGroup& g) { return g.start == Start::absent; });
}

std::string Scene::body_name(Id id) const {
  const BodyGroup& group = group_of(id);
  if (group.name.empty()) return "body " + std::to_string(id);
  return group.count == 1 ? group.name : group.name + "[" + std::to_string(id - group.first) + "]";
}

namespace {

Scene read_sections(const Value& root, const std::string& path, const Room& room) {
  Scene scene;
  scene.path = path;
  scene.room = room;
  read_fields(root, sections, scene);
  if (scene.groups.empty()) root.fail_missing("bodies", "a list of bodies and generators");
  check_starts(root, scene);
  check_resolution(scene);
  check_form(root, scene);
  const auto is_static = [&](Id id) { return scene.group_of(id).is_static; };
  scene.joint_colours = colour_joints(scene.joints, is_static);
  if (scene.solver.joints == JointSolve::direct) scene.joint_trees = plant_trees(scene.joints, is_static);
  if (scene.solver.name == "newton") check_newton(*root.find("solver")->find("name"), scene);
  return scene;
}

}  // namespace

Scene read_scene(const std::string& path, const std::vector<Override>& overrides, const Room& room) {
  return read_sections(load_value(path, overrides), path, room);
}

Scene read_scene_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides,
                      const Room& room) {
  return read_sections(value_of_text(text, path, overrides), path, room);
}

}  // namespace unibody
