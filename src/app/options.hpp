// The command line: what the program reads itself, and what it passes on to PETSc.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace unibody {

struct Options {
  std::string scene;
  std::string output = "results";
  bool overwrite = false;
  bool help = false, version = false, schema = false, settings = false;  // told instead of a run
  std::string restart;                                                   // checkpoint to go on from; empty: start anew
  std::string continue_from;                      // another scene's checkpoint, whose bodies go on; empty: start anew
  bool restart_where_possible = false;            // -restart auto: from the output folder's checkpoint, where there is one
  bool appends = false;                           // to the results in the output folder, whose checkpoint the run goes on from
  bool other_settings = false;                    // than those of the checkpoint's run may be set: -start_from
  std::vector<Override> overrides;                // -set
  std::optional<std::uint64_t> random_partition;  // seed; none: METIS
  bool rebalance = true;
  bool shared_memory = true;       // between the ranks of a node
  int error_estimate = 0;          // the error of every so many frames; 0: of none
  bool check = false;              // tell what the run would do, and end
  double wall_limit = 0;           // s, before which the run stops with a checkpoint; 0: none
  bool strict = false;             // a frame that has not converged stops the run
  std::string dump_fclib;          // where a frame's contact problem goes; empty: nowhere
  int dump_step = -1;              // the frame; -1: the last
  std::vector<std::string> petsc;  // the rest
};

// Throws InputError for an option that neither the program nor PETSc knows, or that lacks its value.
Options parse_options(int argc, char** argv);

// Whether the output folder has a checkpoint for -restart auto to go on from, and whether the run goes on in the folder of its
// checkpoint. Collective.
Options resolved(MPI_Comm comm, Options options);

std::string help_text();

}  // namespace unibody
