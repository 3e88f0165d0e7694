#include "report/report.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/hdf5.hpp"
#include "report/kept_rows.hpp"

namespace unibody {

namespace {

struct Column {
  const char* name;
  double (*value)(const FrameReport&);  // integers too: exact in a double up to 2^53
};

#define COLUMN(name, expression)                                               \
  Column {                                                                     \
    name, [](const FrameReport& r) { return static_cast<double>(expression); } \
  }

const std::array columns{
    COLUMN("step", r.step),
    COLUMN("time (s)", r.time),
    COLUMN("iterations", r.iterations),
    COLUMN("natural_residual (m)", r.natural_residual),
    COLUMN("penetration_max (m)", r.measures.penetration_max),
    COLUMN("penetration_rms (m)", r.measures.penetration_rms),
    COLUMN("penetration_l2 (m)", r.measures.penetration_l2),
    COLUMN("contact_pairs", r.measures.pairs),
    COLUMN("contacts", r.measures.contacts),
    COLUMN("sliding_contacts", r.sliding_contacts),
    COLUMN("kinetic_energy (J)", r.measures.kinetic_energy),
    COLUMN("potential_energy (J)", r.measures.potential_energy),
    COLUMN("linear_momentum_x (kg m/s)", r.measures.linear_momentum[0]),
    COLUMN("linear_momentum_y (kg m/s)", r.measures.linear_momentum[1]),
    COLUMN("linear_momentum_z (kg m/s)", r.measures.linear_momentum[2]),
    COLUMN("angular_momentum_x (kg m^2/s)", r.measures.angular_momentum[0]),
    COLUMN("angular_momentum_y (kg m^2/s)", r.measures.angular_momentum[1]),
    COLUMN("angular_momentum_z (kg m^2/s)", r.measures.angular_momentum[2]),
    COLUMN("total_energy (J)", r.measures.kinetic_energy + r.measures.potential_energy + r.measures.elastic_energy),
    COLUMN("converged (0|1)", r.converged),
    COLUMN("natural_residual_rate (m/s)", r.residual_rate),
    COLUMN("bytes_per_body (B)", r.measures.bytes_per_body),
    COLUMN("wall_collide (s)", r.wall_collide),
    COLUMN("wall_solve (s)", r.wall_solve),
    COLUMN("wall_halo (s)", r.wall_halo),
    COLUMN("wall_output (s)", r.wall_output),
    COLUMN("imbalance (max/mean)", r.imbalance),
};
#undef COLUMN

std::string without_unit(const std::string& name) { return name.substr(0, name.find(" (")); }

bool is_named(const std::string& column, const std::string& name) { return column == name || without_unit(column) == name; }

// What is wrong with the first number that is not finite; empty where all are.
std::string infinite_column(const FrameReport& report) {
  const auto fault = [](const std::string& name, double value) {
    return "the report's " + name + " is no longer finite: " + (std::isnan(value) ? "nan" : "infinity");
  };
  for (const Column& c : columns)
    if (const double value = c.value(report); !std::isfinite(value)) return fault(c.name, value);
  for (const NamedValue& c : report.constraint_columns)
    if (c.known && !std::isfinite(c.value)) return fault(c.name, c.value);
  return {};
}

}  // namespace

std::string report_header(std::span<const NamedValue> constraint_columns) {
  std::string line;
  for (const Column& c : columns) line.append(line.empty() ? "" : ",").append(c.name);
  for (const NamedValue& c : constraint_columns) line.append(",").append(c.name);
  return line;
}

std::vector<std::string> report_names(std::span<const NamedValue> constraint_columns) {
  std::vector<std::string> names;
  for (const Column& c : std::span(columns).first(report_comparable_columns)) names.push_back(without_unit(c.name));
  for (const NamedValue& c : constraint_columns) names.push_back(without_unit(c.name));
  return names;
}

std::optional<double> report_value(const FrameReport& report, const std::string& name) {
  for (const Column& c : std::span(columns).first(report_comparable_columns))
    if (is_named(c.name, name)) return c.value(report);
  for (const NamedValue& c : report.constraint_columns)
    if (is_named(c.name, name)) return c.known ? std::optional(c.value) : std::nullopt;
  return std::nullopt;
}

std::string report_row(const FrameReport& report) {
  std::string line;
  const auto put = [&](double value) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.17g", value);
    line.append(line.empty() ? "" : ",").append(text.data());
  };
  for (const Column& c : columns) put(c.value(report));
  for (const NamedValue& c : report.constraint_columns) c.known ? put(c.value) : static_cast<void>(line.append(","));
  return line;
}

ReportFile::ReportFile(MPI_Comm comm, const std::string& path, std::span<const NamedValue> constraint_columns,
                       std::int64_t kept_to)
    : comm_(comm), path_(path) {
  int rank = 0, goes_on = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  const std::string header = report_header(constraint_columns);
  agree<InputError>(comm, "", [&] { goes_on = rank == 0 && kept_to >= 0 && keep_rows(path, header, kept_to) ? 1 : 0; });
  check_mpi(MPI_Bcast(&goes_on, 1, MPI_INT, 0, comm));
  if (rank == 0) file_ = std::fopen(path.c_str(), goes_on != 0 ? "a" : "w");
  const auto fault = first_fault(comm, rank == 0 && file_ == nullptr ? "cannot write '" + path + "'" : "");
  if (!fault.empty()) throw RunError(fault);
  if (goes_on == 0) write_line(header);
}

void ReportFile::check_columns(MPI_Comm comm, const std::string& path, std::span<const NamedValue> constraint_columns) {
  int rank = 0;
  check_mpi(MPI_Comm_rank(comm, &rank));
  agree<InputError>(comm, "", [&] {
    if (rank == 0) check_header(path, report_header(constraint_columns));
  });
}

ReportFile::~ReportFile() {
  if (file_ != nullptr) std::fclose(file_);
}

void stop_if_not_finite(MPI_Comm comm, const FrameReport& report) {
  const auto fault = first_fault(comm, infinite_column(report));
  if (!fault.empty()) throw RunError("frame " + std::to_string(report.step) + ": " + fault);
}

void ReportFile::append(const FrameReport& report) { write_line(report_row(report)); }

void ReportFile::close() {
  const bool good = file_ == nullptr || std::fclose(std::exchange(file_, nullptr)) == 0;
  const auto fault = first_fault(comm_, good ? "" : "cannot write '" + path_ + "': is the disk full?");
  if (!fault.empty()) throw RunError(fault);
}

void ReportFile::write_line(const std::string& line) {
  const bool good = file_ == nullptr || (std::fprintf(file_, "%s\n", line.c_str()) >= 0 && std::fflush(file_) == 0);
  const auto fault = first_fault(comm_, good ? "" : "cannot write '" + path_ + "': is the disk full?");
  if (!fault.empty()) throw RunError(fault);
}

}  // namespace unibody
