// A simulation whose scene changes between frames, as a run has it.
#pragma once

#include "changes/changes.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds {

class Changing : public Experiment {
 public:
  explicit Changing(const std::string& text, MPI_Comm comm = MPI_COMM_SELF) : Experiment(scene_from_text(text), comm) {
    start_past(*scene, simulation->history);
  }
  void frames(int n) {
    for (int i = 0; i < n; ++i) {
      change_scene(*simulation, *scene, ++frame);
      steps(scene->time.substeps);
    }
  }
  // What happens at the start of the next frame, which is then not taken.
  void change() { change_scene(*simulation, *scene, ++frame); }
  bool is_there(Id id) const { return simulation->world.find(id) >= 0; }
  const Past& past() const { return simulation->history.past; }

  std::int64_t frame = 0;  // the last that was started
};

}  // namespace unibody::small_worlds
