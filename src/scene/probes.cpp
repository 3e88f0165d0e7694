#include "scene/probes.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/text.hpp"
#include "scene/body_entry.hpp"

namespace unibody {

namespace {

// Nodes of flexible bodies have ids behind those of bodies.
Id end_of_bodies(const Scene& scene) {
  Id end = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) end = std::min(end, group.first);
  return end;
}

void read_flow(const Value& flow, const Scene& scene, Probe& probe) {
  flow.map({"point", "normal", "radius"});
  probe.kind = Probe::Kind::flow;
  probe.point = read_vector(flow.need("point", "a point of the plane (m)"), scene, "m");
  probe.normal = flow.need("normal", "a vector of length 1").unit_vector();
  if (const Value* radius = flow.find("radius")) probe.radius = radius->number(positive, "m");
}

void read_box_of(const Value& box, Probe::Kind kind, Probe& probe) {
  box.map({"low", "high"});
  probe.kind = kind;
  probe.low = box.need("low", "a corner (m)").vector(any_number, "m");
  const Value& high = box.need("high", "the other corner (m)");
  probe.high = high.vector(any_number, "m");
  if (!(probe.low.array() < probe.high.array()).all())
    high.fail_expected("a corner that is above the other one along each axis (m)");
}

// The bodies of the entry that has this name, in whatever section it is. NAME[k] means one of them, counted from 0.
IdRange read_named(const Value& value, const Scene& scene) {
  const std::string expected = "the name of an entry of bodies, cloths, threads or solids, or one of its bodies as name[0]";
  std::string name = value.string(expected);
  Id number = -1;
  if (const auto bracket = name.find('['); bracket != std::string::npos && name.back() == ']') {
    const char *first = name.data() + bracket + 1, *last = name.data() + name.size() - 1;
    const auto result = std::from_chars(first, last, number);
    if (result.ec != std::errc() || result.ptr != last || number < 0) value.fail_expected(expected);
    name.resize(bracket);
  }
  const auto is_named = [&](const BodyGroup& g) { return !name.empty() && g.name == name; };
  const auto group = std::ranges::find_if(scene.groups, is_named);
  if (group == scene.groups.end()) {
    std::vector<std::string> names;
    for (const BodyGroup& g : scene.groups) names.push_back(g.name);
    value.fail(value.found() + ", a name that no entry has" + did_you_mean(name, names), expected);
  }
  if (const auto others = std::count_if(std::next(group), scene.groups.end(), is_named); others > 0)
    value.fail(value.found() + ", the name of " + std::to_string(others + 1) + " entries", expected);
  if (number >= group->count)
    value.fail(value.found() + " of " + std::to_string(group->count), "a number below " + std::to_string(group->count));
  return number < 0 ? IdRange{group->first, group->first + group->count}
                    : IdRange{group->first + number, group->first + number + 1};
}

void refuse_bodies(const Value& entry, const std::string& beside) {
  for (const char* key : {"of", "material"})
    if (const Value* other = entry.find(key)) other->fail_expected("no such key beside " + beside);
}

void read_force(const Value& entry, const Value& force, const Scene& scene, Probe& probe) {
  force.map({"on", "by", "about"});
  refuse_bodies(entry, "force, which has on and by");
  probe.kind = Probe::Kind::force;
  probe.on = read_named(force.need("on", "the name of an entry"), scene);
  if (const Value* by = force.find("by")) probe.by = read_named(*by, scene);
  if (const Value* about = force.find("about")) probe.point = read_vector(*about, scene, "m");
}

void read_stress(const Value& entry, const Value& stress, Probe& probe) {
  refuse_bodies(entry, "stress, which is that of all contacts in its box");
  read_box_of(stress, Probe::Kind::stress, probe);
}

// The one value that says what the probe measures.
const Value* kind_of(const Value& entry) {
  const Value* found = nullptr;
  for (const char* key : {"flow", "box", "force", "stress"}) {
    const Value* value = entry.find(key);
    if (value && found) value->fail(std::string(key) + " beside another measurement", "only one of flow, box, force and stress");
    if (value) found = value;
  }
  if (!found)
    entry.fail_missing("flow", "a map with point and normal, or box or stress: one with low and high, or force: one with on");
  return found;
}

}  // namespace

// Its columns' names are words of a CSV file.
std::string read_column_name(const Value& value, const std::vector<std::string>& taken, const std::string& what) {
  const std::string name = value.string("a name");
  const auto is_good = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; };
  if (name.empty() || !std::ranges::all_of(name, is_good)) value.fail_expected("a name of letters, digits, - and _");
  if (std::ranges::find(taken, name) != taken.end()) value.fail(name + " a second time", "a name of its own for each " + what);
  return name;
}

ProbedBodies read_probed(const Value& entry, const Scene& scene) {
  ProbedBodies bodies{0, end_of_bodies(scene), -1};
  if (const Value* of = entry.find("of")) {
    const std::string name = of->string("the name of an entry of bodies");
    const auto group =
        std::ranges::find_if(scene.groups, [&](const BodyGroup& g) { return g.name == name && g.first < bodies.end; });
    if (group == scene.groups.end()) of->fail_expected("the name of an entry of bodies");
    if (group->is_static) of->fail(name + ", which the scene moves or holds", "bodies that are dynamic");
    bodies.first = group->first, bodies.end = group->first + group->count;
  }
  if (const Value* material = entry.find("material")) bodies.material = static_cast<int>(material->choice(scene.materials));
  return bodies;
}

std::vector<std::string> probe_keys() { return {"name", "of", "material", "flow", "box", "force", "stress"}; }

void read_probes(const Value& list, Scene& scene) {
  std::vector<std::string> names;
  for (const Value& entry : list.list("probes")) {
    entry.map(probe_keys());
    Probe probe;
    probe.name = read_column_name(entry.need("name", "a name"), names, "probe");
    names.push_back(probe.name);
    probe.bodies = read_probed(entry, scene);
    const Value* kind = kind_of(entry);
    if (kind == entry.find("flow")) read_flow(*kind, scene, probe);
    if (kind == entry.find("box")) read_box_of(*kind, Probe::Kind::box, probe);
    if (kind == entry.find("force")) read_force(entry, *kind, scene, probe);
    if (kind == entry.find("stress")) read_stress(entry, *kind, probe);
    scene.probes.push_back(std::move(probe));
  }
}

}  // namespace unibody
