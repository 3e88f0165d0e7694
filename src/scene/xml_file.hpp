// An XML file, and what is read of its elements: each fault names the file and the line.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace unibody {

class XmlFile {
 public:
  // `what` names the kind of file in messages, as "a robot (URDF)". Throws InputError where the file is not there, or is no XML.
  XmlFile(const std::string& path, const std::string& what);

  const std::string& path() const { return path_; }
  const pugi::xml_document& document() const { return document_; }
  std::int64_t line_of(const pugi::xml_node& node) const;
  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& found, const std::string& expected) const;

  // Attributes of an element: its text, which must be there, and numbers, which must be finite.
  std::string text(const pugi::xml_node& node, const char* name) const;
  std::vector<double> numbers(const pugi::xml_node& node, const char* name, std::size_t least, std::size_t most) const;
  double number(const pugi::xml_node& node, const char* name) const { return numbers(node, name, 1, 1)[0]; }
  double number(const pugi::xml_node& node, const char* name, double without) const;
  double positive(const pugi::xml_node& node, const char* name) const;
  double not_negative(const pugi::xml_node& node, const char* name) const;  // 0 where it is not there
  Vec3 vector(const pugi::xml_node& node, const char* name) const;
  // A child element that must be there.
  pugi::xml_node child(const pugi::xml_node& node, const char* name) const;

 private:
  std::int64_t line_at(std::size_t offset) const;

  const std::string path_, bytes_;
  pugi::xml_document document_;
};

}  // namespace unibody
