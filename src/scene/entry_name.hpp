// The entries of bodies, cloths, threads and solids that names in a scene stand for.
#pragma once

#include <span>
#include <string>

#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace unibody {

enum class Entries { bodies, all };  // among which a name is looked for: of the section `bodies`, or of all sections

std::span<const BodyGroup> entries_of(const Scene& scene, Entries among);

// The one entry of this name. Where none or several have it the error is at `value`, which says the name, and says `expected`.
const BodyGroup& entry_named(const Value& value, const std::string& name, const Scene& scene, Entries among,
                             const std::string& expected);

// The error of a name that no entry has.
[[noreturn]] void fail_without_entry(const Value& value, const std::string& name, const Scene& scene, Entries among,
                                     const std::string& expected);

}  // namespace unibody
