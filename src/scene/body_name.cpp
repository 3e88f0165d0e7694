#include "scene/body_name.hpp"

#include <charconv>

#include "core/text.hpp"
#include "scene/entry_name.hpp"

namespace unibody {

namespace {

// The entry of `bodies` of this name, or whose place in the list it is. Entries of cloths and threads stand behind them.
const BodyGroup& named_entry(const Value& to, const std::string& name, const Scene& scene, const std::string& expected) {
  const std::span<const BodyGroup> entries = entries_of(scene, Entries::bodies);
  const bool number =
      to.kind == Value::Kind::scalar && !to.quoted && !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
  if (entries.empty()) to.fail(to.found() + " in a scene without bodies", expected);
  if (number && name == to.text) return entries[static_cast<std::size_t>(to.integer(0, std::ssize(entries) - 1))];
  if (number) {
    std::size_t place = entries.size();
    std::from_chars(name.data(), name.data() + name.size(), place);
    if (place >= entries.size()) to.fail_expected(expected);
    return entries[place];
  }
  if (to.kind != Value::Kind::scalar || name.empty()) to.fail_expected(expected);
  return entry_named(to, name, scene, Entries::bodies, expected);
}

}  // namespace

Body read_body_name(const Value& to, const Scene& scene, const std::string& expected) {
  std::string name = to.text;
  Id number = 0;
  const auto bracket = name.find('[');
  const bool counted = bracket != std::string::npos && name.back() == ']';
  const auto slash = name.find('/');
  std::string part;  // as a link of a robot
  if (slash != std::string::npos) part = name.substr(slash + 1), name.resize(slash);
  if (counted) {
    const char *first = name.data() + bracket + 1, *last = name.data() + name.size() - 1;
    const auto result = std::from_chars(first, last, number);
    if (result.ec != std::errc() || result.ptr != last) to.fail_expected(expected);
    name.resize(bracket);
  }
  const BodyGroup& group = named_entry(to, name, scene, expected);
  if (!part.empty()) {
    const std::optional<Id> found = group.number_of(part);
    if (!found) to.fail(to.found() + ", a name that no part of " + name + " has" + did_you_mean(part, group.names), expected);
    number = *found;
  } else if (!counted && group.count > 1)
    to.fail(to.found() + ", an entry of " + std::to_string(group.count) + " bodies", "one of them, as " + name + "[0]");
  if (number < 0 || number >= group.count)
    to.fail(to.found() + " of " + std::to_string(group.count), "a number below " + std::to_string(group.count));
  Body body = group.make(number);
  body.id = group.first + number;
  if (body.properties.shape.kind == ShapeKind::plane) to.fail(to.found() + ", a plane", "a body that is no plane");
  return body;
}

}  // namespace unibody
