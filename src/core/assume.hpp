// What the program takes for granted, checked in builds for debugging alone (without NDEBUG).
#pragma once

#include <stdexcept>
#include <string>

namespace unibody {

#ifdef NDEBUG
inline constexpr bool checks_assumptions = false;
#else
inline constexpr bool checks_assumptions = true;
#endif

// fault(): says what is wrong, and nothing where all is as it should be. A fault of the program ends it with a std::logic_error.
template <class Fault>
void assume(Fault&& fault) {
  if constexpr (checks_assumptions)
    if (const std::string text = fault(); !text.empty()) throw std::logic_error("fault of the program: " + text);
}

}  // namespace unibody
