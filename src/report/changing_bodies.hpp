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

// Returns what the writer of frames.h5 must know of a scene whose bodies come and go. For any other scene the result is empty.
// The scene must outlive the result.
std::optional<ChangingBodies> changing_bodies(const Scene& scene);

// Returns lines for a run's start that name the scene's events, inlets and outlets.
std::vector<std::string> told_changes(const Scene& scene);
// Returns lines for a run's end that say which events have happened, and how many bodies inlets and outlets have let through.
std::string told(const Past& past, const Scene& scene);
Json json_of(const Past& past, const Scene& scene);

// Returns these columns; a scene whose bodies are always there has none. Collective.
std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past);

}  // namespace unibody
