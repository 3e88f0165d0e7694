#include "scene/mjcf_elements.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

using pugi::xml_node;

namespace {

constexpr const char* what = "a model (MJCF)";

}  // namespace

MjcfElements::MjcfElements(const std::string& path) : folder_(std::filesystem::path(path).parent_path().string()) {
  const XmlFile& file = files_.emplace_back(path, what);
  const xml_node first = file.document().first_child();
  if (std::string_view(first.name()) != "mujoco") file.fail(first, "<" + std::string(first.name()) + ">", "<mujoco>");
  classes_["main"];
}

xml_node MjcfElements::root_of_included(const xml_node& include) {
  const std::string name = file_of(include).text(include, "file"), path = (std::filesystem::path(folder_) / name).string();
  if (const auto found = included_.find(include.hash_value()); found != included_.end()) return found->second;
  if (std::ranges::find(files_, path, &XmlFile::path) != files_.end())
    fail(include, quote(name) + ", a file that is read before", "each file once");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    fail(include, quote(name) + ", which isn't at " + path, "a file that is there");
  return included_[include.hash_value()] = files_.emplace_back(path, what).document().first_child();
}

std::vector<xml_node> MjcfElements::sections(const std::string& name) {
  std::vector<xml_node> found;
  const auto gather = [&](const xml_node& node) {
    if (node.name() == name) found.push_back(node);
  };
  for_each_child(root(), gather);
  return found;
}

const XmlFile& MjcfElements::file_of(const xml_node& node) const {
  const xml_node root = node.root();
  return *std::ranges::find_if(files_, [&](const XmlFile& file) { return file.document() == root; });
}

void MjcfElements::read_class(const xml_node& node, const std::string& above) {
  std::string name = node.attribute("class").value();
  if (above.empty() && name == "main") name = "";
  if (!above.empty() && name.empty()) fail(node, "<default> without class in another", "its class");
  Class& own = classes_[name.empty() ? "main" : name];
  own.above = above.empty() && !name.empty() ? "main" : above;
  for_each_child(node, [&](const xml_node& child) {
    if (std::string_view(child.name()) == "default")
      read_class(child, name.empty() ? "main" : name);
    else
      classes_[name.empty() ? "main" : name].elements.push_back(child);
  });
}

void MjcfElements::read_defaults() {
  for (const xml_node& node : sections("default")) read_class(node, "");
}

std::vector<xml_node> MjcfElements::with_defaults(const xml_node& element, const std::string& child_class) const {
  std::vector<xml_node> all{element};
  std::string name = element.attribute("class").value();
  if (name.empty()) name = child_class.empty() ? "main" : child_class;
  if (!classes_.contains(name)) fail(element, "class " + quote(name) + ", which no <default> has", "the class of a <default>");
  for (; !name.empty(); name = classes_.at(name).above)
    for (const xml_node& node : classes_.at(name).elements)
      if (std::string_view(node.name()) == element.name()) all.push_back(node);
  return all;
}

MjcfElement::MjcfElement(MjcfElements& elements, const xml_node& node, const std::string& child_class,
                         const std::vector<std::string_view>& used)
    : elements_(&elements), from_(elements.with_defaults(node, child_class)) {
  std::vector<std::string> counted;
  for (const xml_node& each : from_)
    for (const pugi::xml_attribute attribute : each.attributes()) {
      const std::string name = attribute.name();
      if (name == "class" || name == "name" || std::ranges::find(used, name) != used.end()) continue;
      if (std::ranges::find(counted, name) != counted.end()) continue;
      counted.push_back(name), ++elements.unused[std::string(node.name()) + " " + name];
    }
}

xml_node MjcfElement::holder(const char* name) const {
  const auto found = std::ranges::find_if(from_, [&](const xml_node& node) { return static_cast<bool>(node.attribute(name)); });
  return found == from_.end() ? xml_node() : *found;
}

std::string MjcfElement::text(const char* name, const std::string& without) const {
  const xml_node from = holder(name);
  return from ? from.attribute(name).value() : without;
}

bool MjcfElement::flag(const char* name, bool without) const {
  const std::string said = text(name, "auto");
  if (said != "true" && said != "false" && said != "auto") fail(name, "true, false or auto");
  return said == "auto" ? without : said == "true";
}

