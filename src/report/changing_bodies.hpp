// What output tells of scenes whose bodies come and go: further columns of report.csv, and what the frames need to know.
#pragma once

#include <mpi.h>

#include <vector>

#include "core/json.hpp"
#include "report/output.hpp"
#include "report/report.hpp"
#include "scene/scene.hpp"
#include "step/history.hpp"

namespace unibody {

// Returns what the frames of a scene whose bodies come and go need to know of it; nothing where all bodies are always there. The
// scene must outlive it.
std::optional<ChangingBodies> changing_bodies(const Scene& scene);

// Tells which events, inlets and outlets a scene has, in lines for a run's start.
std::vector<std::string> told_changes(const Scene& scene);
// Tells what has become of them, in lines for the run's end.
std::string told(const Past& past, const Scene& scene);
Json json_of(const Past& past, const Scene& scene);

// Returns these columns; a scene whose bodies are always there has none. Collective.
std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past);

}  // namespace unibody
