// checkpoint.h5: all that the next step depends on, in order of id, written so that a crash leaves the previous one whole.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>
#include <vector>

#include "checkpoint/checkpoint_outline.hpp"
#include "core/hdf5.hpp"
#include "step/history.hpp"
#include "world/world.hpp"

namespace unibody {

// What a scene is, for a restart to be refused with another: text and overrides, as one string. 16 hex digits.
std::string fingerprint(const std::string& scene_text);

// Writes path + ".part", forces it to the disk, and renames it to `path`: the same bytes on any number of ranks. `count` is the
// number of all bodies. outline: of the scene; without one no other scene can go on from the file. Collective; throws RunError on
// every rank if the disk fails, and the old file is then untouched.
void write_checkpoint(MPI_Comm comm, const std::string& path, const std::string& fingerprint, std::int64_t frame, double time,
                      Id count, const Elements& elements, const History& history, const SceneOutline* outline = nullptr);

// Reads a checkpoint, on any number of ranks. All members throw InputError when the file is damaged.
class Checkpoint {
 public:
  // Throws InputError on every rank if the file is missing, of another scene (its fingerprint does not begin with this one), or
  // not as it was written: all of it is compared with its seal (checkpoint_seal.hpp) before anything in it is believed.
  // Collective.
  Checkpoint(MPI_Comm comm, const std::string& path, const std::string& fingerprint);

  std::int64_t frame() const { return frame_; }
  double time() const { return time_; }     // s
  Id body_count() const { return count_; }  // the number of all bodies, static and absent ones included

  bool has_all_bodies() const { return !has_ids_; }

  // Those of bodies [first, last) that are there, each number of them within its range: a kind of shape that there is, a shape
  // that the library has, an orientation of length 1, a mass > 0 ... Not collective: each rank reads what it needs.
  // With of_same_scene false the file may be of another scene than the one that has been read. The shape library then holds the
  // other scene's hulls and meshes, and the numbers of shapes are not compared with it.
  std::vector<Body> read_bodies(Id first, Id last, bool of_same_scene = true) const;

  // Not collective.
  SceneOutline outline() const;

  // The multipliers of all pairs with a home body of `world` (only its home and static ids are looked at), in order of key. Each
  // rank reads a share of the file and sends it on: none holds them all. Collective.
  Multipliers read_multipliers(const World& world) const;

  // Reads the histories of all other batches, for the constraints and joints that are here; they stay empty where the file has
  // none. Not collective.
  void read_histories(const Elements& elements, History& history) const;

 private:
  MPI_Comm comm_;
  std::string path_;
  h5::Handle file_;
  std::int64_t frame_ = 0;
  double time_ = 0;
  Id count_ = 0, present_ = 0;
  bool has_ids_ = false;  // it is of a scene some of whose bodies are absent
  std::vector<Id> ids_;   // of those that are there
};

}  // namespace unibody
