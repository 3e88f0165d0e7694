// What output tells of scenes whose bodies come and go: further columns of report.csv, and what the frames need to know.
#pragma once

#include <mpi.h>

#include <vector>

#include "report/output.hpp"
#include "report/report.hpp"
#include "scene/scene.hpp"
#include "step/history.hpp"

namespace unibody {

// Of a scene whose bodies come and go, for its frames. The scene must outlive it.
std::optional<ChangingBodies> changing_bodies(const Scene& scene);

// None of a scene whose bodies are always there. Collective.
std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past);

}  // namespace unibody
