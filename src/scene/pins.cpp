// Pins of cloths and threads: which node is held, by what, and until when.
#include <algorithm>
#include <limits>
#include <sstream>

#include "scene/body_name.hpp"
#include "scene/flexible.hpp"

namespace unibody {

namespace {

// The longest edge (m) of the faces at a node; infinite at a node inside a solid, which has none.
double longest_edge(const Scene& scene, Id node) {
  std::vector<std::array<Id, 3>> cells;
  scene.surfaces.back().cells_of(node, cells);
  if (cells.empty()) return std::numeric_limits<double>::infinity();
  const auto place = [&](Id id) -> Vec3 { return scene.groups.back().make(id - scene.groups.back().first).state.position; };
  double longest = 0;
  for (const auto& cell : cells)
    for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, (place(cell[k]) - place(cell[(k + 1) % 3])).norm());
  return longest;
}

// The node nearest to a point (world axes) at the start; of several, the first. A point off all of them by more than an edge is
// a mistake.
Id nearest_node(const Value& value, const Scene& scene, Id first, Id count) {
  const Vec3 point = read_vector(value, scene, "m");
  Id nearest = first;
  double least = std::numeric_limits<double>::infinity();
  for (Id id = first; id < first + count; ++id) {
    const double distance = (scene.groups.back().make(id - first).state.position - point).norm();
    if (distance < least) least = distance, nearest = id;
  }
  const double edge = longest_edge(scene, nearest);
  if (least > edge) {
    std::ostringstream found, expected;
    found << value.found() << ", " << least << " m from the nearest node";
    expected << "a point (m, world axes) within an edge's length of one, " << edge << " m";
    value.fail(found.str(), expected.str());
  }
  return nearest;
}

const std::string bodies_expected = "a body, as mast or pile[3], or its entry's place in the list";

const Keys& pin_keys() {
  static const Keys table{
      "pin",
      "A node, or several, that are held.",
      {keys::other("node", "", "a node", "another", "the node, as its entry numbers nodes", [] { return Json::object(); }),
       keys::vector("near", "m", "another", "the node nearest to this point, world axes, at the start"),
       within_key("another", "all nodes in this box, world axes, at the start"),
       keys::other("to", "", bodies_expected.c_str(), "nothing", "the body that holds the node where it is at the start",
                   [] { return Json::object(); }),
       keys::number("release", "s", not_negative, "never", "when it is let go")}};
  return table;
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
    tied = !body->properties.is_static();
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
  const KeyedMap map(value, pin_keys());
  map.only_one_of({"node", "near", "within"});
  const Value *node = map.find("node"), *near = map.find("near"), *within = map.find("within"), *to = map.find("to");
  const Value* named = node ? node : near ? near : within;
  if (!named) value.fail_missing("node", "a node, or near: a point (m), or within: a box (m)");
  std::vector<Id> ids;
  if (within)
    ids = nodes_within(*within, scene, first, count);
  else
    ids = {node ? first + number(*node) : nearest_node(*near, scene, first, count)};
  for (const Id id : ids)
    if (is_pinned(scene, id)) named->fail(named->found() + ", a node pinned before", "each node pinned once");
  Pin pin;
  pin.release = map.number_if("release").value_or(pin.release);
  const Body body = to ? read_body_name(*to, scene, bodies_expected) : Body{};
  for (const Id id : ids) {
    pin.id = id;
    add_pin(pin, to ? &body : nullptr, scene, first);
  }
}

}  // namespace

Key pins_key(const char* node) {
  const std::string about = "nodes that are held where they are, or by a body; a node is named as " + std::string(node);
  return keys::list_of_maps("pins", pin_keys, "pins", "none", about.c_str());
}

void read_pins(const KeyedMap& entry, Scene& scene, Id first, Id count, const std::function<Id(const Value&)>& number) {
  if (!entry.has("pins")) return;
  for (const Value& value : entry.list("pins")) read_pin(value, scene, first, count, number);
}

}  // namespace unibody
