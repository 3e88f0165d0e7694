#include "scene/events.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "scene/entry_name.hpp"
#include "scene/in_time.hpp"
#include "scene/setting.hpp"

namespace unibody {

namespace {

using Action = Event::Action;

const Keys& when_keys() {
  static const Keys table{
      "when",
      "A time, or a column of report.csv that passes a value.",
      {keys::number("time", "s", not_negative, "a column",
                    "it happens at the start of the first frame that begins then or later"),
       keys::text("column", "the name of a column of report.csv, as kinetic_energy", "a time",
                  "the column, with or without its unit"),
       keys::number("below", "", any_number, "above", "it happens once, after the first frame in which the column is less"),
       keys::number("above", "", any_number, "below", "it happens once, after the first frame in which the column is greater"),
       keys::number("after", "s", not_negative, 0, "frames up to this time do not count")}};
  return table;
}

ColumnCondition read_condition(const KeyedMap& when) {
  ColumnCondition condition;
  const Value& column = when.need("column");
  condition.column = column.string(when.key("column").words);
  condition.place = *column.origin + (column.line > 0 ? ":" + std::to_string(column.line) : "") + ": key '" + column.key + "'";
  const Value *below = when.find("below"), *above = when.find("above");
  when.only_one_of({"below", "above"});
  if (!below && !above) when.value().fail_missing("below", "a number, or above: one");
  condition.above = above != nullptr;
  condition.value = (above ? above : below)->number(any_number, "in the unit of the column");
  condition.after = when.number("after");
  return condition;
}

void read_when(const Value& value, Event& event) {
  if (value.kind != Value::Kind::map) value.fail_expected(event_keys().at("when").words);
  const KeyedMap when(value, when_keys());
  if (!when.has("time")) {
    event.when = read_condition(when);
    return;
  }
  for (const char* key : {"column", "below", "above", "after"})
    if (const Value* other = when.find(key)) other->fail(std::string(key) + " beside time", "a time, or a column");
  event.time = when.number("time");
}

// Whether a joint holds a body of the group, or a node is held by one or tied to one.
const char* tie_of(const Scene& scene, const BodyGroup& group) {
  const auto holds = [&](Id id) { return id >= group.first && id < group.first + group.count; };
  if (std::ranges::any_of(scene.joints, [&](const Joint& j) { return holds(j.ids[0]) || holds(j.ids[1]); })) return "a joint";
  if (std::ranges::any_of(scene.pins, [&](const Pin& p) { return holds(p.body); })) return "a node pinned to them";
  if (std::ranges::any_of(scene.attachments, [&](const Attachment& a) { return holds(a.body); })) return "a node tied to them";
  return nullptr;
}

void check_bodies(const Value& value, const BodyGroup& group, const Scene& scene, Action action) {
  const std::string name = group.name;
  if (group.inlet) value.fail(name + ", whose bodies come in by an inlet", "bodies that are there by another way");
  if (action == Action::fix || action == Action::release) {
    if (group.is_static)
      value.fail(name + ", which the scene moves or holds", "bodies that are dynamic (start: held holds them)");
    return;
  }
  if (const char* tie = tie_of(scene, group)) value.fail(name + ", with " + tie, "bodies without joints and nodes tied to them");
}

std::size_t read_group(const Value& value, const Scene& scene, Action action) {
  const std::string expected = "the name of an entry of bodies";
  const BodyGroup& group = entry_named(value, value.string(expected), scene, Entries::bodies, expected);
  check_bodies(value, group, scene, action);
  return static_cast<std::size_t>(&group - scene.groups.data());
}

// A name, or a list of names.
template <class Read>
void for_each_name(const Value& value, Read&& read) {
  if (value.kind != Value::Kind::list) return read(value);
  for (const Value& name : value.list("names")) read(name);
}

// The joints that the event is about, each of which check(value, joint) may refuse.
template <class Check>
void read_joint_names(const KeyedMap& entry, const Scene& scene, Event& event, Check&& check) {
  for_each_name(entry.need("joints"), [&](const Value& value) {
    const std::string name = value.string("the name of a joint");
    const auto named = scene.joints_named.find(name);
    if (named == scene.joints_named.end()) {
      std::vector<std::string> names;
      for (const auto& [other, joints] : scene.joints_named) names.push_back(other);
      value.fail(value.found() + ", a name that no joint has" + did_you_mean(name, names), "the name of a joint");
    }
    for (const std::size_t joint : named->second) check(value, scene.joints[joint]), event.joints.push_back(joint);
  });
}

void read_motors(const KeyedMap& entry, const Scene& scene, Event& event) {
  read_joint_names(entry, scene, event, [](const Value& value, const Joint& joint) {
    if (joint.motor == Motor::none) value.fail(value.text + ", a joint without a motor", "a joint with a motor");
  });
  const Joint& first = scene.joints[event.joints.front()];
  const auto is_alike = [&](std::size_t joint) {
    return scene.joints[joint].motor == first.motor && turns_about_axis(scene.joints[joint].kind) == turns_about_axis(first.kind);
  };
  if (!std::ranges::all_of(event.joints, is_alike))
    entry.find("joints")->fail("joints whose motors differ in kind", "motors that all have a speed, or an angle, or an offset");
  const bool angle = turns_about_axis(first.kind);
  const char* key = first.motor == Motor::speed ? "speed" : angle ? "angle" : "offset";
  const std::string unit = first.motor == Motor::speed ? (angle ? "rad/s" : "m/s") : angle ? "degrees" : "m";
  for (const char* other : {"speed", "angle", "offset"})
    if (const Value* given = entry.find(other); given && std::string(other) != key)
      given->fail(std::string(other) + " of a motor that has " + key, std::string("the key ") + key + " (" + unit + ")");
  const Value& target = entry.value().need(key, "a number, or values in time that count from the event (" + unit + ")");
  event.value = unit == "degrees" ? read_in_time(target, scene, {-180, 180}, unit, M_PI / 180)
                                  : read_in_time(target, scene, any_number, unit);
}

void read_friction(const KeyedMap& entry, Scene& scene, Event& event) {
  const Value& between = entry.need("between");
  if (between.kind != Value::Kind::list || between.entries.size() != 2) between.fail_expected(entry.key("between").words);
  for (std::size_t k = 0; k < 2; ++k) event.materials[k] = static_cast<int>(between.entries[k].choice(scene.materials));
  event.value = read_in_time(entry, "friction", scene);
}

// What each action needs to be told beside `do` and `when`.
struct ActionType {
  const char* name;
  std::vector<std::string> keys;
  void (*read)(const KeyedMap& entry, Scene& scene, Event& event);
};

void read_nothing(const KeyedMap&, Scene&, Event&) {}

void read_groups(const KeyedMap& entry, Scene& scene, Event& event) {
  for_each_name(entry.need("bodies"), [&](const Value& name) { event.groups.push_back(read_group(name, scene, event.action)); });
}

// Reads what an event releases: bodies that are held, joints, or both.
void read_released(const KeyedMap& entry, Scene& scene, Event& event) {
  if (!entry.has("joints") || entry.has("bodies")) read_groups(entry, scene, event);
  if (entry.has("joints")) read_joint_names(entry, scene, event, [](const Value&, const Joint&) {});
}

// In the order of Event::Action.
const std::array<ActionType, 7>& action_types() {
  static const std::array<ActionType, 7> types{
      {{"end", {}, read_nothing},
       {"add", {"bodies"}, read_groups},
       {"remove", {"bodies"}, read_groups},
       {"fix", {"bodies"}, read_groups},
       {"release", {"bodies", "joints"}, read_released},
       {"motor",
        {"joints", "speed", "angle", "offset"},
        [](const KeyedMap& entry, Scene& scene, Event& event) { read_motors(entry, scene, event); }},
       {"friction", {"between", "friction"}, read_friction}}};
  return types;
}

void read_event(const Value& value, Scene& scene) {
  const KeyedMap entry(value, event_keys());
  const std::size_t action = entry.choice("do");
  const ActionType& type = action_types()[action];
  for (const auto& [key, child] : value.children)
    if (key != "do" && key != "when" && std::ranges::find(type.keys, key) == type.keys.end())
      child.fail(key + " beside do: " + type.name, type.keys.empty() ? "no such key" : "the keys " + one_of(type.keys));
  Event event;
  event.action = static_cast<Action>(action);
  read_when(entry.need("when"), event);
  type.read(entry, scene, event);
  scene.events.push_back(std::move(event));
}

}  // namespace

void check_starts(const Value& root, const Scene& scene) {
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const BodyGroup& group = scene.groups[g];
    if (group.start != Start::absent || group.inlet) continue;
    const auto adds = [g](const Event& event) {
      return event.action == Action::add && std::ranges::find(event.groups, g) != event.groups.end();
    };
    if (std::ranges::none_of(scene.events, adds))
      root.fail_missing("events", "one that adds " + (group.name.empty() ? "bodies[" + std::to_string(g) + "]" : group.name) +
                                      ", which is absent at the start");
  }
}

