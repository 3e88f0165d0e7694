#include "scene/probes.hpp"

#include <algorithm>
#include <cctype>

#include "scene/body_entry.hpp"

namespace unibody {

namespace {

// Its columns' names are words of a CSV file.
std::string read_name(const Value& value, const Scene& scene) {
  const std::string name = value.string("a name");
  const auto is_good = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; };
  if (name.empty() || !std::ranges::all_of(name, is_good)) value.fail_expected("a name of letters, digits, - and _");
  if (std::ranges::any_of(scene.probes, [&](const Probe& probe) { return probe.name == name; }))
    value.fail(name + " a second time", "a name of its own for each probe");
  return name;
}

// Nodes of flexible bodies have ids behind those of bodies.
Id end_of_bodies(const Scene& scene) {
  Id end = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) end = std::min(end, group.first);
  return end;
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

void read_flow(const Value& flow, const Scene& scene, Probe& probe) {
  flow.map({"point", "normal", "radius"});
  probe.kind = Probe::Kind::flow;
  probe.point = read_vector(flow.need("point", "a point of the plane (m)"), scene, "m");
  probe.normal = flow.need("normal", "a vector of length 1").unit_vector();
  if (const Value* radius = flow.find("radius")) probe.radius = radius->number(positive, "m");
}

void read_box_probe(const Value& box, Probe& probe) {
  box.map({"low", "high"});
  probe.kind = Probe::Kind::box;
  probe.low = box.need("low", "a corner (m)").vector(any_number, "m");
  const Value& high = box.need("high", "the other corner (m)");
  probe.high = high.vector(any_number, "m");
  if (!(probe.low.array() < probe.high.array()).all())
    high.fail_expected("a corner that is above the other one along each axis (m)");
}

}  // namespace

std::vector<std::string> probe_keys() { return {"name", "of", "material", "flow", "box"}; }

void read_probes(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("probes")) {
    entry.map(probe_keys());
    Probe probe;
    probe.name = read_name(entry.need("name", "a name"), scene);
    probe.bodies = read_probed(entry, scene);
    const Value *flow = entry.find("flow"), *box = entry.find("box");
    if (flow && box) box->fail("a box beside a flow", "only one of them");
    if (!flow && !box) entry.fail_missing("flow", "a map with point and normal, or box: one with low and high");
    if (flow)
      read_flow(*flow, scene, probe);
    else
      read_box_probe(*box, probe);
    scene.probes.push_back(std::move(probe));
  }
}

}  // namespace unibody
