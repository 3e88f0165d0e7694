// Text for messages.
#pragma once

#include <string>
#include <vector>

namespace unibody {

// With '?' for line breaks and other control characters.
std::string one_line(std::string message);

// "a, b or c".
std::string one_of(const std::vector<std::string>& names);

}  // namespace unibody
