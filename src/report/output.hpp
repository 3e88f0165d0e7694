// frames.h5 and frames.xdmf: the states of all bodies in order of id, the same bytes on any number of ranks.
//
//   /bodies/{id, shape, size, mass, inertia, motion, material}   row k is body k; what does not change (mass 0: not dynamic)
//   /surfaces/000000/cells   bodies at the corners of each triangle of a cloth (or segment of a thread); attribute name; only
//                            where the scene has cloths, threads or solids, in their order
//   /surfaces/000000/elasticity   Young's modulus (Pa) and Poisson's ratio of each cell, of a solid of each of its tetrahedra
//   /frames/000000/{position, orientation, velocity, angular_velocity}   attributes time (s) and frame
//
// Where bodies come and go a frame has a row for each body that is there, and beside these: id, of each row, ascending; row, its
// number; size and shape; and of nodes of cloths, threads and solids alone node_position and node_velocity, to which node_cells
// and node_tetrahedra of /surfaces refer.
//
// Both files are whole after each frame: a run that is killed between two frames leaves all that it wrote.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/hdf5.hpp"
#include "partition/by_id.hpp"
#include "report/frame_group.hpp"
#include "report/xdmf_file.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

// Makes the directory. If it holds results (frames, report, summary or checkpoint), throws an InputError that names the first
// one found, or, with `overwrite`, removes them all but `keep` (the checkpoint that the run restarts from). Run it before
// anything is written. With `appends` all of them stay, for the run to go on with. Collective; throws on every rank.
void prepare_output_directory(MPI_Comm comm, const std::string& directory, bool overwrite, const std::string& keep = "",
                              bool appends = false);

// What the frames of a scene whose bodies come and go need to know of it.
struct ChangingBodies {
  std::function<Body(Id id)> body_of;  // there or not
  Id first_node = 0;                   // nodes are always there, and have the last ids; without any: the number of bodies
};

class Output {
 public:
  // Creates both files and writes /bodies and /surfaces. `count` is the number of all bodies of the scene. kept_to: where the
  // files are there, their frames up to this one stay; -1: none does. Throws InputError, and leaves the files as they are, where
  // they are of other bodies or another precision. Collective, as are all members but holds().
  Output(MPI_Comm comm, const std::string& directory, const OutputSettings& settings, Id count, const World& world,
         std::vector<Surface> surfaces = {}, std::int64_t kept_to = -1, std::optional<ChangingBodies> changing = {});
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  // Throws RunError on every rank if the disk fails on any.
  void write(std::int64_t frame, double time, const World& world);
  void close();                                                          // the same; nothing may follow
  bool holds(std::int64_t frame) const { return frames_.holds(frame); }  // since before this run

 private:
  void create(const World& world);
  void extend(std::int64_t kept_to);
  void reserve(Id numbers) const;
  void write_bodies(const World& world);
  void write_surfaces();
  void write_shapes();
  bool write_present(hid_t group, const RowsById<std::array<double, 13>>& present);
  bool append_xdmf(std::int64_t frame, double time, Id rows);
  Id nodes() const;
  void throw_if_any(const std::string& fault) const;

  MPI_Comm comm_;
  std::string path_, xdmf_path_;
  bool single_;
  Id count_;
  std::vector<Surface> surfaces_;
  std::optional<ChangingBodies> changing_;  // none: all bodies are always there
  int rank_ = 0;
  h5::Handle file_;
  FrameGroup frames_;
  XdmfFile xdmf_;  // of rank 0
};

}  // namespace unibody
