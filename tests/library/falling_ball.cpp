// Steps a scene by the library, on as many MPI processes as there are: a ball falls onto a plane, on which a probe tells the
// force. usage: falling_ball [SCENE FRAMES]   prints the state hash of that scene after so many frames instead
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <unibody/unibody.hpp>

namespace {

namespace ub = unibody::api;

const char* const falling =
    "time: {frame: 0.01, frames: 100}\n"
    "gravity: [0, 0, -10]\n"
    "bodies:\n"
    "  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n"
    "  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.6]}\n"
    "probes:\n"
    "  - {name: floor, force: {on: floor}}\n";

int failures = 0;
void expect(bool good, const char* what) {
  if (!good) ++failures, std::fprintf(stderr, "not so: %s\n", what);
}

int run_scene(const char* path, int frames) {
  ub::Simulation simulation(MPI_COMM_WORLD, ub::Scene::from_file(path, {{"time.frames", std::to_string(frames)}}));
  while (simulation.time() < frames * simulation.step_length() - 1e-12) simulation.step();
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::string hash = simulation.state_hash();
  if (rank == 0) std::printf("state %s\n", hash.c_str());
  return 0;
}

int drop() {
  const ub::Scene scene = ub::Scene::from_text(falling, ".", {{"bodies[1].mass", "3"}});
  const auto ball = scene.ids("ball");
  expect(scene.body_count() == 2 && ball.size() == 1 && ball[0] == 1, "the ball is body 1");
  ub::Simulation simulation(MPI_COMM_WORLD, scene);
  simulation.step(10);  // 1 m/s; 0.05 m and what the steps add
  expect(std::abs(simulation.all(ub::Field::velocity)[5] + 1) < 1e-12, "it falls with g t");
  simulation.write_checkpoint("ball.h5");
  simulation.step(90);
  const auto force = simulation.probe("floor");
  expect(force[2].first == "force_z (N)" && std::abs(force[2].second + 30) < 0.3, "the floor bears its weight");
  expect(simulation.report().size() == 100 && simulation.report().back().step == 100, "a row a step");
  const std::string end = simulation.state_hash();
  simulation.restore("ball.h5");
  expect(simulation.steps_done() == 10, "the checkpoint is of step 10");
  simulation.step(90);
  expect(simulation.state_hash() == end, "restored, it ends the same");
  const double up[3] = {0, 0, 40};
  simulation.apply_forces(ball, up);
  simulation.step();
  expect(simulation.all(ub::Field::velocity)[5] > 0, "a force lifts it");
  try {
    ub::Scene::from_text("bodies: [{shape: {sphere: {radius: -1}}}]");
    expect(false, "a bad scene is refused");
  } catch (const ub::InputError& error) {
    expect(std::string(error.what()).find("radius") != std::string::npos, "the error names the key");
  }
  return failures;
}

}  // namespace

int main(int argc, char** argv) {
  const ub::Session session(&argc, &argv);
  return argc == 3 ? run_scene(argv[1], std::atoi(argv[2])) : drop();
}
