// Feeds the program with damaged input, in one process for thousands of runs (scripts/fuzz starts it): whatever a scene, a mesh,
// a checkpoint or a command line holds, a run ends with a result or with an error of its own kinds, soon, and on all ranks.
//
// usage: unibody_fuzz KIND SEED FIRST COUNT FOLDER SOURCE     KIND: scenes, meshes, checkpoints, sealed, options
// Case FIRST + k depends on KIND, SEED and that number alone: the same input is made again with FIRST set to it and COUNT 1.
// `sealed` are checkpoints whose seal is made anew after the damage, so that what is behind it is read.
#include <petscsys.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/run.hpp"
#include "checkpoint/checkpoint_seal.hpp"
#include "core/before_mpi.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "fuzz/mutation.hpp"

namespace unibody::fuzz {

namespace {

namespace fs = std::filesystem;

constexpr unsigned most_seconds = 60;  // of a case; sanitizers make all ten times slower
constexpr Id most_bodies = 3000;

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void put(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

// What all cases of a kind start from.
struct Seeds {
  std::vector<std::string> names, bytes;
};

struct Fuzzer {
  std::string kind, folder, source;
  std::uint64_t seed = 0;
  int rank = 0;
  Seeds seeds;
  std::int64_t ended[3] = {};  // with a result, refused, stopped

  void load_seeds();
  void make_checkpoints();
  std::vector<std::string> damaged_case(std::int64_t number) const;
  bool is_small(const std::vector<std::string>& words) const;
  void run_case(std::int64_t number);
  int run_words(const std::vector<std::string>& words) const;
};

// The scene of all kinds at once, and smaller ones of a few lines, which most changes hit where it matters.
const std::vector<std::string> small_scenes{
    "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - name: boxes\n    shape: {box: {size: [0.1, 0.2, 0.3]}}\n    "
    "density: 1000\n"
    "    lattice: {count: 20, columns: [2, 2], spacing: [0.3, 0.3, 0.4], height: 0.2, jitter: 0.02}\n    velocity: [1, 0, -2]\n",
    "materials: {a: {friction: 0.4, restitution: 0.5, rolling_friction: 0.001}}\nsolver: {name: gauss_seidel}\nbodies:\n"
    "  - {container: {size: [1, 1]}}\n  - name: pile\n    pile: {count: 20, columns: [3, 3], mix: [{shape: {sphere: {radius: "
    "0.1}}, scale: [0.5, "
    "1]},\n"
    "      {shape: {hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}}}]}\n    density: 2000\n",
    "cloths:\n  - name: cloth\n    grid: {size: [1, 1], nodes: [6, 6]}\n    mass: 1\n    thickness: 0.02\n    links: {stiffness: "
    "1000}\n"
    "    bending: {model: dihedral, stiffness: 0.01}\n    pins: [{node: [0, 0]}, {near: [0.5, 0.5, 0]}]\nthreads:\n"
    "  - {name: thread, points: [[0, 0, 0.2], [1, 0, 0.2]], segments: 8, radius: 0.01, mass: 0.1}\n",
    "solids:\n  - name: solid\n    block: {size: [0.4, 0.2, 0.2], cells: [4, 2, 2]}\n    density: 1000\n    youngs_modulus: "
    "1.0e5\n"
    "    poissons_ratio: 0.3\n    thickness: 0.01\n    least_volume: 0.1\n    pins: [{node: [0, 0, 0]}]\n"
    "    loads: [{within: {min: [0.1, -1, -1], max: [1, 1, 1]}, force: [0, 0, -1]}]\n",
    "bodies:\n  - {name: a, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 1, position: [0.2, 0, 0]}\n"
    "  - {name: b, shape: {compound: {parts: [{shape: {sphere: {radius: 0.1}}}, {shape: {box: {size: [0.1, 0.1, 0.1]}},\n"
    "      position: [0.2, 0, 0]}]}}, mass: 1, position: [0.6, 0, 0]}\njoints:\n"
    "  - {type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 1, 0], limits: [-1, 1], motor: {speed: 1, max_torque: "
    "2}}\n"
    "  - {type: ball, bodies: [a, b], anchor: [0.4, 0, 0], friction: 0.1}\n"};

void Fuzzer::load_seeds() {
  const auto add = [&](const std::string& name, const std::string& bytes) {
    seeds.names.push_back(name), seeds.bytes.push_back(bytes);
  };
  if (kind == "scenes" || kind == "options") {
    for (std::size_t k = 0; k < small_scenes.size(); ++k) add("scene.yaml", small_scenes[k]);
    add("scene.yaml", contents(source + "/tests/program/everything.yaml"));
  } else if (kind == "meshes") {
    for (const auto& entry : fs::directory_iterator(source + "/tests/data")) add(entry.path().filename(), contents(entry.path()));
    std::string obj, stl = "solid s\n";
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) obj += "v " + std::to_string(0.1 * i) + " " + std::to_string(0.1 * j) + " 0\n";
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const int a = 1 + i + 4 * j;
        obj += "f " + std::to_string(a) + "/1/1 " + std::to_string(a + 1) + " " + std::to_string(a + 5) + " " +
               std::to_string(a + 4) + "\n";
        stl += "facet normal 0 0 1\nouter loop\n";
        for (const auto& [x, y] : {std::pair(i, j), std::pair(i + 1, j), std::pair(i + 1, j + 1)})
          stl += "vertex " + std::to_string(0.1 * x) + " " + std::to_string(0.1 * y) + " 0\n";
        stl += "endloop\nendfacet\n";
      }
    add("sheet.obj", obj), add("sheet.stl", stl + "endsolid s\n");
    std::sort(seeds.names.begin(), seeds.names.end());
    seeds.bytes.clear();
    for (const auto& name : seeds.names)
      seeds.bytes.push_back(name == "sheet.obj"   ? obj
                            : name == "sheet.stl" ? stl + "endsolid s\n"
                                                  : contents(source + "/tests/data/" + name));
  } else {
    make_checkpoints();
  }
}

// By runs of the small scenes.
void Fuzzer::make_checkpoints() {
  for (std::size_t k = 0; k < small_scenes.size(); ++k) {
    const std::string scene = folder + "/seed_" + std::to_string(k) + ".yaml", output = folder + "/seed_" + std::to_string(k);
    if (rank == 0) put(scene, small_scenes[k]);
    check_mpi(MPI_Barrier(MPI_COMM_WORLD));
    run_words({scene, "-output", output, "-overwrite", "-set", "time.frames=4"});
    seeds.names.push_back(scene), seeds.bytes.push_back(contents(output + "/checkpoint.h5"));
  }
}

// Writes the files of a case and returns its command line. The same on every rank.
std::vector<std::string> Fuzzer::damaged_case(std::int64_t number) const {
  std::seed_seq sequence{seed, static_cast<std::uint64_t>(number), std::hash<std::string>{}(kind)};
  Random random(sequence);
  const std::size_t which = random() % seeds.names.size();
  const auto write = [&](const std::string& name, const std::string& bytes) {
    if (rank == 0) put(folder + "/" + name, bytes);
    return folder + "/" + name;
  };
  std::vector<std::string> words{"", "-output", folder + "/results", "-overwrite"};
  const auto set = [&](const char* assignment) { words.insert(words.end(), {"-set", assignment}); };
  if (kind == "scenes") {
    words[0] = write("case.yaml", damage_text(seeds.bytes[which], random));
  } else if (kind == "meshes") {
    const std::string& name = seeds.names[which];
    const bool text = name.ends_with(".obj") || name.ends_with(".stl") || name == "gmsh_22.msh" || name == "vtk_ascii.vtu";
    write(name, text ? damage_text(seeds.bytes[which], random) : damage_bytes(seeds.bytes[which], random));
    const bool solid = name.ends_with(".msh") || name.ends_with(".vtu");
    const std::string use = random() % 2 ? "cloths:\n  - {mesh: " + name + ", mass: 1, thickness: 0.01}\n"
                                         : "bodies:\n  - {shape: {mesh: {file: " + name +
                                               "}}}\n"
                                               "  - {shape: {sphere: {radius: 0.05}}, mass: 1, position: [0.1, 0.1, 0.1]}\n";
    words[0] = write("case.yaml", solid ? "solids:\n  - {mesh: " + name +
                                              ", density: 1000, youngs_modulus: 1.0e5, poissons_ratio: 0.3, "
                                              "thickness: 0.01}\n"
                                        : use);
  } else if (kind == "options") {
    words[0] = write("case.yaml", seeds.bytes[which]);
    const std::vector<std::string> known{"-set",
                                         "-output",
                                         "-overwrite",
                                         "-restart",
                                         "-start_from",
                                         "-continue_from",
                                         "-solver_level",
                                         "-partition",
                                         "-rebalance",
                                         "-shared_memory",
                                         "-error_estimate",
                                         "-dump_fclib",
                                         "-dump_step",
                                         "time.frames=1",
                                         "velocity",
                                         "random:3",
                                         "off",
                                         "on",
                                         "1",
                                         "-1",
                                         "bodies[0].mass=2",
                                         "solver.iterations=4",
                                         "gravity=[0, 0",
                                         folder + "/case.yaml",
                                         folder + "/nowhere",
                                         "time.substeps=0",
                                         "solver={name: jacobi}",
                                         "",
                                         "=",
                                         "a.b.c=1",
                                         "bodies[99]=1"};
    for (std::size_t n = random() % 5; n > 0; --n) words.push_back(damage_text(known[random() % known.size()], random));
    words.erase(std::remove_if(words.begin() + 4, words.end(), [](const std::string& w) { return w.find('\0') != w.npos; }),
                words.end());
  } else {
    const std::string path = write("case.h5", damage_bytes(seeds.bytes[which], random, kind == "sealed" ? seal_bytes : 0));
    check_mpi(MPI_Barrier(MPI_COMM_WORLD));
    if (kind == "sealed") try {
        seal_file(MPI_COMM_WORLD, path);
      } catch (const std::runtime_error&) {
      }
    words[0] = seeds.names[which];
    words.insert(words.end(), {random() % 2 != 0 ? "-restart" : "-continue_from", path});
    set("time.frames=6");
    check_mpi(MPI_Barrier(MPI_COMM_WORLD));
    return words;
  }
  set("time.frames=2"), set("solver.iterations=4");
  if (kind != "options") set("time.substeps=1");
  check_mpi(MPI_Barrier(MPI_COMM_WORLD));
  return words;
}

// Cases of millions of bodies are legal, and take too long.
bool Fuzzer::is_small(const std::vector<std::string>& words) const {
  try {
    std::vector<char*> argv{nullptr};
    std::vector<std::string> copy = words;
    for (auto& word : copy) argv.push_back(word.data());
    const Options options = parse_options(static_cast<int>(argv.size()), argv.data());
    const Scene scene = read_scene(options.scene, options.overrides, Room{1e9, 1});
    return scene.body_count() <= most_bodies && scene.time.frames <= 10 && scene.time.substeps <= 10 &&
           scene.solver.iterations <= 100 && options.output.starts_with(folder) && options.petsc.empty() &&
           options.dump_fclib.empty();
  } catch (const InputError&) {
    return true;
  }
}

int Fuzzer::run_words(const std::vector<std::string>& words) const {
  std::vector<std::string> copy = words;
  std::vector<char*> argv{nullptr};
  for (auto& word : copy) argv.push_back(word.data());
  try {
    return run(MPI_COMM_WORLD, parse_options(static_cast<int>(argv.size()), argv.data()));
  } catch (const InputError&) {
    return 2;
  } catch (const RunError&) {
    return 3;
  }
}

std::string described;  // the case that runs, for what ends the process

void Fuzzer::run_case(std::int64_t number) {
  described = "unibody_fuzz: case " + std::to_string(number) + " of " + kind + ", seed " + std::to_string(seed) + "\n";
  alarm(most_seconds);
  const auto words = damaged_case(number);
  int small = is_small(words);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &small, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD));
  if (small) {
    const int code = run_words(words);
    int codes[2] = {code, -code};
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, codes, 2, MPI_INT, MPI_MAX, MPI_COMM_WORLD));
    if (codes[0] != -codes[1]) throw std::runtime_error("ranks end with different codes");
    ++ended[code == 0 ? 0 : code == 2 ? 1 : 2];
  }
  alarm(0);
}

