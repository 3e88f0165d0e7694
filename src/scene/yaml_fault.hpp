// What is wrong with a text that is no YAML, in words that help.
#pragma once

#include <string>

namespace unibody {

// The parser's message about the text's line of that number (from 1), and, where the line itself shows the cause, that: a tab, a
// wrong indentation, a second ':', a bracket that is not closed.
std::string yaml_fault(const std::string& text, int line, const std::string& message);

}  // namespace unibody
