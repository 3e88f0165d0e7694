#include "scene/probes.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/text.hpp"
#include "scene/body_entry.hpp"
#include "scene/entry_name.hpp"
#include "scene/outlets.hpp"

namespace unibody {

namespace {

// Nodes of flexible bodies have ids behind those of bodies.
Id end_of_bodies(const Scene& scene) {
  Id end = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) end = std::min(end, group.first);
  return end;
}

const Keys& flow_keys() {
  static const Keys table{"flow",
                          "A plane, or a disc of one, through which bodies go.",
                          {keys::vector("point", "m", needed, "a point of the plane, the middle of the disc"),
                           keys::direction("normal", needed, "the way that counts as positive"),
                           keys::number("radius", "m", positive, "no bound", "radius of the disc")}};
  return table;
}

const Keys& force_keys() {
  static const Keys table{"force",
                          "The entries between which contacts exert forces.",
                          {keys::text("on", "the name of an entry", needed, "the entry on which the forces act"),
                           keys::text("by", "the name of an entry", "all others", "the one other entry whose contacts count"),
                           keys::vector("about", "m", "the origin", "point about which the torque is")}};
  return table;
}

void read_flow(const Value& flow, const Scene& scene, Probe& probe) {
  const KeyedMap map(flow, flow_keys());
  probe.kind = Probe::Kind::flow;
  probe.point = read_vector(map, "point", scene);
  probe.normal = map.direction("normal");
  probe.radius = map.number_if("radius").value_or(probe.radius);
}

void read_box_of(const Value& box, Probe::Kind kind, Probe& probe) {
  probe.kind = kind;
  std::tie(probe.low, probe.high) = read_corners(box);
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
  std::string part;  // as a link of a robot
  if (const auto slash = name.find('/'); slash != std::string::npos) part = name.substr(slash + 1), name.resize(slash);
  const BodyGroup* group = &entry_named(value, name, scene, Entries::all, expected);
  if (!part.empty()) {
    const std::optional<Id> found = group->number_of(part);
    if (!found)
      value.fail(value.found() + ", a name that no part of " + name + " has" + did_you_mean(part, group->names), expected);
    number = *found;
  }
  if (number >= group->count)
    value.fail(value.found() + " of " + std::to_string(group->count), "a number below " + std::to_string(group->count));
  return number < 0 ? IdRange{group->first, group->first + group->count}
                    : IdRange{group->first + number, group->first + number + 1};
}

void read_force(const KeyedMap& entry, const Value& force, const Scene& scene, Probe& probe) {
  const KeyedMap map(force, force_keys());
  entry.none_of({"of", "material"}, "beside force, which has on and by");
  probe.kind = Probe::Kind::force;
  probe.on = read_named(map.need("on"), scene);
  if (const Value* by = map.find("by")) probe.by = read_named(*by, scene);
  if (map.has("about")) probe.point = read_vector(map, "about", scene);
}

void read_stress(const KeyedMap& entry, const Value& stress, Probe& probe) {
  entry.none_of({"of", "material"}, "beside stress, which is that of all contacts in its box");
  read_box_of(stress, Probe::Kind::stress, probe);
}

void read_cell(const Value& value, const Scene& scene, Probe& probe) {
  const std::string expected = "the name of an entry of bodies with triaxial", name = value.string(expected);
  const BodyGroup& group = entry_named(value, name, scene, Entries::bodies, expected);
  if (!group.cell) value.fail_expected(expected);
  probe.kind = Probe::Kind::cell, probe.cell = group.cell;
  probe.on = {group.first, group.first + group.count};
}

void read_measurement(const KeyedMap& entry, const Scene& scene, Probe& probe) {
  entry.only_one_of({"flow", "box", "force", "stress", "cell"});
  if (const Value* flow = entry.find("flow")) return read_flow(*flow, scene, probe);
  if (const Value* box = entry.find("box")) return read_box_of(*box, Probe::Kind::box, probe);
  if (const Value* force = entry.find("force")) return read_force(entry, *force, scene, probe);
  if (const Value* stress = entry.find("stress")) return read_stress(entry, *stress, probe);
  if (const Value* cell = entry.find("cell")) return read_cell(*cell, scene, probe);
  entry.value().fail_missing(
      "flow",
      "a map with point and normal, or box or stress: one with low and high, or force: one with on, or cell: "
      "a name");
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

const Keys& probed_keys() {
  static const Keys table{"bodies chosen",
                          "",
                          {keys::text("of", "the name of an entry of bodies", "all", "the bodies of this entry alone"),
                           keys::text("material", "a material", "all", "the bodies of this material alone")}};
  return table;
}

ProbedBodies read_probed(const KeyedMap& entry, const Scene& scene) {
  ProbedBodies bodies{0, end_of_bodies(scene), -1};
  if (const Value* of = entry.find("of")) {
    const std::string name = of->string("the name of an entry of bodies");
    const BodyGroup& group = entry_named(*of, name, scene, Entries::bodies, "the name of an entry of bodies");
    if (group.is_static) of->fail(name + ", which the scene moves or holds", "bodies that are dynamic");
    bodies.first = group.first, bodies.end = group.first + group.count;
  }
  if (const Value* material = entry.find("material")) bodies.material = static_cast<int>(material->choice(scene.materials));
  return bodies;
}

const Keys& probe_keys() {
  static const Keys table =
      Keys{"probe",
           "What report.csv measures beside its usual columns.",
           {keys::text("name", "a name", needed, "name of its columns")}}
          .with(probed_keys())
          .with({"",
                 "",
                 {keys::map("flow", flow_keys, "a map with point and normal", "another", "what goes through a plane or a disc"),
                  keys::map("box", corners_keys, "a map with low and high", "another", "what is in a box"),
                  keys::map("force", force_keys, "a map with on", "another", "the force of contacts on the bodies of an entry"),
                  keys::map("stress", corners_keys, "a map with low and high", "another", "the stress of the contacts in a box"),
                  keys::text("cell", "the name of an entry of bodies with triaxial", "another",
                             "size, pressures and solid fraction of a triaxial cell")}});
  return table;
}

void read_probes(const Value& list, Scene& scene) {
  std::vector<std::string> names;
  for (const Value& entry : list.list("probes")) {
    const KeyedMap map(entry, probe_keys());
    Probe probe;
    probe.name = read_column_name(map.need("name"), names, "probe");
    names.push_back(probe.name);
    probe.bodies = read_probed(map, scene);
    read_measurement(map, scene, probe);
    scene.probes.push_back(std::move(probe));
  }
}

}  // namespace unibody
