// The program's errors as Python's exceptions.
#pragma once

#include <pybind11/pybind11.h>

namespace unibody {

// InputError (a ValueError) and RunError (a RuntimeError), each with the attributes file (str) and line (int), which are None
// where the error is not about a place in a file.
void add_errors(pybind11::module_& module);

}  // namespace unibody
