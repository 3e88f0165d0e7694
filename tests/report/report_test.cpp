#include "report/report.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "core/errors.hpp"
#include "core/json.hpp"
#include "report/summary.hpp"
#include "report_worlds.hpp"

namespace unibody::report_test {
namespace {

using namespace testing_worlds;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

TEST(Report, HeaderNamesUnitsAndTimesComeLast) {
  const auto names = split(report_header());
  EXPECT_EQ(names.size(), split(report_row({})).size());
  EXPECT_EQ(names[0], "step");
  for (const char* name :
       {"time (s)", "penetration_max (m)", "natural_residual_rate (m/s)", "kinetic_energy (J)", "angular_momentum_z (kg m^2/s)"})
    EXPECT_EQ(std::count(names.begin(), names.begin() + report_comparable_columns, name), 1) << name;
  for (std::size_t k = 0; k < names.size(); ++k)
    EXPECT_EQ(names[k].starts_with("wall_") || names[k].starts_with("bytes_") || names[k].starts_with("imbalance"),
              k >= static_cast<std::size_t>(report_comparable_columns));
}

TEST(Report, NumbersComeBackToTheLastBit) {
  FrameReport r;
  r.time = 0.1;
  r.natural_residual = std::nextafter(1e-5, 1.0);
  r.measures.kinetic_energy = -5e-324;
  const auto cells = split(report_row(r));
  EXPECT_EQ(std::strtod(cells[1].c_str(), nullptr), r.time);
  EXPECT_EQ(std::strtod(cells[3].c_str(), nullptr), r.natural_residual);
  EXPECT_EQ(std::strtod(cells[10].c_str(), nullptr), r.measures.kinetic_energy);
}

TEST(RanksReport, EveryRowIsOnTheDiskAtOnce) {
  const Folder folder;
  ReportFile file(MPI_COMM_WORLD, folder / "report.csv");
  FrameReport r;
  file.append(r);
  r.step = 1;
  file.append(r);
  EXPECT_EQ(contents(folder / "report.csv"), report_header() + "\n" + report_row({}) + "\n" + report_row(r) + "\n");
  MPI_Barrier(MPI_COMM_WORLD);
  const FileSizeLimit limit(100);
  EXPECT_THROW(file.append(r), RunError);
  EXPECT_THROW(ReportFile(MPI_COMM_WORLD, folder / "none/report.csv"), RunError);
}

TEST(Json, EscapesAndNests) {
  const Json j =
      Json::object().set("a\"b", "x\n\\\x01").set("list", Json::array().push(1).push(true).push(0.1)).set("e", Json::array());
  EXPECT_EQ(
      j.text(),
      "{\n  \"a\\\"b\": \"x\\n\\\\\\u0001\",\n  \"list\": [\n    1,\n    true,\n    0.10000000000000001\n  ],\n  \"e\": []\n}");
  EXPECT_EQ(Json(std::numeric_limits<double>::infinity()).text(), "null");
}

TEST(Summary, NamesTheWorstAndTheLastEstimatedError) {
  Summary summary;
  FrameReport report;
  EXPECT_EQ(summary_text(MPI_COMM_SELF, Scene(), summary).find("error_estimates"), std::string::npos);
  const double found[] = {2e-5, 7e-5, 7e-5, 1e-5};  // m, in the frames 3, 6, 9 and 11
  for (int frame = 1; frame <= 11; ++frame) {
    report.step = frame, report.error.reset();
    if (frame % 3 == 0) report.error = StepError{found[frame / 3 - 1], 0.5, 1e-9, 7};
    if (frame == 11) report.error = StepError{found[3], 0.25, 2e-9, 7};
    summary.add(report);
  }
  EXPECT_EQ(summary.errors.count, 4);
  EXPECT_EQ(summary.errors.worst_frame, 6);  // the first of two
  EXPECT_EQ(summary.errors.worst.distance, 7e-5);
  EXPECT_EQ(summary.errors.last_frame, 11);
  EXPECT_EQ(summary.errors.last.distance, 1e-5);
  const std::string text = summary_text(MPI_COMM_SELF, Scene(), summary);
  for (const char* part : {"\"error_estimates\"", "\"samples\": 4", "\"frame\": 6", "\"error_relative (1)\": 0.25"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
}

// Of 2^18 figures, which ascend to 1 in an order that leaves none for the end, no more than 2^16 are kept: shares and median are
// theirs of all, to one part of those, and count, sum and largest are exact.
TEST(Figures, StayFewInALongRun) {
  constexpr std::int64_t count = 1 << 18;
  Figures figures;
  double sum = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    const double x = static_cast<double>((k * 97531) % count + 1) / count;  // an odd factor: each of them once
    figures.add(x), sum += x;
    ASSERT_LE(figures.kept().size(), Figures::most_kept);
  }
  EXPECT_EQ(figures.count(), count);
  EXPECT_DOUBLE_EQ(figures.total(), sum);
  EXPECT_EQ(figures.within(1), 1);
  EXPECT_GT(figures.kept().size(), Figures::most_kept / 2);
  EXPECT_NEAR(figures.within(0.5), 0.5, 1e-3);
  EXPECT_NEAR(figures.within(0.95), 0.95, 1e-3);
  EXPECT_NEAR(figures.median(), 0.5, 1e-3);
}

TEST(Convergence, TellsHowFarAndWhat) {
  Scene scene;
  BodyGroup group;
  group.count = 9, group.name = "pile", group.generated = true;
  scene.groups.push_back(group);
  Convergence convergence;
  convergence.tolerance = 1e-5, convergence.smallest_size = 0.008;
  FrameReport report;
  for (int frame = 1; frame <= 100; ++frame) {  // residuals of 1 to 100 micrometres, the largest in frame 37
    report.step = frame, report.natural_residual = 1e-6 * ((frame + 62) % 100 + 1);
    report.residual_rate = 10 * report.natural_residual;
    report.converged = report.natural_residual <= 1e-5;
    report.worst.reset();
    if (report.natural_residual > convergence.worst_residual) {
      report.worst.emplace();
      report.worst->kind = "contacts", report.worst->bodies[0] = frame % 9, report.worst->bodies[1] = 8;
    }
    convergence.add(report);
  }
  EXPECT_EQ(convergence.unconverged, 90);
  EXPECT_DOUBLE_EQ(convergence.residuals.within(0.5), 5e-5);
  EXPECT_DOUBLE_EQ(convergence.residuals.within(0.95), 9.5e-5);
  EXPECT_DOUBLE_EQ(convergence.residuals.within(1), 1e-4);
  EXPECT_EQ(
      told(convergence, scene),
      "accuracy: 80 of 100 frames are within 0.01 of the smallest moving body's size (8.00e-05 m)\n"
      "what they are off by, over that size: half within 6.25e-03, 95 % within 1.19e-02, all within 1.25e-02 (frame 37, "
      "natural residual)\n"
      "no accuracy is asked for: with solver.accuracy the program picks the iterations (docs/accuracy.md)\n"
      "natural residual: half within 5.00e-05 m, 95 % within 9.50e-05 m, all within 1.00e-04 m; 10 of 100 frames converged "
      "to the tolerance of 1.00e-05 m\n"
      "what should rest may creep by so much a second: half within 5.00e-04 m, 95 % within 9.50e-04 m, all within 1.00e-03 m\n"
      "farthest from solved: frame 37, contacts of pile[1] and pile[8]\n");
  const std::string text = summary_text(MPI_COMM_SELF, scene, [&] {
    Summary summary;
    summary.convergence = convergence;
    return summary;
  }());
  for (const char* part : {"\"frames_not_converged\": 90", "\"worst_frame\": 37", "\"kind\": \"contacts\"", "\"pile[1]\""})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
}

TEST(Convergence, OfARunThatConverged) {
  Convergence convergence;
  convergence.tolerance = 1e-5;
  FrameReport report;
  report.step = 1, report.converged = true;
  convergence.add(report);
  EXPECT_EQ(
      told(convergence, Scene()),
      "natural residual: half within 0.00e+00 m, 95 % within 0.00e+00 m, all within 0.00e+00 m; all of 1 frames converged "
      "to the tolerance of 1.00e-05 m\n"
      "what should rest may creep by so much a second: half within 0.00e+00 m, 95 % within 0.00e+00 m, all within 0.00e+00 m\n");
}

// With an accuracy a frame is off by its estimated error, or by how deep its contacts and how far open its joints are, whichever
// is more.
TEST(Convergence, JudgesByTheAccuracyThatIsAskedFor) {
  Convergence convergence;
  convergence.smallest_size = 0.1, convergence.accuracy = 1e-3, convergence.asked = true;
  FrameReport report;
  report.converged = true;
  const auto add = [&](double error, double penetration, double drift) {
    ++report.step;
    report.natural_residual = 1e-6, report.residual_rate = 1e-4, report.estimated_error = error,
    report.measures.penetration_max = penetration;
    report.constraint_columns = {{"joint_drift_max (m)", drift}};
    convergence.add(report);
  };
  add(0.9e-4, 0, 0), add(1.1e-4, 0, 0), add(0, 1.2e-4, 0), add(1e-5, 2e-5, 3e-4);
  EXPECT_EQ(convergence.held, 1);
  EXPECT_EQ(convergence.offs.kept(), (std::vector<double>{0.9e-4, 1.1e-4, 1.2e-4, 3e-4}));
  EXPECT_EQ(convergence.most_off_frame, 4);
  EXPECT_EQ(
      told(convergence, Scene()),
      "accuracy 0.001 of the smallest moving body's size (1.00e-04 m) asked: held in 1 of 4 frames\n"
      "what they are off by, over that size: half within 1.10e-03, 95 % within 3.00e-03, all within 3.00e-03 (frame 4, "
      "joint drift)\n"
      "natural residual: half within 1.00e-06 m, 95 % within 1.00e-06 m, all within 1.00e-06 m\n"
      "what should rest may creep by so much a second: half within 1.00e-04 m, 95 % within 1.00e-04 m, all within 1.00e-04 m\n");
  report.converged = false, add(1e-3, 0, 0);
  EXPECT_NE(told(convergence, Scene()).find("in 1 of 5 frames the solve ended short of it"), std::string::npos);
}

TEST(RanksSummary, IsJson) {
  const Folder folder;
  Scene scene;
  scene.path = "scenes/\"odd\" name.yaml";
  Summary summary;
  summary.overrides = {{"solver.iterations", "20"}};
  summary.phases = {{"solve", {3, 1, 2}, 0.5, 1, 1.5}, {"collide", {}}};
  summary.state_hash = 0x00ff00000000000a;
  summary.files = {"frames.h5"};
  const std::string path = folder / "summary.json";
  write_summary(MPI_COMM_WORLD, path, scene, summary);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    const std::string check =
        "import json, sys; j = json.load(open(sys.argv[1])); p = j['timings']['phases']['solve']; "
        "assert p == {'total (s)': 6, 'median a frame (s)': 2, 'least of a rank (s)': 0.5, 'mean of the ranks (s)': 1, "
        "'most of a rank (s)': 1.5}, p; assert j['state_hash'] == '00ff00000000000a'; "
        "assert j['scene']['path'] == 'scenes/\\\"odd\\\" name.yaml'; assert j['versions']['hdf5'].startswith('1.')";
    EXPECT_EQ(std::system(("/usr/bin/python3 -c \"" + check + "\" " + path).c_str()), 0) << contents(path);
  }
  EXPECT_THROW(write_summary(MPI_COMM_WORLD, folder / "none/summary.json", scene, summary), RunError);
}

}  // namespace
}  // namespace unibody::report_test
