// Worlds for the tests of report/: made-up bodies with awkward numbers, cut over the ranks in any way, and a folder to write to.
#pragma once

#include <gtest/gtest.h>
#include <mpi.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "world/world.hpp"

namespace unibody::testing_worlds {

inline int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

inline int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

// Body k: a plane first, then boxes and spheres by turns; every seventh body is fixed.
inline Body body(Id k) {
  const auto t = static_cast<double>(k);
  Body b;
  b.id = k;
  b.properties.shape.kind = k == 0 ? ShapeKind::plane : k % 2 == 0 ? ShapeKind::sphere : ShapeKind::box;
  if (k != 0) b.properties.shape.size = Vec3(0.1 + 0.01 * std::sin(t), k % 2 == 0 ? 0 : 0.2, k % 2 == 0 ? 0 : 0.3);
  b.properties.motion = k % 7 == 0 ? Motion::fixed : Motion::dynamic;
  b.properties.material = static_cast<std::int32_t>(k % 3);
  b.properties.mass = 1 + std::exp(std::sin(t));
  b.properties.inertia = Vec3(1, 2, 3) + Vec3::Constant(std::cos(t));
  b.properties.force = Vec3(t, 0, -t);
  b.properties.torque = Vec3(0, 0.5 * t, 0);
  b.state.position = Vec3(std::sin(t), std::cos(2 * t), t / 3);
  b.state.orientation = Quat(std::cos(t), std::sin(t), 0.1 * t, -0.3).normalized();
  b.state.velocity = Vec3(1 / (t + 3), -t, 1e-9 * t);
  b.state.angular_velocity = Vec3(std::tan(t), 0, -1);
  return b;
}

// This rank's world of bodies [0, count): dynamic body k is home on home(k). Statics everywhere. No guests.
inline World world(MPI_Comm comm, Id count, const std::function<int(Id)>& home) {
  World w;
  std::vector<Body> homes, statics;
  for (Id k = 0; k < count; ++k) {
    const Body b = body(k);
    if (!b.properties.is_dynamic())
      statics.push_back(b);
    else if (home(k) == rank_of(comm))
      homes.push_back(b);
  }
  w.homes = homes.size();
  w.resize(homes.size() + statics.size());
  std::size_t slot = 0;
  for (const auto& b : homes) w.set(slot++, b);
  for (const auto& b : statics) w.set(slot++, b);
  return w;
}

// Dealt out like cards; all on the last rank; scattered with one rank empty.
inline std::vector<std::function<int(Id)>> partitions(int ranks) {
  return {[ranks](Id k) { return static_cast<int>(k % ranks); }, [ranks](Id) { return ranks - 1; },
          [ranks](Id k) { return static_cast<int>(k * 2654435761 % 97 % (ranks == 1 ? 1 : ranks - 1)); }};
}

// A folder of this test, the same on all ranks, removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "unibody_test_XXXXXX").string();
    if (rank_of(MPI_COMM_WORLD) == 0 && mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "cannot make " << name;
    MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, MPI_COMM_WORLD);
    path_ = name;
  }
  ~Folder() {
    MPI_Barrier(MPI_COMM_WORLD);
    std::error_code ignored;
    if (rank_of(MPI_COMM_WORLD) == 0) std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

}  // namespace unibody::testing_worlds
