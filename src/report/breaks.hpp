// What output tells of joints that break.
#pragma once

#include <mpi.h>

#include <cstdio>
#include <string>
#include <vector>

#include "report/stretch.hpp"
#include "scene/scene.hpp"
#include "step/history.hpp"

namespace unibody {

// A line for a run's end that says how many joints have broken, and which was the first; empty in a scene where none can.
std::string told_breaks(const Scene& scene, const Past& past);

// The column `broken_joints` of report.csv; a scene where none can break has none.
std::vector<NamedValue> break_columns(const Scene& scene, const Past& past);

// breaks.csv: a line for each joint that has broken, in the order in which they did.
class BreakFile {
 public:
  // Starts the file anew: the history of a run that goes on has all breaks before it. Members are collective and throw RunError
  // on every rank where the disk fails; rank 0 writes.
  BreakFile(MPI_Comm comm, const std::string& directory, const Scene& scene);
  ~BreakFile();
  BreakFile(const BreakFile&) = delete;
  BreakFile& operator=(const BreakFile&) = delete;

  // Writes those of the run's breaks that it has not written.
  void write(const std::vector<Break>& breaks);
  void close();  // nothing may follow

 private:
  void fail_where(bool bad) const;

  MPI_Comm comm_;
  std::string path_;
  const Scene& scene_;
  std::vector<std::string> names_;  // of the joints
  std::size_t written_ = 0;
  std::FILE* csv_ = nullptr;
};

}  // namespace unibody
