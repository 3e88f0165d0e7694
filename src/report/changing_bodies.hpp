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

// Of a scene whose bodies come and go, for its frames. The scene must outlive it.
std::optional<ChangingBodies> changing_bodies(const Scene& scene);

// Which events, inlets and outlets a scene has, in lines for a run's start; none of a scene without.
std::vector<std::string> told_changes(const Scene& scene);
// What has become of them, in lines for its end.
std::string told(const Past& past, const Scene& scene);
Json json_of(const Past& past, const Scene& scene);

// None of a scene whose bodies are always there. Collective.
std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past);

}  // namespace unibody
