// The elements of an MJCF file: with what it includes, and with the attributes that its default classes give them.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "scene/robot_model.hpp"
#include "scene/xml_file.hpp"

namespace unibody {

class MjcfElements {
 public:
  explicit MjcfElements(const std::string& path);

  // Calls f(child) with each child element; of an <include> with those of the root of its file.
  template <class F>
  void for_each_child(const pugi::xml_node& parent, F&& f) {
    for (const pugi::xml_node child : parent.children()) {
      if (child.type() != pugi::node_element) continue;
      if (std::string_view(child.name()) == "include")
        for_each_child(root_of_included(child), f);
      else
        f(child);
    }
  }
  pugi::xml_node root() const { return files_.front().document().first_child(); }
  // The children of this name of the root: its sections.
  std::vector<pugi::xml_node> sections(const std::string& name);

  // The elements that settle what `element` does not say itself: that of its name in its class, then those of the classes above.
  // `child_class`: the class where it names none.
  void read_defaults();
  std::vector<pugi::xml_node> with_defaults(const pugi::xml_node& element, const std::string& child_class) const;

  const XmlFile& file_of(const pugi::xml_node& node) const;
  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& found, const std::string& expected) const {
    file_of(node).fail(node, found, expected);
  }

  // What of the file is left out, counted by name.
  std::map<std::string, int> unused;

 private:
  struct Class {
    std::string above;  // the class in which it stands; empty: none
    std::vector<pugi::xml_node> elements;
  };
  pugi::xml_node root_of_included(const pugi::xml_node& include);
  void read_class(const pugi::xml_node& node, const std::string& above);

  std::string folder_;  // of the first file; included ones are named from there
  std::deque<XmlFile> files_;
  std::map<std::size_t, pugi::xml_node> included_;  // by each <include>
  std::map<std::string, Class> classes_;            // that without a name is for all elements
};

// An element with its attributes, wherever they stand.
class MjcfElement {
 public:
  // used: the attributes that are read or make no difference to motion. Others, of the element itself, are counted as left out.
  MjcfElement(MjcfElements& elements, const pugi::xml_node& node, const std::string& child_class,
              const std::vector<std::string_view>& used);

  const pugi::xml_node& node() const { return from_.front(); }
  bool has(const char* name) const { return static_cast<bool>(holder(name)); }
  std::string text(const char* name, const std::string& without) const;
  bool flag(const char* name, bool without) const;  // "auto" is `without`
  std::vector<double> numbers(const char* name, std::size_t least, std::size_t most) const;
  double number(const char* name, double without) const;
  Vec3 vector(const char* name, const Vec3& without) const;
  [[noreturn]] void fail(const char* name, const std::string& expected) const;

 private:
  pugi::xml_node holder(const char* name) const;  // none where no element has it

  const MjcfElements* elements_;
  std::vector<pugi::xml_node> from_;
};

// What <compiler> says of all other elements.
struct MjcfCompiler {
  double angle = M_PI / 180;  // rad
  bool auto_limits = true;
  std::string euler = "xyz", mesh_folder;
  bool shapes_give_mass = false;  // also where there is an <inertial>

  // `pos`, and the turn by whichever attribute says it.
  Pose pose(const MjcfElement& element) const;
  Quat turn(const MjcfElement& element) const;
};
MjcfCompiler read_compiler(MjcfElements& elements);

}  // namespace unibody
