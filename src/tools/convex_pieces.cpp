// Decomposes a closed surface into convex pieces by HACD, for `compound: {mesh, pieces_file}`. Usage: scripts/convex_pieces -h
#include <bullet/HACD/hacdHACD.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.hpp"
#include "meshes/mesh_topology.hpp"
#include "meshes/surface_file.hpp"
#include "world/hull.hpp"
#include "world/solid_moments.hpp"

namespace {

using namespace unibody;

constexpr const char* usage = "usage: convex_pieces SURFACE OUT.obj [--concavity C] [--pieces N] [--corners N]";
constexpr double normalised = 2000;  // HACD makes it the diagonal of the box around the surface, and counts lengths so

struct Options {
  std::string surface, out;
  double concavity = 0.05;  // of that diagonal
  double pieces = 1, corners = 48;
};

double number_of(std::string_view name, const char* text, double least) {
  const std::string_view word = text == nullptr ? "" : text;
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !(value >= least))
    throw InputError(std::string(name) + " '" + std::string(word) + "': expected a number >= " + std::to_string(least) + "; " +
                     usage);
  return value;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const auto value = [&](double least) { return number_of(argument, ++i < argc ? argv[i] : nullptr, least); };
    if (argument == "--concavity")
      options.concavity = value(0);
    else if (argument == "--pieces")
      options.pieces = value(1);
    else if (argument == "--corners")
      options.corners = value(4);
    else if (argument.starts_with("-"))
      throw InputError("unknown option '" + std::string(argument) + "'; " + usage);
    else if (options.surface.empty())
      options.surface = argument;
    else if (options.out.empty())
      options.out = argument;
    else
      throw InputError("one surface is decomposed at a time, found '" + std::string(argument) + "' too; " + usage);
  }
  if (options.out.empty()) throw InputError(std::string("a surface and a file to write are needed; ") + usage);
  if (!options.out.ends_with(".obj")) throw InputError("'" + options.out + "' does not end in .obj; " + usage);
  return options;
}

TriangleMesh closed_surface(const std::string& path) {
  TriangleMesh mesh = read_surface(path);
  const MeshTopology topology = mesh_topology(mesh, path);
  if (!topology.boundary.empty())
    throw InputError(path + " has " + std::to_string(topology.boundary.size()) +
                     " edges at holes: only a closed surface has an inside to decompose");
  orient_triangles(mesh, topology, path);
  if (solid_moments(mesh.nodes, mesh.triangles).volume < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// m, the diagonal of the box around the nodes.
double extent(const std::vector<Vec3>& nodes) {
  Vec3 low = nodes[0], high = nodes[0];
  for (const Vec3& x : nodes) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return (high - low).norm();
}

// The corners of each piece, m.
std::vector<std::vector<Vec3>> decompose(const TriangleMesh& mesh, const Options& options) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const Vec3& x : mesh.nodes) points.emplace_back(x.x(), x.y(), x.z());
  std::vector<HACD::Vec3<long>> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  HACD::HACD work;
  work.SetPoints(points.data()), work.SetNPoints(points.size());
  work.SetTriangles(triangles.data()), work.SetNTriangles(triangles.size());
  work.SetCompacityWeight(0.0001), work.SetVolumeWeight(0);  // by concavity alone, as its authors advise for shapes of contact
  work.SetScaleFactor(normalised / 2);
  work.SetNClusters(static_cast<std::size_t>(options.pieces));
  work.SetNVerticesPerCH(static_cast<std::size_t>(options.corners));
  work.SetConcavity(options.concavity * normalised);
  work.SetConnectDist(0.015 * normalised);
  work.SetAddExtraDistPoints(true), work.SetAddNeighboursDistPoints(true), work.SetAddFacesPoints(true);
  work.NormalizeData();
  if (!work.Compute()) throw RunError("HACD finds no pieces of '" + options.surface + "'");
  // It gives the pieces as it has made the points.
  const Vec3 &x0 = mesh.nodes[0], y0(points[0].X(), points[0].Y(), points[0].Z());
  const double scale = extent(mesh.nodes) / normalised;
  std::vector<std::vector<Vec3>> pieces;
  for (std::size_t k = 0; k < work.GetNClusters(); ++k) {
    std::vector<HACD::Vec3<HACD::Real>> corners(work.GetNPointsCH(k));
    std::vector<HACD::Vec3<long>> faces(work.GetNTrianglesCH(k));
    work.GetCH(k, corners.data(), faces.data());
    auto& piece = pieces.emplace_back();
    for (const auto& y : corners) piece.push_back(x0 + scale * (Vec3(y.X(), y.Y(), y.Z()) - y0));
  }
  return pieces;
}

struct Written {
  std::size_t pieces = 0;
  double volume = 0;  // m^3, the sum
};

// Each piece as an object of its own, its faces as the hull's.
Written write(const std::vector<std::vector<Vec3>>& pieces, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw RunError("cannot write '" + path + "'");
  Written written;
  std::size_t before = 1;  // OBJ numbers nodes from 1
  for (const auto& points : pieces) {
    Hull hull;
    try {
      hull = make_hull(points);
    } catch (const std::invalid_argument&) {  // flat: its neighbours hold the rest
      continue;
    }
    std::fprintf(file, "o piece_%zu\n", written.pieces++);
    for (const Vec3& corner : hull.corners) {
      const Vec3 x = hull.centre + hull.frame * corner;
      std::fprintf(file, "v %.9g %.9g %.9g\n", x.x(), x.y(), x.z());
    }
    for (const Hull::Face& face : hull.faces) {
      std::fputs("f", file);
      for (std::uint32_t c = face.first; c < face.first + face.count; ++c)
        std::fprintf(file, " %zu", before + hull.face_corners[c]);
      std::fputs("\n", file);
    }
    before += hull.corners.size(), written.volume += hull.volume;
  }
  const bool good = std::ferror(file) == 0;
  if (std::fclose(file) != 0 || !good) throw RunError("cannot write '" + path + "': is the disk full?");
  return written;
}

void run(const Options& options) {
  const TriangleMesh mesh = closed_surface(options.surface);
  const Written written = write(decompose(mesh, options), options.out);
  if (written.pieces == 0) throw RunError("HACD finds no pieces with a volume in '" + options.surface + "'");
  std::printf("%s: %zu pieces; the sum of their volumes is %.4g of the solid's\n", options.out.c_str(), written.pieces,
              written.volume / solid_moments(mesh.nodes, mesh.triangles).volume);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(parse(argc, argv));
  } catch (const unibody::InputError& e) {
    std::fprintf(stderr, "convex_pieces: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "convex_pieces: %s\n", e.what());
    return 1;
  }
}
