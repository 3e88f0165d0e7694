// Measures frames.h5 files of any program: settled and peak penetration, kinetic energy, height.
//   measure [--json] [--frames CSV] [--chain] FILE...
// --chain: also how far the joints of a chain are open (chain.hpp; anchors from the first frame).
#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <string>
#include <vector>

#include "chain.hpp"
#include "errors.hpp"

namespace {

using rivals::FrameErrors;
using rivals::RunErrors;

void print_header() {
  std::printf("%-40s %6s %9s %9s %9s | %9s %9s | %9s %8s %8s %7s %5s\n", "file", "frames", "RMS mm", "L2 mm", "max mm", "peak L2",
              "peak max", "KE/body J", "height m", "spread m", "depths", "lost");
}

void print_line(const std::string& file, const RunErrors& e) {
  const auto& s = e.settled;
  std::printf("%-40s %6ld %9.4f %9.3f %9.4f | %9.2f %9.2f | %9.2e %8.4f %8.3f %7ld %5ld\n", file.c_str(), e.frames, 1e3 * s.rms,
              1e3 * s.l2, 1e3 * s.max, 1e3 * e.peak_l2, 1e3 * e.peak_max, s.kinetic, s.height, s.spread, s.count, s.lost);
}

void print_json(const std::string& file, const RunErrors& e, const std::string& more) {
  const auto& s = e.settled;
  std::printf(
      "{\"file\": \"%s\", \"frames\": %ld, \"rms_mm\": %.9g, \"l2_mm\": %.9g, \"max_mm\": %.9g, \"peak_l2_mm\": %.9g, "
      "\"peak_max_mm\": %.9g, \"kinetic_j\": %.9g, \"height_m\": %.9g, \"spread_m\": %.9g, \"depths\": %ld, \"lost\": %ld%s}\n",
      file.c_str(), e.frames, 1e3 * s.rms, 1e3 * s.l2, 1e3 * s.max, 1e3 * e.peak_l2, 1e3 * e.peak_max, s.kinetic, s.height,
      s.spread, s.count, s.lost, more.c_str());
}

void write_frames(const std::string& path, const std::vector<long>& numbers, const std::vector<FrameErrors>& frames) {
  std::ofstream out(path);
  out << "frame,rms_mm,l2_mm,max_mm,kinetic_j_per_body,height_m,spread_m,depths,lost\n" << std::setprecision(9);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& f = frames[i];
    out << numbers[i] << ',' << 1e3 * f.rms << ',' << 1e3 * f.l2 << ',' << 1e3 * f.max << ',' << f.kinetic << ',' << f.height
        << ',' << f.spread << ',' << f.count << ',' << f.lost << '\n';
  }
}

// Medians of all frames, and the largest of all.
std::string drift_json(std::vector<rivals::Drift> drifts) {
  std::vector<double> rms, max;
  for (const auto& d : drifts) rms.push_back(1e3 * d.rms), max.push_back(1e3 * d.max);
  std::sort(rms.begin(), rms.end()), std::sort(max.begin(), max.end());
  char text[160];
  std::snprintf(text, sizeof text, ", \"drift_rms_mm\": %.9g, \"drift_max_mm\": %.9g, \"drift_peak_mm\": %.9g",
                rms[rms.size() / 2], max[max.size() / 2], max.back());
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, chain = false;
  std::string table;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--chain") {
      chain = true;
    } else if (argument == "--frames" && i + 1 < argc) {
      table = argv[++i];
    } else {
      files.push_back(argument);
    }
  }
  if (files.empty() || files[0].starts_with("-")) {
    std::fprintf(stderr, "usage: measure [--json] [--frames CSV] [--chain] FILE...\n");
    return 2;
  }
  try {
    if (!json) print_header();
    for (const auto& file : files) {
      const rivals::FrameReader reader(file);
      const auto bodies = reader.bodies();
      rivals::Frame frame;
      std::vector<FrameErrors> frames;
      std::vector<rivals::Anchor> anchors;
      std::vector<rivals::Drift> drifts;
      for (const long number : reader.frames()) {
        reader.read(number, frame);
        if (frame.position.size() != bodies.count())
          throw std::runtime_error("frame " + std::to_string(number) + " of '" + file + "' has another number of bodies");
        frames.push_back(rivals::measure(bodies, frame));
        if (chain && anchors.empty()) anchors = rivals::chain_anchors(bodies, frame);
        if (chain) drifts.push_back(rivals::chain_drift(anchors, frame));
      }
      if (!table.empty()) write_frames(table, reader.frames(), frames);
      const auto errors = rivals::summarise(frames);
      json ? print_json(file, errors, chain ? drift_json(drifts) : "") : print_line(file, errors);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "measure: %s\n", error.what());
    return 1;
  }
  return 0;
}
