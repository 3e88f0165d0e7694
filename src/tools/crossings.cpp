// Counts the crossings of cloths and threads in the frames of a run. Usage: scripts/crossings -h
#include "collide/crossings.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <limits>
#include <map>
#include <string_view>

#include "core/errors.hpp"
#include "report/frames_file.hpp"

namespace {

using namespace unibody;

constexpr const char* usage = "usage: crossings RESULTS_DIR [--frames all|last|N] [--per-surface]";

struct Options {
  std::string path;
  std::string frames = "all";
  bool per_surface = false;
};

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--per-surface") {
      options.per_surface = true;
    } else if (argument == "--frames") {
      if (++i == argc) throw InputError(std::string("--frames needs 'all', 'last' or a frame's number; ") + usage);
      options.frames = argv[i];
    } else if (argument.starts_with("-")) {
      throw InputError("unknown option '" + std::string(argument) + "'; " + usage);
    } else if (options.path.empty() && !argument.empty()) {
      options.path = argument;
    } else {
      throw InputError("one folder of results is checked at a time, found '" + std::string(argument) + "' too; " + usage);
    }
  }
  if (options.path.empty()) throw InputError(std::string("no folder of results given; ") + usage);
  return options;
}

std::vector<std::int64_t> chosen_frames(const std::string& choice, const FramesFile& file) {
  const auto& all = file.frames();
  if (choice == "all") return all;
  if (choice == "last") return {all.back()};
  std::int64_t number = -1;
  const auto [end, error] = std::from_chars(choice.data(), choice.data() + choice.size(), number);
  if (error != std::errc() || end != choice.data() + choice.size())
    throw InputError("--frames '" + choice + "': expected 'all', 'last' or a frame's number");
  if (std::find(all.begin(), all.end(), number) == all.end())
    throw InputError("no frame " + choice + " in '" + file.path() + "': expected one of the " + std::to_string(all.size()) +
                     " written, " + std::to_string(all.front()) + " to " + std::to_string(all.back()));
  return {number};
}

// All edges and faces, and the surface that each is of.
struct Topology {
  std::vector<std::string> names;
  std::vector<Edge> edges;
  std::vector<Face> faces;
  std::vector<std::size_t> surface_of_edge, surface_of_face;
};

Topology read_topology(const FramesFile& file) {
  if (file.body_count() > std::numeric_limits<Slot>::max())
    throw InputError("'" + file.path() + "' has " + std::to_string(file.body_count()) + " bodies: more than this tool can hold");
  Topology topology;
  for (const auto& surface : file.surfaces()) {
    const std::size_t number = topology.names.size();
    topology.names.push_back(surface.name);
    const auto slot = [](Id id) { return static_cast<Slot>(id); };
    std::vector<Edge> edges;
    if (surface.corners == 2) {
      for (const auto& c : surface.cells) edges.push_back({slot(c[0]), slot(c[1])});
    } else {
      std::vector<Face> faces;
      for (const auto& c : surface.cells) faces.push_back({slot(c[0]), slot(c[1]), slot(c[2])});
      edges = unique_edges(faces);
      topology.faces.insert(topology.faces.end(), faces.begin(), faces.end());
    }
    topology.edges.insert(topology.edges.end(), edges.begin(), edges.end());
    topology.surface_of_edge.resize(topology.edges.size(), number);
    topology.surface_of_face.resize(topology.faces.size(), number);
  }
  return topology;
}

struct Counts {
  std::int64_t self = 0, between = 0;
  std::int64_t sum() const { return self + between; }
};

// Prints, for each pair of surfaces with crossings, how many there are, and the bodies of the first.
void print_surfaces(const Topology& topology, const std::vector<Crossing>& crossings) {
  struct Found {
    std::int64_t count = 0;
    Crossing first{};
  };
  std::map<std::pair<std::size_t, std::size_t>, Found> found;
  for (const Crossing& c : crossings) {
    Found& f = found[{topology.surface_of_edge[c.edge], topology.surface_of_face[c.face]}];
    if (f.count++ == 0) f.first = c;
  }
  for (const auto& [surfaces, f] : found) {
    const Edge& e = topology.edges[f.first.edge];
    const Face& t = topology.faces[f.first.face];
    std::printf("    %lld: edges of '%s' (%zu) through faces of '%s' (%zu), as bodies %d %d through %d %d %d\n",
                static_cast<long long>(f.count), topology.names[surfaces.first].c_str(), surfaces.first,
                topology.names[surfaces.second].c_str(), surfaces.second, e[0], e[1], t[0], t[1], t[2]);
  }
}

int run(const Options& options) {
  const FramesFile file(options.path);
  const auto frames = chosen_frames(options.frames, file);
  const Topology topology = read_topology(file);
  std::vector<Vec3> positions;
  Counts total;
  std::printf("%8s %14s %10s %10s %10s\n", "frame", "time", "crossings", "self", "between");
  for (const std::int64_t frame : frames) {
    file.positions(frame, positions);
    const auto crossings = find_crossings(positions, topology.faces, topology.edges);
    Counts counts;
    for (const Crossing& c : crossings)
      ++(topology.surface_of_edge[c.edge] == topology.surface_of_face[c.face] ? counts.self : counts.between);
    std::printf("%8lld %14.9g %10lld %10lld %10lld\n", static_cast<long long>(frame), file.time(frame),
                static_cast<long long>(counts.sum()), static_cast<long long>(counts.self),
                static_cast<long long>(counts.between));
    if (options.per_surface) print_surfaces(topology, crossings);
    total.self += counts.self, total.between += counts.between;
  }
  std::printf("total: %lld crossings in %zu frame%s, %lld of a surface with itself, %lld between surfaces\n",
              static_cast<long long>(total.sum()), frames.size(), frames.size() == 1 ? "" : "s",
              static_cast<long long>(total.self), static_cast<long long>(total.between));
  return total.sum() == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::string fault;
  try {
    options = parse(argc, argv);
    return run(options);
  } catch (const InputError& error) {
    fault = error.what();
  } catch (const std::exception& error) {  // of HDF5, on a damaged file
    fault = "'" + options.path + "': " + error.what();
  }
  std::fflush(stdout);
  std::fprintf(stderr, "crossings: %s\n", fault.c_str());
  return 2;
}