extern "C" void tell_case(int) {
  const ssize_t written = write(STDERR_FILENO, described.data(), described.size());
  _exit(written > 0 ? 70 : 71);
}

// What the sanitizers and aborts end with.
extern "C" void tell_case_and_abort(int signal) {
  std::signal(signal, SIG_DFL);
  if (write(STDERR_FILENO, described.data(), described.size()) < 0) _exit(71);
  raise(signal);
}

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: %s KIND SEED FIRST COUNT FOLDER SOURCE\n", argv[0]);
    return 2;
  }
  Fuzzer fuzzer;
  fuzzer.kind = argv[1], fuzzer.seed = std::stoull(argv[2]), fuzzer.folder = argv[5], fuzzer.source = argv[6];
  const std::int64_t first = std::stoll(argv[3]), count = std::stoll(argv[4]);
  check_mpi(MPI_Comm_rank(MPI_COMM_WORLD, &fuzzer.rank));
  std::error_code error;
  if (fuzzer.rank == 0) fs::create_directories(fuzzer.folder, error);
  std::signal(SIGALRM, tell_case);
  std::signal(SIGABRT, tell_case_and_abort);
  check_mpi(MPI_Barrier(MPI_COMM_WORLD));
  const int out = dup(STDOUT_FILENO), err = dup(STDERR_FILENO);
  if (std::freopen("/dev/null", "w", stdout) == nullptr) return 3;
  fuzzer.load_seeds();
  for (std::int64_t k = 0; k < count; ++k) fuzzer.run_case(first + k);
  std::fflush(stdout), dup2(out, STDOUT_FILENO), dup2(err, STDERR_FILENO);
  if (fuzzer.rank == 0)
    dprintf(out, "%s: %lld cases, seed %llu: %lld with a result, %lld refused, %lld stopped, %lld too large to try\n",
            fuzzer.kind.c_str(), static_cast<long long>(count), static_cast<unsigned long long>(fuzzer.seed),
            static_cast<long long>(fuzzer.ended[0]), static_cast<long long>(fuzzer.ended[1]),
            static_cast<long long>(fuzzer.ended[2]),
            static_cast<long long>(count - fuzzer.ended[0] - fuzzer.ended[1] - fuzzer.ended[2]));
  return 0;
}

}  // namespace

}  // namespace unibody::fuzz

int main(int argc, char** argv) {
  unibody::choose_for_mpi();
  unibody::check_mpi(MPI_Init(&argc, &argv));
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 3;
  int code = 3;
  try {
    code = unibody::fuzz::main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%sended by: %s\n", unibody::fuzz::described.c_str(), error.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  unibody::check_petsc(PetscFinalize());
  unibody::check_mpi(MPI_Finalize());
  return code;
}
