// A scene as Python's dict -> the YAML text that the scene reader reads.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace unibody {

// Maps, lists, tuples, numpy arrays and numbers, booleans and strings. Numbers keep all of their digits. Throws InputError for
// anything else, with its place in the scene.
std::string scene_text(const pybind11::dict& scene);

// The same of one value, which `place` names in errors.
std::string value_text(const pybind11::handle& value, const std::string& place);

}  // namespace unibody
