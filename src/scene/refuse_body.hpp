// The error of a body that a scene cannot have.
#pragma once

#include "core/errors.hpp"
#include "scene/scene.hpp"

namespace unibody {

// Throws InputError "file:line: body N (its name): found F, expected E". k: the body's number in its group.
[[noreturn]] inline void refuse_body(const Scene& scene, const BodyGroup& group, Id k, const std::string& found,
                                     const std::string& expected) {
  const std::string where = group.line > 0 ? scene.path + ":" + std::to_string(group.line) : scene.path;
  const Id id = group.first + k;
  throw InputError(where + ": body " + std::to_string(id) + " (" + scene.body_name(id) + "): found " + found + ", expected " +
                   expected);
}

}  // namespace unibody
