#include "app/options.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/stop_request.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"

namespace unibody {

namespace {

// The PETSc options that make sense for this program begin with one of these; anything else is a typing error.
constexpr std::string_view petsc_prefixes[] = {"-log_",     "-options_",          "-malloc",       "-memory_", "-vec_",
                                               "-sf_",      "-on_error",          "-fp_trap",      "-info",    "-no_signal",
                                               "-debugger", "-start_in_debugger", "-check_pointer"};

std::uint64_t seed_of(const std::string& value) {
  const std::string_view prefix = "random:";
  std::uint64_t seed = 0;
  if (value.starts_with(prefix)) {
    const char *begin = value.data() + prefix.size(), *end = value.data() + value.size();
    if (begin != end && std::from_chars(begin, end, seed).ptr == end) return seed;
  }
  throw InputError("option -partition: found '" + value + "', expected metis or random:SEED with a whole number");
}

bool on_off(const std::string& option, const std::string& value) {
  if (value == "on") return true;
  if (value == "off") return false;
  throw InputError("option " + option + ": found '" + value + "', expected on or off");
}

int count_of(const std::string& option, const std::string& value) {
  int count = 0;
  const char* end = value.data() + value.size();
  const auto [last, error] = std::from_chars(value.data(), end, count);
  if (error == std::errc() && last == end && count >= 1) return count;
  throw InputError("option " + option + ": found '" + value + "', expected a whole number, 1 or more");
}

// Whether the word behind one of PETSc's options is its value: nobody but PETSc knows which of them take one. Once the scene is
// known any word is; before, one that names a file or ends in .yaml is the scene.
bool is_petsc_value(const std::string& word, bool scene_is_known) {
  std::error_code error;
  if (word.starts_with("-")) return false;
  return scene_is_known || (!word.ends_with(".yaml") && !std::filesystem::exists(word, error));
}

// The options of the help text, at the starts of its lines.
std::vector<std::string> option_names() {
  std::vector<std::string> names;
  std::istringstream text(help_text());
  for (std::string line; std::getline(text, line);)
    if (line.starts_with("  -")) names.push_back(line.substr(2, line.find(' ', 2) - 2));
  return names;
}

// A word of the command line with one dash, where it has two as other programs' long options have.
std::string option_of(const std::string& word) { return word.starts_with("--") && word.size() > 2 ? word.substr(1) : word; }

}  // namespace

Options parse_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = option_of(argv[i]);
    const auto value = [&]() -> std::string {
      if (i + 1 >= argc) throw InputError("option " + word + ": a value is missing");
      return argv[++i];
    };
    if (word == "-help" || word == "-h") {
      options.help = true;
    } else if (word == "-version") {
      options.version = true;
    } else if (word == "-schema") {
      options.schema = true;
    } else if (word == "-settings") {
      options.settings = true;
    } else if (word == "-output" || word == "-o") {
      options.output = value();
    } else if (word == "-overwrite") {
      options.overwrite = true;
    } else if (word == "-restart" || word == "-start_from") {
      if (!options.restart.empty()) throw InputError("option " + word + ": a checkpoint is given already");
      options.restart = value(), options.other_settings = word == "-start_from";
      options.restart_where_possible = word == "-restart" && options.restart == "auto";
    } else if (word == "-continue_from") {
      options.continue_from = value();
    } else if (word == "-check") {
      options.check = true;
    } else if (word == "-wall_limit") {
      options.wall_limit = wall_time_of(word, value());
    } else if (word == "-strict") {
      options.strict = true;
    } else if (word == "-set") {
      const std::string assignment = value();
      const auto equals = assignment.find('=');
      if (equals == std::string::npos || equals == 0)
        throw InputError("option -set: found '" + assignment + "', expected path.to.key=value");
      options.overrides.push_back({assignment.substr(0, equals), assignment.substr(equals + 1)});
    } else if (word == "-solver_level") {
      options.overrides.push_back({"solver.level", value()});
    } else if (word == "-partition") {
      if (const std::string kind = value(); kind != "metis") options.random_partition = seed_of(kind);
    } else if (word == "-rebalance") {
      options.rebalance = on_off(word, value());
    } else if (word == "-shared_memory") {
      options.shared_memory = on_off(word, value());
    } else if (word == "-error_estimate") {
      const bool told = i + 1 < argc && std::isdigit(static_cast<unsigned char>(argv[i + 1][0])) != 0 &&
                        !std::string_view(argv[i + 1]).ends_with(".yaml");
      options.error_estimate = told ? count_of(word, value()) : 10;
    } else if (word == "-dump_fclib") {
      options.dump_fclib = value();
    } else if (word == "-dump_step") {
      options.dump_step = count_of(word, value());
    } else if (std::any_of(std::begin(petsc_prefixes), std::end(petsc_prefixes), [&](auto p) { return word.starts_with(p); })) {
      options.petsc.push_back(word);
      if (word == "-options_file") {
        options.petsc.push_back(value());
        if (!std::ifstream(options.petsc.back()))
          throw InputError("option -options_file: cannot read '" + options.petsc.back() + "'");
      } else if (i + 1 < argc && is_petsc_value(argv[i + 1], !options.scene.empty())) {
        options.petsc.push_back(argv[++i]);
      }
    } else if (word.starts_with("-")) {
      throw InputError("unknown option " + word + did_you_mean(word, option_names()) + " (-help lists them all)");
    } else if (options.scene.empty()) {
      options.scene = word;
    } else {
      throw InputError("two scenes are given: '" + options.scene + "' and '" + word + "'");
    }
  }
  const bool tells = options.help || options.version || options.schema || options.settings;
  if (options.scene.empty() && !tells) throw InputError("no scene is given: unibody SCENE [options], -help explains");
  if (!options.continue_from.empty() && !options.restart.empty() && !options.restart_where_possible)
    throw InputError("option -continue_from: a checkpoint is given already");
  if (options.dump_step >= 0 && options.dump_fclib.empty())
    throw InputError("option -dump_step: expected -dump_fclib FILE with it");
  return options;
}

