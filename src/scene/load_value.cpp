// YAML text -> Value, and the values set from the command line.
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "scene/value.hpp"
#include "scene/yaml_fault.hpp"

namespace unibody {

namespace {

using Origin = std::shared_ptr<const std::string>;

constexpr int deepest = 64;                       // levels; an alias that holds itself would go on for ever
constexpr std::size_t most_by_aliases = 200'000;  // values that aliases may add to those that the text writes out
constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30;

std::string child_key(const std::string& parent, const std::string& name) { return parent.empty() ? name : parent + "." + name; }
std::string entry_key(const std::string& parent, std::size_t i) { return parent + "[" + std::to_string(i) + "]"; }

// Makes Values of the nodes of one text. An alias stands for a whole tree, and ten aliases of ten aliases of ... for more trees
// than there is memory for: the values are counted.
class Converter {
 public:
  Converter(const Origin& origin, bool in_file, std::size_t bytes)
      : origin_(origin), in_file_(in_file), most_(bytes + most_by_aliases) {}

  Value convert(const YAML::Node& node, const std::string& key, int depth = 0);

 private:
  void convert_map(const YAML::Node& node, Value& value, int depth);

  const Origin& origin_;
  bool in_file_;
  std::size_t most_, count_ = 0;  // a text has no more values than bytes, but for its aliases
};

void Converter::convert_map(const YAML::Node& node, Value& value, int depth) {
  std::set<std::string_view> names;
  for (const auto& item : node) {
    if (!item.first.IsScalar()) convert(item.first, value.key, depth + 1).fail_expected("a word before the ':'");
    const std::string& name = item.first.Scalar();
    Value child = convert(item.second, child_key(value.key, name), depth + 1);
    if (in_file_) child.line = item.first.Mark().line + 1;
    if (!names.insert(name).second) child.fail("the key a second time", "each key once");
    value.children.emplace_back(name, std::move(child));
  }
}

Value Converter::convert(const YAML::Node& node, const std::string& key, int depth) {
  Value value;
  value.key = key;
  value.origin = origin_;
  value.line = in_file_ ? std::max(node.Mark().line, 0) + 1 : 0;
  if (depth > deepest) value.fail("more than " + std::to_string(deepest) + " levels", "fewer");
  if (++count_ > most_)
    value.fail("aliases that stand for more than " + std::to_string(most_by_aliases) + " values", "fewer, or no aliases");
  if (node.IsScalar()) {
    value.kind = Value::Kind::scalar;
    value.text = node.Scalar();
    value.quoted = node.Tag() == "!";
  } else if (node.IsSequence()) {
    value.kind = Value::Kind::list;
    for (const auto& entry : node) value.entries.push_back(convert(entry, entry_key(key, value.entries.size()), depth + 1));
  } else if (node.IsMap()) {
    value.kind = Value::Kind::map;
    convert_map(node, value, depth);
  }
  return value;
}

// Notes the line on which a document starts. (YAML::LoadAll never returns from a text that begins with a comma.)
struct DocumentStart : YAML::EventHandler {
  int line = 0;
  void OnDocumentStart(const YAML::Mark& mark) override { line = mark.line + 1; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

Value parse_yaml(const std::string& text, const std::string& key, const Origin& origin, bool in_file) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DocumentStart start;
    if (parser.HandleNextDocument(start) && parser.HandleNextDocument(start)) {
      const std::string line = in_file ? ":" + std::to_string(start.line) : "";
      throw InputError(*origin + line + ": found text after the scene's end, expected one YAML document");
    }
    return Converter(origin, in_file, text.size()).convert(YAML::Load(text), key);
  } catch (const YAML::Exception& error) {
    const std::string line = in_file && error.mark.line >= 0 ? ":" + std::to_string(error.mark.line + 1) : "";
    const std::string fault = in_file ? yaml_fault(text, error.mark.line + 1, error.msg) : error.msg;
    throw InputError(one_line(*origin + line + ": not YAML: " + fault));
  }
}

std::string read_text(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  for (char part[1 << 16]; file.read(part, sizeof part), file.gcount() > 0;) {  // a folder can be opened, but not read
    text.append(part, static_cast<std::size_t>(file.gcount()));
    if (text.size() > most_bytes)
      throw InputError(path + ": found more than " + std::to_string(most_bytes) + " bytes, expected a scene (YAML)");
  }
  if (!file.is_open() || file.bad())
    throw InputError(path + ": found no readable file (" + std::strerror(errno != 0 ? errno : EIO) +
                     "), expected a scene (YAML)");
  return text;
}

struct Step {  // one step of a path: a key, or a place in a list where the name is empty
  std::string name;
  std::size_t index = 0;
};

[[noreturn]] void malformed(const Override& change) {
  throw InputError("-set " + change.path + "=" + change.value + ": found the path '" + change.path +
                   "', expected keys and places such as time.frames or bodies[0].mass");
}

std::vector<Step> parse_path(const Override& change) {
  std::vector<Step> steps;
  std::size_t at = 0;
  const std::string& path = change.path;
  while (at < path.size()) {
    if (path[at] == '[') {
      Step step;
      const char* end = path.data() + path.size();
      const auto result = std::from_chars(path.data() + at + 1, end, step.index);
      if (steps.empty() || result.ec != std::errc() || result.ptr == end || *result.ptr != ']') malformed(change);
      at = static_cast<std::size_t>(result.ptr - path.data()) + 1;
      steps.push_back(step);
    } else {
      if (!steps.empty() && path[at++] != '.') malformed(change);
      const auto end = std::min(path.find_first_of(".[", at), path.size());
      if (end == at) malformed(change);
      steps.push_back({path.substr(at, end - at), 0});
      at = end;
    }
  }
  if (steps.empty()) malformed(change);
  return steps;
}

Value& descend(Value& value, const Step& step, const Origin& origin) {
  const auto fail = [&](const std::string& expected) {
    Value fault = value;
    fault.origin = origin;
    fault.line = 0;
    fault.fail_expected(expected);
  };
  if (step.name.empty()) {
    if (value.kind != Value::Kind::list || step.index >= value.entries.size())
      fail("a list of at least " + std::to_string(step.index + 1));
    return value.entries[step.index];
  }
  if (value.kind == Value::Kind::nothing) {
    value.kind = Value::Kind::map;
    value.origin = origin;
    value.line = 0;
  }
  if (value.kind != Value::Kind::map) fail("a map, to set '" + step.name + "' in it");
  for (auto& [name, child] : value.children)
    if (name == step.name) return child;
  Value absent;
  absent.key = child_key(value.key, step.name);
  absent.origin = origin;
  return value.children.emplace_back(step.name, std::move(absent)).second;
}

void apply(const Override& change, Value& root) {
  const Origin origin = std::make_shared<const std::string>("-set " + change.path + "=" + change.value);
  Value* value = &root;
  for (const Step& step : parse_path(change)) value = &descend(*value, step, origin);
  *value = parse_yaml(change.value, value->key, origin, false);
}

}  // namespace

namespace {

Value root_of(const std::string& text, const std::string& path, const std::vector<Override>& overrides, bool in_file) {
  Value root = parse_yaml(text, "", std::make_shared<const std::string>(path), in_file);
  if (root.kind == Value::Kind::scalar || root.kind == Value::Kind::list)
    root.fail_expected("a map of sections (title, time, bodies, ...)");
  if (root.kind == Value::Kind::nothing) root.fail_expected("a map of sections (title, time, bodies, ...)");
  for (const Override& change : overrides) apply(change, root);
  return root;
}

}  // namespace

Value load_value(const std::string& path, const std::vector<Override>& overrides) {
  return root_of(read_text(path), path, overrides, true);
}

Value value_of_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides) {
  return root_of(text, path, overrides, false);
}

}  // namespace unibody
