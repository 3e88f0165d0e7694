// report.csv: one row of numbers a step, to plot and to compare.
#pragma once

#include <mpi.h>

#include <cstdio>
#include <optional>
#include <string>

#include "report/measure.hpp"
#include "report/stretch.hpp"
#include "step/step_error.hpp"
#include "step/step_report.hpp"
#include "step/worst_constraint.hpp"

namespace unibody {

struct FrameReport {
  std::int64_t step = 0;
  double time = 0;              // s
  std::int64_t iterations = 0;  // of the solver
  double natural_residual = 0;  // m, of the frame's worst step
  double turning = 0;           // m, what constraints between centres miss because they turn; of the frame's worst step
  double estimated_error = 0;   // m, of all steps of the frame together, where the scene asks for an accuracy
  double residual_rate = 0;     // m/s, the residuals of all of its steps, over its length: by which what rests may creep
  Measures measures;
  std::int64_t sliding_contacts = 0;
  bool converged = false;
  CoarseCounts coarse;         // of its steps
  std::int64_t form_left = 0;  // steps taken in the incremental form, not the total one that the scene asks for
  // Wall times (s) of the step, the largest of all ranks; imbalance: largest over mean work (partition/work.hpp).
  double wall_collide = 0, wall_solve = 0, wall_halo = 0, wall_output = 0;
  double imbalance = 1;
  std::optional<WorstConstraint> worst;        // the one with the natural residual, where it was asked for
  std::optional<StepError> error;              // where it was asked for
  std::vector<NamedValue> constraint_columns;  // of scenes with cloths or threads; the same names in every frame
};

// The first `report_comparable_columns` columns are equal, digit by digit, for equal runs on any number of ranks:
// diff <(cut -d, -f1-21 a/report.csv) <(cut -d, -f1-21 b/report.csv). The rest depends on the machine, all but the columns of
// constraints, which come last.
inline constexpr int report_comparable_columns = 21;
std::string report_header(std::span<const NamedValue> constraint_columns = {});
std::string report_row(const FrameReport& report);

// The names of the columns that are the same on any machine, without their units; and the value of one, with or without its unit:
// none where the report has no such column, or an empty cell.
std::vector<std::string> report_names(std::span<const NamedValue> constraint_columns);
std::optional<double> report_value(const FrameReport& report, const std::string& name);

// Throws RunError that names the column on every rank where a number of the report is not finite. Collective.
void stop_if_not_finite(MPI_Comm comm, const FrameReport& report);

// Writes the file on rank 0 and flushes it after every row. Members are collective and throw RunError on every rank.
class ReportFile {
 public:
  // kept_to: where the file is there, its rows up to this frame stay, and InputError is thrown where it has other columns; -1:
  // none does.
  ReportFile(MPI_Comm comm, const std::string& path, std::span<const NamedValue> constraint_columns = {},
             std::int64_t kept_to = -1);
  // Throws InputError on every rank, and changes nothing, where the file is there with other columns. Collective.
  static void check_columns(MPI_Comm comm, const std::string& path, std::span<const NamedValue> constraint_columns);
  ~ReportFile();
  ReportFile(const ReportFile&) = delete;
  ReportFile& operator=(const ReportFile&) = delete;
  void append(const FrameReport& report);  // rank 0's is written
  void close();                            // nothing may follow

 private:
  void write_line(const std::string& line);
  MPI_Comm comm_;
  std::string path_;
  std::FILE* file_ = nullptr;
};

}  // namespace unibody
