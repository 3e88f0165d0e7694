// Text for messages.
#pragma once

#include <string>
#include <vector>

namespace unibody {

// The message on one line, with '?' for line breaks and other control characters.
std::string one_line(std::string message);

// A number with so many digits, trailing zeros left out: 0.25, 1e-06.
std::string number_text(double x, int digits = 6);
// With three digits and an exponent: 2.50e-01.
std::string exponent_text(double x);

// "a, b or c".
std::string one_of(const std::vector<std::string>& names);

// " (did you mean NAME?)" for the name that is next to what was written, at most a third of its letters left out, added, replaced
// or exchanged with their neighbours; empty where none is that near.
std::string did_you_mean(const std::string& written, const std::vector<std::string>& names);

}  // namespace unibody
