// Pins of cloths and threads: which node is held, by what, and until when.
#include <algorithm>

#include "scene/cloth.hpp"

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

void read_pin(const Value& value, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number) {
  value.map({"node", "near", "to", "release"});
  const Value *node = value.find("node"), *near = value.find("near"), *to = value.find("to"), *release = value.find("release");
  if (node && near) near->fail(near->found() + " beside node " + node->found(), "only one of node and near");
  if (!node && !near) value.fail_missing("node", "a node, or near: a point (m)");
  Pin pin;
  pin.id = node ? first + number(*node) : nearest_node(scene, first, count, read_vector(*near, scene, "m"));
  if (release) pin.release = release->number(not_negative, "s");
  const Value& named = node ? *node : *near;
  if (is_pinned(scene, pin.id)) named.fail(named.found() + ", a node pinned before", "each node pinned once");
  bool tied = false;
  if (to) {
    const Body body = read_target(*to, scene);
    tied = body.properties.is_dynamic();
    pin.body = body.id;
    pin.place =
        body.state.orientation.conjugate() * (scene.groups.back().make(pin.id - first).state.position - body.state.position);
  }
  if (tied)
    scene.attachments.insert(std::ranges::upper_bound(scene.attachments, pin.id, {}, &Attachment::node),
                             {pin.id, pin.body, pin.place, pin.release});
  else
    scene.pins.insert(std::ranges::upper_bound(scene.pins, pin.id, {}, &Pin::id), pin);
}

}  // namespace

void read_pins(const Value& entry, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number) {
  const Value* list = entry.find("pins");
  if (!list) return;
  for (const Value& value : list->list("pins")) read_pin(value, scene, first, count, number);
}

}  // namespace unibody