Options resolved(MPI_Comm comm, Options options) {
  const std::string own = options.output + "/checkpoint.h5";
  std::error_code error;
  int found[2] = {std::filesystem::exists(own, error) ? 1 : 0, 0};
  found[1] = found[0] != 0 && std::filesystem::equivalent(own, options.restart, error) ? 1 : 0;
  check_mpi(MPI_Bcast(found, 2, MPI_INT, 0, comm));
  if (options.restart_where_possible) {
    options.appends = found[0] != 0;
    options.restart = options.appends ? own : "";
  } else {
    options.appends = found[1] != 0 && !options.overwrite && !options.other_settings;
  }
  return options;
}

std::string help_text() {
  return R"(usage: mpirun -n RANKS unibody SCENE [options]

Simulates the scene file SCENE and writes its results into a folder.

  -output DIR            folder for the results (default: results). Written there: report.csv (one row a frame), frames.h5 and
                         frames.xdmf (states, for ParaView), checkpoint.h5, summary.json
  -o DIR                 the same as -output
  -overwrite             replace results that are in DIR already; without it they stop the run
  -set path.to.key=value change a value of the scene, as if the file said so; may be given many times.
                         Examples: -set time.frames=40, -set solver.name=gauss_seidel, -set gravity=[0,0,-1.62]
  -solver_level LEVEL    position (default), or velocity: the classic time stepping, for comparison; as -set solver.level=LEVEL
  -restart FILE          go on from a checkpoint, on any number of ranks: the result is the one of the run that never stopped. Where
                         FILE is DIR's own checkpoint.h5, and without -overwrite, the run goes on in the files that are in DIR: what
                         they hold of later frames than the checkpoint's is computed anew
  -restart auto          go on from DIR's checkpoint.h5, in the files that are in DIR, and start anew where there is none
  -start_from FILE       the same, but time.frame, time.substeps and what stands under solver may differ from those of the checkpoint's
                         run: to compare settings from the same state
  -partition KIND        metis (default): cells of space, weighted by their bodies' work; random:SEED: bodies thrown about the ranks.
                         No result depends on it
  -rebalance on|off      move bodies between ranks as the work shifts (default on). No result depends on it
  -shared_memory on|off  ranks of one node tell each other through memory that they share what an iteration needs (default
                         on), which is faster than MPI's messages. No result depends on it
  -error_estimate [N]    how wrong the run is: in every N-th frame (default: 10th) and in the last one the last step is solved on
                         from where its iterations ended, until it converges, and then taken back. Three columns of report.csv
                         tell its distance to the converged step, and how well that one is known; summary.json and the run's last
                         lines the worst and the last of them. The reference: more of the run's own iterations,
                         or accelerated Jacobi with trees of joints solved directly, whichever ends with less natural residual;
                         with cloths, threads or solids in the incremental form, which converge to what their way leads to, the
                         former alone. The run itself stays the same, bit for bit; a sample takes as long as some 60 to 1000
                         steps, and its time is none of the steps'
  -continue_from FILE    start the scene, at time 0, with the bodies of another scene's checkpoint: body k of an entry from body k of
                         the entry of the same name. Those keep place, orientation and velocities; all else is as SCENE says. What
                         differs is told. With -restart auto: where DIR has no checkpoint yet
  -check                 read the scene, find its contacts, tell what the run would do and what in it is probably a mistake, and end:
                         nothing is written
  -wall_limit TIME       stop with a checkpoint before so much time has passed since the start: 3h55m, 90m, 45s or seconds. The signals
                         TERM, INT and USR1 do the same at once, after the frame that is being computed
  -strict                a warning at the start is an error (exit code 2); stop at the first step that has not converged, with the
                         constraint named that is farthest from solved, and at the first frame in which tetrahedra are inside out or
                         edges go through faces (exit code 3, as for every run that had to stop)
  -dump_fclib FILE       write one frame's last step as a frictional contact problem in FCLIB's HDF5 form, with its solution;
                         rigid bodies alone, in space
  -dump_step N           of that frame (default: the last)
  -version               version and commit of the program, its compiler, and the versions of PETSc, MPI, HDF5 and METIS
  -settings              the keys of a scene file, with units, defaults, what they may be and what they say
  -schema                the scene file as a JSON schema, by which editors complete and check it
  -help                  this text

PETSc options that begin with -log_, -options_, -malloc, -memory_, -vec_, -info or -on_error are passed on to PETSc,
with the value that follows. Best behind SCENE: before it, a word that names a file or ends in .yaml is taken as the scene.
  -log_view              time, messages and memory by phase (unibody_collide, unibody_solve, unibody_halo, ...)
  -options_file FILE     more PETSc options from a file

The last line printed is 'state HASH': equal hashes mean equal final states, bit for bit.
Exit codes: 0 done; 2 bad scene, option or file: nothing was written; 3 the run had to stop: the last checkpoint is kept; 4 the run
stopped as asked, by a signal or -wall_limit: it goes on with -restart from its checkpoint.
)";
}

}  // namespace unibody
