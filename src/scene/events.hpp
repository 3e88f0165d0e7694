// The section `events`.
#pragma once

#include <string>
#include <vector>

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

// Reads the list `events` into scene.events. All that events may be about is read before.
void read_events(const Value& list, Scene& scene);

const Keys& event_keys();

// Refuses a scene with bodies that wait for an event that never comes.
void check_starts(const Value& root, const Scene& scene);

// What happens, in the words of a sentence: "remove gate", "end the run".
std::string text_of(const Event& event, const Scene& scene);

}  // namespace unibody
