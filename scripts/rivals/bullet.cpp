// Runs Bullet from the first frame of a frames.h5 and records its frames in the same format.
//   bullet INPUT.h5 OUTPUT.h5 [--iterations 10] [--substeps 1] [--frames 400] [--step 0.016] [--friction 0.3] [--gravity 9.8]
// Prints the median CPU time of a frame's stepSimulation calls alone; writing is not timed.
//
// Bullet is left at its defaults (erp2 .2, split impulse, warm start .85, contacts kept to 2 cm) but for: no sleeping, no
// damping, restitution 0. It multiplies the friction of two bodies, so each has the root of the pair's. Half spaces are
// static boxes, thick ones. Margins are the defaults: a box keeps its size, the margin of min(4 cm, a tenth of the smallest half
// edge) lies inside; a sphere is all margin.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bodies.hpp"

namespace {

using rivals::Bodies;
using rivals::Frame;
using rivals::Shape;

btVector3 to_bullet(const rivals::Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
rivals::Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform pose(const Frame& frame, std::size_t i) {
  const auto& q = frame.orientation[i];
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
                                  static_cast<btScalar>(q.w())),
                     to_bullet(frame.position[i]));
}

struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;

  World(const Bodies& scene, const Frame& start, double friction) {
    double extent = 10;  // m, half width of the boxes that stand for half spaces
    for (std::size_t i = 0; i < scene.count(); ++i)
      if (scene.shape[i] != Shape::plane) extent = std::max(extent, 2 * start.position[i].norm());
    std::map<std::vector<double>, btCollisionShape*> known;  // equal bodies share their shape
    for (std::size_t i = 0; i < scene.count(); ++i) {
      if (scene.motion[i] == rivals::Motion::kinematic) throw std::runtime_error("kinematic bodies are not carried over");
      btTransform at = pose(start, i);
      rivals::Vec3 size = scene.size[i];
      if (scene.shape[i] == Shape::plane) {
        size = {extent, extent, 1};
        at.setOrigin(at * btVector3(0, 0, -1));
      }
      auto& shape = known[{static_cast<double>(scene.shape[i]), size.x(), size.y(), size.z()}];
      if (shape == nullptr) shape = make_shape(scene.shape[i], size);
      add(shape, at, scene, start, i, std::sqrt(friction));
    }
  }

  ~World() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }

  btCollisionShape* make_shape(Shape shape, const rivals::Vec3& size) {
    if (shape == Shape::disc) throw std::runtime_error("discs are not carried over");
    if (shape == Shape::sphere)
      shapes.push_back(std::make_unique<btSphereShape>(static_cast<btScalar>(size.x())));
    else
      shapes.push_back(std::make_unique<btBoxShape>(to_bullet(size)));
    return shapes.back().get();
  }

  void add(btCollisionShape* shape, const btTransform& at, const Bodies& scene, const Frame& start, std::size_t i,
           double friction) {
    const bool moves = scene.is_dynamic(i);
    btRigidBody::btRigidBodyConstructionInfo info(moves ? static_cast<btScalar>(scene.mass[i]) : 0, nullptr, shape,
                                                  moves ? to_bullet(scene.inertia[i]) : btVector3(0, 0, 0));
    info.m_startWorldTransform = at;
    info.m_friction = static_cast<btScalar>(friction);
    info.m_restitution = 0;
    info.m_linearDamping = info.m_angularDamping = 0;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    auto& body = *bodies.back();
    if (moves) {
      body.setLinearVelocity(to_bullet(start.velocity[i]));
      body.setAngularVelocity(to_bullet(start.angular_velocity[i]));
      body.setActivationState(DISABLE_DEACTIVATION);
    }
    world.addRigidBody(&body);
  }

  // Half spaces keep their pose in the file, whatever box stands for them.
  void read(const Bodies& scene, Frame& frame) const {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!scene.is_dynamic(i)) continue;
      const auto& at = bodies[i]->getWorldTransform();
      const auto q = at.getRotation();
      frame.position[i] = from_bullet(at.getOrigin());
      frame.orientation[i] = rivals::Quat(q.w(), q.x(), q.y(), q.z());
      frame.velocity[i] = from_bullet(bodies[i]->getLinearVelocity());
      frame.angular_velocity[i] = from_bullet(bodies[i]->getAngularVelocity());
    }
  }
};

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Settings {
  int iterations = 10, substeps = 1;
  long frames = 400;
  double step = 0.016, friction = 0.3, gravity = 9.8;
};

Settings parse(int argc, char** argv) {
  Settings s;
  for (int i = 3; i < argc; i += 2) {
    const std::string key = argv[i];
    if (i + 1 >= argc) throw std::runtime_error("'" + key + "' needs a value");
    const char* value = argv[i + 1];
    if (key == "--iterations")
      s.iterations = std::atoi(value);
    else if (key == "--substeps")
      s.substeps = std::atoi(value);
    else if (key == "--frames")
      s.frames = std::atol(value);
    else if (key == "--step")
      s.step = std::atof(value);
    else if (key == "--friction")
      s.friction = std::atof(value);
    else if (key == "--gravity")
      s.gravity = std::atof(value);
    else
      throw std::runtime_error("unknown option '" + key + "'");
  }
  if (s.iterations < 1 || s.substeps < 1 || s.frames < 1 || s.step <= 0) throw std::runtime_error("a setting is not positive");
  return s;
}

void run(const std::string& input, const std::string& output, const Settings& settings) {
  const rivals::FrameReader reader(input);
  const Bodies scene = reader.bodies();
  Frame frame;
  reader.read(reader.frames().front(), frame);

  World bullet(scene, frame, settings.friction);
  bullet.world.setGravity({0, 0, static_cast<btScalar>(-settings.gravity)});
  bullet.world.getSolverInfo().m_numIterations = settings.iterations;

  rivals::FrameWriter writer(output, scene, sizeof(btScalar) == 4);
  writer.write(0, frame);
  const auto step = static_cast<btScalar>(settings.step / settings.substeps);
  std::vector<double> seconds;
  for (long f = 1; f <= settings.frames; ++f) {
    const double begin = cpu_seconds();
    for (int s = 0; s < settings.substeps; ++s) bullet.world.stepSimulation(step, 0);
    seconds.push_back(cpu_seconds() - begin);
    bullet.read(scene, frame);
    writer.write(f, frame);
  }
  std::sort(seconds.begin(), seconds.end());
  std::printf("median_ms %.4f\n", 1e3 * seconds[seconds.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 3) throw std::runtime_error("usage: bullet INPUT.h5 OUTPUT.h5 [--iterations N] [--substeps N] [--frames N] ...");
    run(argv[1], argv[2], parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bullet: %s\n", error.what());
    return 1;
  }
  return 0;
}
