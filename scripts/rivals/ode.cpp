// Runs the Open Dynamics Engine from the first frame of a frames.h5 and records its frames in the same format: options in
// driver.hpp.
//
// Quickstep with N iterations (--direct 1: dWorldStep, which factorises), ODE's defaults for error reduction (.2) and constraint
// force mixing, friction pyramid along the directions of motion (dContactApprox1), up to 8 contacts a pair, a hash space; no
// sleeping, no damping, restitution 0.
#include <ode/ode.h>

#include <stdexcept>

#include "driver.hpp"

namespace {

using rivals::Bodies;
using rivals::Frame;
using rivals::Shape;

struct World : rivals::Engine {
  dWorldID world = nullptr;
  dSpaceID space = nullptr;
  dJointGroupID contacts = nullptr;
  std::vector<dBodyID> bodies;
  double friction;
  bool direct;

  World(const Bodies& scene, const Frame& start, const rivals::Settings& settings)
      : friction(settings.friction), direct(settings.direct != 0) {
    dInitODE2(0);
    world = dWorldCreate();
    space = dHashSpaceCreate(nullptr);
    contacts = dJointGroupCreate(0);
    dWorldSetGravity(world, 0, 0, static_cast<dReal>(-settings.gravity));
    dWorldSetQuickStepNumIterations(world, settings.iterations);
    dWorldSetAutoDisableFlag(world, 0);
    for (std::size_t i = 0; i < scene.count(); ++i) add(scene, start, i, settings.chain.empty());
    for (const rivals::Anchor& j : settings.chain) {
      const dJointID joint = dJointCreateBall(world, nullptr);
      const auto b = static_cast<std::size_t>(j.b);
      dJointAttach(joint, j.a < 0 ? nullptr : bodies[static_cast<std::size_t>(j.a)], bodies[b]);
      const rivals::Vec3 at = start.position[b] + start.orientation[b] * j.in_b;
      dJointSetBallAnchor(joint, at.x(), at.y(), at.z());
    }
  }

  ~World() override {
    dJointGroupDestroy(contacts);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    dCloseODE();
  }

  void add(const Bodies& scene, const Frame& start, std::size_t i, bool touches) {
    const rivals::Vec3 &x = start.position[i], &size = scene.size[i];
    const rivals::Quat& q = start.orientation[i];
    dGeomID geom = nullptr;
    if (touches && scene.shape[i] == Shape::plane) {
      const rivals::Vec3 n = q * rivals::Vec3::UnitZ();
      dCreatePlane(space, n.x(), n.y(), n.z(), n.dot(x));
    } else if (touches && scene.shape[i] == Shape::sphere) {
      geom = dCreateSphere(space, size.x());
    } else if (touches && scene.shape[i] == Shape::box) {
      geom = dCreateBox(space, 2 * size.x(), 2 * size.y(), 2 * size.z());
    } else if (touches) {
      throw std::runtime_error("only spheres, boxes and planes are carried over");
    }
    bodies.push_back(nullptr);
    const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
    if (!scene.is_dynamic(i)) {
      if (geom != nullptr) dGeomSetPosition(geom, x.x(), x.y(), x.z()), dGeomSetQuaternion(geom, turn);
      return;
    }
    const dBodyID body = bodies.back() = dBodyCreate(world);
    const rivals::Vec3 &v = start.velocity[i], &w = start.angular_velocity[i], &inertia = scene.inertia[i];
    dBodySetPosition(body, x.x(), x.y(), x.z());
    dBodySetQuaternion(body, turn);
    dBodySetLinearVel(body, v.x(), v.y(), v.z());
    dBodySetAngularVel(body, w.x(), w.y(), w.z());
    dMass mass;
    dMassSetParameters(&mass, scene.mass[i], 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
    dBodySetMass(body, &mass);
    if (geom != nullptr) dGeomSetBody(geom, body);
  }

  static void near(void* data, dGeomID a, dGeomID b) {
    auto& self = *static_cast<World*>(data);
    const dBodyID first = dGeomGetBody(a), second = dGeomGetBody(b);
    if (first == nullptr && second == nullptr) return;
    dContact contact[8];
    const int count = dCollide(a, b, 8, &contact[0].geom, sizeof(dContact));
    for (int k = 0; k < count; ++k) {
      contact[k].surface.mode = dContactApprox1;
      contact[k].surface.mu = self.friction;
      dJointAttach(dJointCreateContact(self.world, self.contacts, &contact[k]), first, second);
    }
  }

  void step(double dt) override {
    dSpaceCollide(space, this, &near);
    direct ? dWorldStep(world, dt) : dWorldQuickStep(world, dt);
    dJointGroupEmpty(contacts);
  }

  void read(const Bodies&, Frame& frame) const override {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i] == nullptr) continue;
      const dReal *x = dBodyGetPosition(bodies[i]), *q = dBodyGetQuaternion(bodies[i]);
      const dReal *v = dBodyGetLinearVel(bodies[i]), *w = dBodyGetAngularVel(bodies[i]);
      frame.position[i] = {x[0], x[1], x[2]};
      frame.orientation[i] = rivals::Quat(q[0], q[1], q[2], q[3]);
      frame.velocity[i] = {v[0], v[1], v[2]};
      frame.angular_velocity[i] = {w[0], w[1], w[2]};
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  return rivals::drive(argc, argv, "ode", sizeof(dReal) == 4,
                       [](const auto&... of) -> std::unique_ptr<rivals::Engine> { return std::make_unique<World>(of...); });
}
