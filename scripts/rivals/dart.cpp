// Runs DART from the first frame of a frames.h5 and records its frames in the same format: options in driver.hpp.
//
// Contacts by its Bullet detector; the boxed complementarity problem by projected Gauss-Seidel with N iterations (--direct 1:
// Dantzig's pivoting, its default, with that as fallback). Half spaces are thick and wide static boxes. A chain is one
// articulated body in reduced coordinates, whose ball joints cannot open. No damping, restitution 0.
#include <dart/collision/bullet/bullet.hpp>
#include <dart/dart.hpp>
#include <stdexcept>

#include "driver.hpp"

namespace {

using rivals::Bodies;
using rivals::Frame;
using rivals::Shape;
using namespace dart::dynamics;

struct World : rivals::Engine {
  dart::simulation::WorldPtr world = dart::simulation::World::create();
  std::vector<BodyNode*> bodies;
  bool tied;

  World(const Bodies& scene, const Frame& start, const rivals::Settings& settings) : tied(!settings.chain.empty()) {
    world->setGravity({0, 0, -settings.gravity});
    auto pgs = std::make_shared<dart::constraint::PgsBoxedLcpSolver>();
    pgs->setOption(dart::constraint::PgsBoxedLcpSolver::Option(settings.iterations, 0, 0));
    std::unique_ptr<dart::constraint::ConstraintSolver> solver;
    if (settings.direct != 0)
      solver = std::make_unique<dart::constraint::BoxedLcpConstraintSolver>(
          std::make_shared<dart::constraint::DantzigBoxedLcpSolver>(), pgs);
    else
      solver = std::make_unique<dart::constraint::BoxedLcpConstraintSolver>(pgs, nullptr);
    world->setConstraintSolver(std::move(solver));
    using dart::constraint::ContactConstraint;
    if (settings.erp >= 0) ContactConstraint::setErrorReductionParameter(settings.erp);
    if (settings.erv >= 0) ContactConstraint::setMaxErrorReductionVelocity(settings.erv);
    world->getConstraintSolver()->setCollisionDetector(dart::collision::BulletCollisionDetector::create());
    bodies.assign(scene.count(), nullptr);
    if (tied)
      chain(scene, start, settings.chain);
    else
      free_bodies(scene, start, settings.friction);
  }

  static Eigen::Isometry3d pose(const Frame& frame, std::size_t i) {
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    at.translation() = frame.position[i], at.linear() = frame.orientation[i].toRotationMatrix();
    return at;
  }

  static Inertia inertia(const Bodies& scene, std::size_t i) {
    return {scene.mass[i], Eigen::Vector3d::Zero(), Eigen::Matrix3d(scene.inertia[i].asDiagonal())};
  }

  void free_bodies(const Bodies& scene, const Frame& start, double friction) {
    for (std::size_t i = 0; i < scene.count(); ++i) {
      const auto skeleton = Skeleton::create("body" + std::to_string(i));
      Eigen::Isometry3d at = pose(start, i);
      rivals::Vec3 size = 2 * scene.size[i];
      if (scene.shape[i] == Shape::plane) size = {2 * rivals::wide, 2 * rivals::wide, 2}, at.translation() -= at.linear().col(2);
      ShapePtr shape;
      if (scene.shape[i] == Shape::disc) throw std::runtime_error("discs are not carried over");
      if (scene.shape[i] == Shape::sphere)
        shape = std::make_shared<SphereShape>(scene.size[i].x());
      else
        shape = std::make_shared<BoxShape>(size);
      if (scene.is_dynamic(i)) {
        const auto [joint, body] = skeleton->createJointAndBodyNodePair<FreeJoint>();
        body->setInertia(inertia(scene, i));
        joint->setTransform(at);
        joint->setLinearVelocity(start.velocity[i]);
        joint->setAngularVelocity(start.angular_velocity[i]);
        bodies[i] = body;
        touch(body, shape, friction);
      } else {
        const auto [joint, body] = skeleton->createJointAndBodyNodePair<WeldJoint>();
        joint->setTransformFromParentBodyNode(at);
        touch(body, shape, friction);
      }
      world->addSkeleton(skeleton);
    }
  }

  static void touch(BodyNode* body, const ShapePtr& shape, double friction) {
    auto* node = body->createShapeNodeWith<CollisionAspect, DynamicsAspect>(shape);
    node->getDynamicsAspect()->setFrictionCoeff(friction);
    node->getDynamicsAspect()->setRestitutionCoeff(0);
  }

  void chain(const Bodies& scene, const Frame& start, const std::vector<rivals::Anchor>& anchors) {
    const auto skeleton = Skeleton::create("chain");
    for (const rivals::Anchor& j : anchors) {
      const auto b = static_cast<std::size_t>(j.b);
      BodyNode* parent = j.a < 0 ? nullptr : bodies[static_cast<std::size_t>(j.a)];
      const auto [joint, body] = skeleton->createJointAndBodyNodePair<BallJoint>(
          parent, BallJoint::Properties(Joint::Properties("joint" + std::to_string(b))),
          BodyNode::AspectProperties("body" + std::to_string(b)));
      Eigen::Isometry3d from_parent = Eigen::Isometry3d::Identity(), from_child = Eigen::Isometry3d::Identity();
      from_parent.translation() = j.in_a, from_child.translation() = j.in_b;
      const rivals::Quat q =
          j.a < 0 ? start.orientation[b] : start.orientation[static_cast<std::size_t>(j.a)].conjugate() * start.orientation[b];
      from_parent.linear() = q.toRotationMatrix();  // so that the joint's position is 0 at the start
      joint->setTransformFromParentBodyNode(from_parent);
      joint->setTransformFromChildBodyNode(from_child);
      body->setInertia(inertia(scene, b));
      bodies[b] = body;
    }
    world->addSkeleton(skeleton);
  }

  void step(double dt) override {
    world->setTimeStep(dt);
    world->step();
    // A chain that diverges would trip an assertion: its speeds square from step to step, so 1e6 rad/s is not missed.
    constexpr double too_fast = 1e6;
    if (tied && !(world->getSkeleton(0)->getVelocities().cwiseAbs().maxCoeff() < too_fast)) throw rivals::Diverged();
  }

  void read(const Bodies& scene, Frame& frame) const override {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!scene.is_dynamic(i)) continue;
      const Eigen::Isometry3d at = bodies[i]->getTransform();
      frame.position[i] = at.translation();
      frame.orientation[i] = rivals::Quat(at.linear());
      frame.velocity[i] = bodies[i]->getLinearVelocity();
      frame.angular_velocity[i] = bodies[i]->getAngularVelocity();
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  return rivals::drive(argc, argv, "dart", false,
                       [](const auto&... of) -> std::unique_ptr<rivals::Engine> { return std::make_unique<World>(of...); });
}
