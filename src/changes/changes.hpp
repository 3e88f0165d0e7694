// What changes a scene between its frames: events that happen, bodies that leave by outlets and that come in by inlets.
//
// All of it takes place at the start of a frame and is decided from what all ranks know, by pure functions of the frame, of ids
// and of exact sums, so that the same happens on any number of ranks and through a restart. What has happened is kept in
// History::past.
#pragma once

#include <cstdint>

#include "step/simulation.hpp"

namespace unibody {

// Makes room in the history for what will happen in a scene that starts.
void start_past(const Scene& scene, History& history);

// Gives motors and coefficients of friction what the events of the past have given them, after a restart. `scene` is the one that
// steps see.
void repeat_past(Scene& scene, const History& history);

enum class Changed : std::uint8_t {
  nothing,
  little,  // bodies may be best off on the ranks on which they are
  much,    // many bodies are new on any rank
};

// Carries out the events, outlets and inlets that are due at the start of a frame. Frames are numbered from 1. `scene` is the one
// that the simulation refers to. The function is collective.
Changed change_scene(Simulation& simulation, Scene& scene, std::int64_t frame);

}  // namespace unibody
