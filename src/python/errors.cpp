#include "python/errors.hpp"

#include <regex>
#include <string>

#include "core/errors.hpp"

namespace unibody {

namespace {

namespace py = pybind11;

py::handle input_error, run_error;  // for the life of the process

void raise(const py::handle& type, const std::string& what) {
  const py::object error = type(what);
  std::smatch place;
  const bool in_file = std::regex_search(what, place, std::regex("^([^\n]+?):([0-9]+):"));
  py::object file = py::none(), line = py::none();
  if (in_file) file = py::str(place[1].str()), line = py::int_(std::stoll(place[2].str()));
  error.attr("file") = file, error.attr("line") = line;
  PyErr_SetObject(type.ptr(), error.ptr());
}

py::handle new_type(py::module_& module, const char* name, PyObject* base, const char* text) {
  const std::string full = std::string("unibody.") + name;
  const py::handle type = PyErr_NewExceptionWithDoc(full.c_str(), text, base, nullptr);
  module.attr(name) = type;
  return type;
}

}  // namespace

void add_errors(py::module_& module) {
  input_error = new_type(module, "InputError", PyExc_ValueError,
                         "A scene, file or argument is wrong, and nothing has changed. file, line: of the scene, or None.");
  run_error =
      new_type(module, "RunError", PyExc_RuntimeError,
               "A step led to a state that cannot be, or a disk failed. The simulation cannot go on from there: restore() "
               "an earlier state. file, line: None.");
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const InputError& error) {
      raise(input_error, error.what());
    } catch (const RunError& error) {
      raise(run_error, error.what());
    }
  });
}

}  // namespace unibody
