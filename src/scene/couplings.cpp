#include "scene/couplings.hpp"

#include <string>

#include "core/text.hpp"

namespace unibody {

namespace {

constexpr const char* joint_words = "the name of a hinge or slider";

std::int64_t read_joint_name(const Value& value, const Scene& scene) {
  const std::string name = value.string(joint_words);
  const auto found = scene.joints_named.find(name);
  if (found == scene.joints_named.end()) {
    std::vector<std::string> names;
    for (const auto& [other, joints] : scene.joints_named) names.push_back(other);
    value.fail(value.found() + ", a name that no joint has" + did_you_mean(name, names), joint_words);
  }
  if (found->second.size() > 1)
    value.fail(value.found() + ", the name of " + std::to_string(found->second.size()) + " joints", "a name of one joint");
  const Joint& joint = scene.joints[found->second.front()];
  if (!joint.has_coordinate())
    value.fail(name + ", a joint of type " + std::string(joint_names[static_cast<std::size_t>(joint.kind)]), joint_words);
  return static_cast<std::int64_t>(found->second.front());
}

Coupling read_coupling(const Value& value, const Scene& scene) {
  const KeyedMap entry(value, coupling_keys());
  const Value& joints = entry.need("joints");
  if (joints.kind != Value::Kind::list || joints.entries.size() != 2) joints.fail_expected(entry.key("joints").words);
  Coupling coupling;
  for (std::size_t k = 0; k < 2; ++k) coupling.joints[k] = read_joint_name(joints.entries[k], scene);
  if (coupling.joints[0] == coupling.joints[1]) joints.fail("the same joint twice", "two joints");
  coupling.ratio = entry.number("ratio");
  if (coupling.ratio == 0) entry.need("ratio").fail_expected("a number other than 0");
  return with_bodies(coupling, scene.joints);
}

}  // namespace

const Keys& coupling_keys() {
  static const Keys table{"coupling",
                          "Two joints whose coordinates go with each other, as by gears, a rack, a screw or a belt.",
                          {keys::list("joints", "", "a list of 2 names of hinges or sliders", needed,
                                      "the joints: the angle or offset of the first goes with that of the second",
                                      [] { return keys::of_type("string"); }),
                           keys::number("ratio", "rad/rad, m/rad, rad/m or m/m", any_number, needed,
                                        "how far the first joint goes for each unit of the second; negative: the other way")}};
  return table;
}

void read_couplings(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("couplings")) scene.couplings.push_back(read_coupling(entry, scene));
}

}  // namespace unibody
