// Runs Bullet from the first frame of a frames.h5 and records its frames in the same format: options in driver.hpp.
//
// Bullet is left at its defaults (erp2 .2 unless --erp2 says otherwise, split impulse, warm start .85, contacts kept to 2 cm) but
// for: no sleeping, no damping, restitution 0. It multiplies the friction of two bodies, so each has the root of the pair's. Half
// spaces are static boxes, thick and wide ones: its own plane finds one point of a box in a step. Margins are the defaults: a box
// keeps its size, the margin of min(4 cm, a tenth of the smallest half edge) lies inside; a sphere is all margin. Joints of a
// chain are point-to-point constraints.
#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "driver.hpp"

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

struct World : rivals::Engine {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;

  World(const Bodies& scene, const Frame& start, const rivals::Settings& settings) {
    world.setGravity({0, 0, static_cast<btScalar>(-settings.gravity)});
    world.getSolverInfo().m_numIterations = settings.iterations;
    world.getSolverInfo().m_erp2 = static_cast<btScalar>(settings.erp2);
    world.getSimulationIslandManager()->setSplitIslands(settings.split != 0);
    std::map<std::vector<double>, btCollisionShape*> known;  // equal bodies share their shape
    for (std::size_t i = 0; i < scene.count(); ++i) {
      if (scene.motion[i] == rivals::Motion::kinematic) throw std::runtime_error("kinematic bodies are not carried over");
      btTransform at = pose(start, i);
      rivals::Vec3 size = scene.size[i];
      if (scene.shape[i] == Shape::plane) {
        size = {rivals::wide, rivals::wide, 1};
        at.setOrigin(at * btVector3(0, 0, -1));
      }
      auto& shape = known[{static_cast<double>(scene.shape[i]), size.x(), size.y(), size.z()}];
      if (shape == nullptr) shape = make_shape(scene.shape[i], size);
      add(shape, at, scene, start, i, std::sqrt(settings.friction));
    }
    for (const rivals::Anchor& j : settings.chain) {
      auto& b = *bodies[static_cast<std::size_t>(j.b)];
      if (j.a < 0)
        joints.push_back(std::make_unique<btPoint2PointConstraint>(b, to_bullet(j.in_b)));
      else
        joints.push_back(std::make_unique<btPoint2PointConstraint>(*bodies[static_cast<std::size_t>(j.a)], b, to_bullet(j.in_a),
                                                                   to_bullet(j.in_b)));
      world.addConstraint(joints.back().get(), true);
    }
  }

  ~World() override {
    for (const auto& joint : joints) world.removeConstraint(joint.get());
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

  void step(double dt) override { world.stepSimulation(static_cast<btScalar>(dt), 0); }

  // Half spaces keep their pose in the file, whatever box stands for them.
  void read(const Bodies& scene, Frame& frame) const override {
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

}  // namespace

int main(int argc, char** argv) {
  return rivals::drive(argc, argv, "bullet", sizeof(btScalar) == 4,
                       [](const auto&... of) -> std::unique_ptr<rivals::Engine> { return std::make_unique<World>(of...); });
}
