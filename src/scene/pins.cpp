// Pins of cloths and threads: which node is held, by what, and until when.
#include <algorithm>

#include "scene/flexible.hpp"

namespace unibody {

namespace {

// The node nearest to a point (world axes) at the start; of several, the first.
Id nearest_node(const Scene& scene, Id first, Id count, const Vec3& point) {
  Id nearest = first;
  double least = std::numeric_limits<double>::infinity();
  for (Id id = first; id < first + count; ++id) {
    const double distance = (scene.groups.back().make(id - first).state.position - point).squaredNorm();
    if (distance < least) least = distance, nearest = id;
  }
  return nearest;
}

// The entry of `bodies` that `to` names, or whose place in the list it is. Entries of cloths and threads stand behind them.
const BodyGroup& named_entry(const Value& to, const Scene& scene, const std::string& expected) {
  const auto begin = scene.groups.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(scene.groups.size() - scene.constraint_groups.size());
  const bool number = to.kind == Value::Kind::scalar && !to.quoted && !to.text.empty() &&
                      to.text.find_first_not_of("0123456789") == std::string::npos;
  if (begin == end) to.fail(to.found() + " in a scene without bodies", expected);
  if (number) return begin[to.integer(0, end - begin - 1)];
  if (to.kind != Value::Kind::scalar || to.text.empty()) to.fail_expected(expected);
  const auto is_named = [&](const BodyGroup& group) { return group.name == to.text; };
  const auto count = std::count_if(begin, end, is_named);
  if (count == 0) to.fail(to.found() + ", a name that no entry of bodies has", expected);
  if (count > 1) to.fail(to.found() + ", the name of " + std::to_string(count) + " entries", expected);
  return *std::find_if(begin, end, is_named);
}

// The single body that `to` says.
Body read_target(const Value& to, const Scene& scene) {
  const std::string expected = "the name of an entry of bodies that is one body, or its place in the list";
  const BodyGroup& group = named_entry(to, scene, expected);
  if (group.generated) to.fail(to.found() + ", an entry with a generator", expected);
  Body body = group.make(0);
  body.id = group.first;
  if (body.properties.shape.kind == ShapeKind::plane) to.fail(to.found() + ", a plane", "a body that is no plane");
  return body;
}

bool is_pinned(const Scene& scene, Id node) {
  return std::ranges::binary_search(scene.pins, node, {}, &Pin::id) ||
         std::ranges::binary_search(scene.attachments, node, {}, &Attachment::node);
}

std::vector<Id> nodes_within(const Value& value, const Scene& scene, Id first, Id count) {
  const Part part = read_part(value, scene);
  std::vector<Id> found;
  for (Id id = first; id < first + count; ++id)
    if (part.holds(scene.groups.back().make(id - first).state.position)) found.push_back(id);
  if (found.empty()) value.fail("a part without a node", "a box (m, world axes) with some in it");
  return found;
}

// Holds a node, or ties it to a dynamic body.
void add_pin(Pin pin, const Body* body, Scene& scene, Id first) {
  bool tied = false;
  if (body) {
    tied = body->properties.is_dynamic();
    pin.body = body->id;
    pin.place =
        body->state.orientation.conjugate() * (scene.groups.back().make(pin.id - first).state.position - body->state.position);
  }
  if (tied)
    scene.attachments.insert(std::ranges::upper_bound(scene.attachments, pin.id, {}, &Attachment::node),
                             {pin.id, pin.body, pin.place, pin.release});
  else
    scene.pins.insert(std::ranges::upper_bound(scene.pins, pin.id, {}, &Pin::id), pin);
}

void read_pin(const Value& value, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number) {
  value.map({"node", "near", "within", "to", "release"});
  const Value *node = value.find("node"), *near = value.find("near"), *within = value.find("within");
  const Value *to = value.find("to"), *release = value.find("release");
  const Value* named = node ? node : near ? near : within;
  for (const Value* other : {near, within})
    if (other && other != named)
      other->fail(other->found() + " beside " + (node ? "node " : "near ") + named->found(), "only one of node, near and within");
  if (!named) value.fail_missing("node", "a node, or near: a point (m), or within: a box (m)");
  std::vector<Id> ids;
  if (within)
    ids = nodes_within(*within, scene, first, count);
  else
    ids = {node ? first + number(*node) : nearest_node(scene, first, count, read_vector(*near, scene, "m"))};
  for (const Id id : ids)
    if (is_pinned(scene, id)) named->fail(named->found() + ", a node pinned before", "each node pinned once");
  Pin pin;
  if (release) pin.release = release->number(not_negative, "s");
  const Body body = to ? read_target(*to, scene) : Body{};
  for (const Id id : ids) {
    pin.id = id;
    add_pin(pin, to ? &body : nullptr, scene, first);
  }
}

}  // namespace

void read_pins(const Value& entry, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number) {
  const Value* list = entry.find("pins");
  if (!list) return;
  for (const Value& value : list->list("pins")) read_pin(value, scene, first, count, number);
}

}  // namespace unibody
