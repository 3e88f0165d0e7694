#include "driver.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>

namespace rivals {

namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Settings parse(int argc, char** argv) {
  Settings s;
  const std::pair<const char*, int*> counts[] = {{"--iterations", &s.iterations},
                                                 {"--substeps", &s.substeps},
                                                 {"--chain", &s.tied},
                                                 {"--direct", &s.direct},
                                                 {"--split", &s.split}};
  const std::pair<const char*, double*> numbers[] = {{"--step", &s.step}, {"--friction", &s.friction}, {"--gravity", &s.gravity},
                                                     {"--erp2", &s.erp2}, {"--erp", &s.erp},           {"--erv", &s.erv}};
  for (int i = 3; i < argc; i += 2) {
    const std::string key = argv[i];
    if (i + 1 >= argc) throw std::runtime_error("'" + key + "' needs a value");
    bool known = key == "--frames";
    if (known) s.frames = std::atol(argv[i + 1]);
    for (const auto& [name, to] : counts)
      if (key == name) *to = std::atoi(argv[i + 1]), known = true;
    for (const auto& [name, to] : numbers)
      if (key == name) *to = std::atof(argv[i + 1]), known = true;
    if (!known) throw std::runtime_error("unknown option '" + key + "'");
  }
  if (s.iterations < 1 || s.substeps < 1 || s.frames < 1 || s.step <= 0) throw std::runtime_error("a setting is not positive");
  return s;
}

// One frame from the state before it into `frame`: its CPU seconds, or none where the state is no longer finite.
std::optional<double> advance(Engine& engine, const Bodies& scene, const Settings& settings, Frame& frame) {
  const double begin = cpu_seconds();
  double seconds = 0;
  try {
    for (int s = 0; s < settings.substeps; ++s) engine.step(settings.step / settings.substeps);
    seconds = cpu_seconds() - begin;
    engine.read(scene, frame);
  } catch (const Diverged&) {
    return {};
  }
  for (std::size_t i = 0; i < scene.count(); ++i)
    if (scene.is_dynamic(i) && !(frame.position[i].allFinite() && frame.velocity[i].allFinite())) return {};
  return seconds;
}

void run(const std::string& input, const std::string& output, Settings settings, bool single, const MakeEngine& make) {
  const FrameReader reader(input);
  const Bodies scene = reader.bodies();
  Frame frame;
  reader.read(reader.frames().front(), frame);
  if (settings.tied != 0) settings.chain = chain_anchors(scene, frame);
  const auto engine = make(scene, frame, settings);

  FrameWriter writer(output, scene, single);
  writer.write(0, frame);
  std::vector<double> seconds;
  for (long f = 1; f <= settings.frames; ++f) {
    const auto took = advance(*engine, scene, settings, frame);
    if (!took) {
      std::printf("diverged_frame %ld\n", f);
      return;
    }
    seconds.push_back(*took);
    writer.write(f, frame);
  }
  std::sort(seconds.begin(), seconds.end());
  std::printf("median_ms %.4f\n", 1e3 * seconds[seconds.size() / 2]);
}

}  // namespace

int drive(int argc, char** argv, const char* name, bool single, const MakeEngine& make) {
  try {
    if (argc < 3) throw std::runtime_error("two files are needed, INPUT.h5 OUTPUT.h5, then options: --iterations N, ...");
    run(argv[1], argv[2], parse(argc, argv), single, make);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace rivals