const Keys& event_keys() {
  const auto name_or_names = [] { return keys::any_of({keys::of_type("string"), keys::list_of(keys::of_type("string"))}); };
  std::vector<std::string> actions;
  for (const ActionType& type : action_types()) actions.emplace_back(type.name);
  static const Keys table{
      "event",
      "What happens once, at the start of a frame.",
      {keys::choice("do", actions, needed, "what happens"),
       keys::map("when", when_keys, "a map with time, or with column and below or above", needed, "when it happens"),
       keys::other("bodies", "", "the name of an entry of bodies, or a list of names",
                   "needed by add, remove, fix and, without joints, by release",
                   "the bodies that are added, removed, fixed or released", name_or_names),
       keys::other("joints", "", "the name of a joint, or a list of names", "needed by motor",
                   "the joints whose motors change, or that are released: they do nothing any more", name_or_names),
       keys::number_in_time("speed", "rad/s or m/s", any_number, "as the motor has",
                            "new speed of the motors; times count from the event"),
       keys::number_in_time("angle", "degrees", {-180, 180}, "as the motor has",
                            "new angle of the motors; times count from the event"),
       keys::number_in_time("offset", "m", any_number, "as the motor has",
                            "new offset of the motors; times count from the event"),
       keys::other("between", "", "a list of 2 materials", "needed by friction", "the materials whose friction changes",
                   [] { return keys::list_of(keys::of_type("string"), 2); }),
       keys::number_in_time("friction", "", not_negative, "needed by friction",
                            "their new coefficient of friction; times count from the event")}};
  return table;
}

void read_events(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("events")) read_event(entry, scene);
  const auto changes_friction = [](const Event& event) { return event.action == Action::friction; };
  if (std::ranges::any_of(scene.events, changes_friction) && !scene.friction_in_time)
    scene.friction_in_time = FrictionInTime::of(scene.friction, scene.materials.size());
}

std::string text_of(const Event& event, const Scene& scene) {
  if (event.action == Action::end) return "end the run";
  std::string text = action_types()[static_cast<std::size_t>(event.action)].name;
  for (const std::size_t g : event.groups) text += " " + scene.groups[g].name;
  for (const auto& [name, joints] : scene.joints_named)
    if (!event.joints.empty() && std::ranges::find(event.joints, joints.front()) != event.joints.end()) text += " " + name;
  if (event.action == Action::friction)
    for (const int material : event.materials) text += " " + scene.materials[static_cast<std::size_t>(material)];
  return text;
}

}  // namespace unibody
