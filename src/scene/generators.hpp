// Generators: one entry of `bodies` that stands for many. Each body is a pure function of its number.
#pragma once

#include "scene/body_entry.hpp"

namespace unibody {

// Bodies in the frame of the entry, whose `position` and `orientation` then place them all. The template is held by value.
struct Generated {
  Id count = 0;
  std::function<Body(Id k)> make;
  std::vector<Joint> joints = {};  // between its bodies by their numbers here, and the world, all in the entry's frame
  // The same, of the joints by their numbers in `joints`; the bodies of couplings are those of their joints.
  std::vector<std::string> joint_names = {};  // empty: they have none
  std::vector<Coupling> couplings = {};
  std::vector<std::string> names = {};                       // of bodies; empty: they have numbers alone
  std::vector<std::pair<std::string, Id>> other_names = {};  // of these bodies, by which they are found as well
  std::vector<Id> untouched = {};                            // bodies that touch nothing, ascending
  std::vector<std::string> notes = {};                       // what a person should know of what was read
  std::shared_ptr<const Inlet> inlet = nullptr;        // by which its bodies come in, in the entry's frame; null: they are there
  std::shared_ptr<const TriaxialCell> cell = nullptr;  // whose plates its bodies are, in the entry's frame; null: they are none
};

// What an entry takes of the template: all of it; all but the shape; neither, of static parts, or of bodies that move.
enum class Takes { shape, no_shape, nothing, material };

struct GeneratorType {
  Key key;
  Takes takes;
  Generated (*read)(const Value& value, const BodyTemplate& body, const Scene& scene);
};

// Of generators in files of their own.
Generated read_inlet(const Value& value, const BodyTemplate& body, const Scene& scene);
const Keys& inlet_keys();

// Keys that several generators have.
namespace keys {
Key count(const char* what, Id most = 1'000'000'000'000);
Key columns(const Without& without);
Key seed(const char* about);
}  // namespace keys

// The list of all generators: a new one is one function and one line there.
const std::vector<GeneratorType>& generator_types();

}  // namespace unibody