std::vector<double> MjcfElement::numbers(const char* name, std::size_t least, std::size_t most) const {
  const xml_node from = holder(name);
  const xml_node& at = from ? from : node();
  return elements_->file_of(at).numbers(at, name, least, most);
}

double MjcfElement::number(const char* name, double without) const { return has(name) ? numbers(name, 1, 1)[0] : without; }

Vec3 MjcfElement::vector(const char* name, const Vec3& without) const {
  if (!has(name)) return without;
  const std::vector<double> v = numbers(name, 3, 3);
  return {v[0], v[1], v[2]};
}

void MjcfElement::fail(const char* name, const std::string& expected) const {
  const xml_node from = holder(name);
  elements_->fail(from ? from : node(), std::string(name) + " " + quote(text(name, "")), expected);
}

MjcfCompiler read_compiler(MjcfElements& elements) {
  MjcfCompiler compiler;
  for (const xml_node& node : elements.sections("compiler")) {
    const MjcfElement of(elements, node, "",
                         {"angle", "autolimits", "eulerseq", "meshdir", "assetdir", "texturedir", "inertiafromgeom", "coordinate",
                          "fusestatic", "discardvisual", "convexhull", "usethread"});
    if (of.text("coordinate", "local") != "local") of.fail("coordinate", "local");
    const std::string angle = of.text("angle", "degree");
    if (angle != "degree" && angle != "radian") of.fail("angle", "degree or radian");
    if (of.has("angle")) compiler.angle = angle == "degree" ? M_PI / 180 : 1;
    compiler.auto_limits = of.flag("autolimits", compiler.auto_limits);
    compiler.euler = of.text("eulerseq", compiler.euler);
    if (compiler.euler.size() != 3 || compiler.euler.find_first_not_of("xyzXYZ") != std::string::npos)
      of.fail("eulerseq", "three of x, y, z, X, Y and Z");
    compiler.mesh_folder = of.text("meshdir", of.text("assetdir", compiler.mesh_folder));
    compiler.shapes_give_mass = of.flag("inertiafromgeom", compiler.shapes_give_mass);
  }
  return compiler;
}

Pose MjcfCompiler::pose(const MjcfElement& element) const { return {element.vector("pos", Vec3::Zero()), turn(element)}; }

Quat MjcfCompiler::turn(const MjcfElement& element) const {
  const auto unit = [&](const char* name, const Vec3& v) -> Vec3 {
    if (!(v.norm() > 0)) element.fail(name, "a vector that is not 0");
    return v.normalized();
  };
  if (element.has("quat")) {
    const std::vector<double> q = element.numbers("quat", 4, 4);
    const Quat turn(q[0], q[1], q[2], q[3]);
    if (!(turn.norm() > 0)) element.fail("quat", "a quaternion that is not 0");
    return turn.normalized();
  }
  if (element.has("axisangle")) {
    const std::vector<double> v = element.numbers("axisangle", 4, 4);
    return Quat(Eigen::AngleAxisd(angle * v[3], unit("axisangle", {v[0], v[1], v[2]})));
  }
  if (element.has("xyaxes")) {
    const std::vector<double> v = element.numbers("xyaxes", 6, 6);
    Mat3 axes;
    axes.col(0) = unit("xyaxes", {v[0], v[1], v[2]});
    const Vec3 y(v[3], v[4], v[5]);
    axes.col(1) = unit("xyaxes", y - axes.col(0) * axes.col(0).dot(y));
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return Quat(axes);
  }
  if (element.has("zaxis")) return Quat::FromTwoVectors(Vec3::UnitZ(), unit("zaxis", element.vector("zaxis", Vec3::UnitZ())));
  Quat turn = Quat::Identity();
  const Vec3 angles = element.vector("euler", Vec3::Zero());
  for (int k = 0; k < 3; ++k) {  // small letters are axes that turn along
    const char letter = euler[static_cast<std::size_t>(k)];
    const bool is_fixed = letter < 'a';
    const Quat one(Eigen::AngleAxisd(angle * angles[k], Vec3::Unit(letter - (is_fixed ? 'X' : 'x'))));
    turn = is_fixed ? one * turn : turn * one;
  }
  return turn;
}

}  // namespace unibody
