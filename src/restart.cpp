#include "restart.hpp"

#include <algorithm>
#include <sstream>

#include "build.hpp"
#include "report/checkpoint.hpp"

namespace unibody {

namespace {

// How the bodies are moved: steps and solver. With -start_from it may differ from that of the checkpoint's run.
std::string settings_of(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  const SolverSettings& s = scene.solver;
  text << scene.time.step << ' ' << scene.time.substeps << ' ' << s.name << ' ' << s.iterations << ' ' << s.tolerance << ' '
       << static_cast<int>(s.stages) << ' ' << s.warm_start << ' ' << s.velocity_share << ' ' << s.leak << ' '
       << static_cast<int>(s.friction) << ' ' << static_cast<int>(s.gap) << ' ' << static_cast<int>(s.form) << ' '
       << static_cast<int>(s.order) << ' ' << s.scaling << ' ' << s.recovery_time << ' ' << s.recovery_speed << ' ' << s.margin
       << '\n';
  if (s.acceleration != Acceleration::automatic) text << "acceleration " << static_cast<int>(s.acceleration) << '\n';
  if (s.mass_sharing != MassSharing::directions) text << "mass sharing " << static_cast<int>(s.mass_sharing) << '\n';
  if (s.joints == JointSolve::direct) text << "trees\n";
  if (s.level == Level::velocity) text << "velocity level " << s.stabilisation << '\n';
  return text.str();
}

// A body at the start: a checkpoint holds all of it, so that another one in the scene would be of no effect.
void add_body(const Body& body, std::ostringstream& text) {
  const BodyProperties& p = body.properties;
  const BodyState& s = body.state;
  text << static_cast<int>(p.shape.kind) << ' ' << p.shape.data << ' ' << static_cast<int>(p.motion) << ' ' << p.material << ' '
       << p.mass;
  for (const Vec3& v : {p.shape.size, p.inertia, p.force, p.torque, s.position, s.velocity, s.angular_velocity})
    text << ' ' << v.transpose();
  text << ' ' << s.orientation.coeffs().transpose() << '\n';
}

// What is moved.
std::string physics_of(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  text << scene.gravity.transpose() << ' ' << scene.planar << '\n';
  for (const std::string& material : scene.materials) text << material << ' ';
  for (const double mu : scene.friction) text << mu << ' ';
  for (const auto& [what, values] :
       {std::pair("bounce", &scene.restitution), {"roll", &scene.rolling}, {"spin", &scene.spinning}})
    if (has_any(*values))
      for (const double value : *values) text << what << ' ' << value << '\n';
  for (const BodyGroup& group : scene.groups) {
    text << group.name << ' ' << group.count << ' ' << group.is_static << '\n';
    for (const Id k : {Id{0}, group.count / 2, group.count - 1}) add_body(group.make(k), text);
  }
  text << "air " << scene.wind.transpose() << ' ' << scene.air_density << '\n';
  for (const Surface& surface : scene.surfaces) text << "drag " << surface.drag << ' ' << surface.self_collision << '\n';
  for (const Pin& pin : scene.pins) text << "pin " << pin.id << ' ' << pin.release << ' ' << pin.body << '\n';
  for (const Attachment& a : scene.attachments) text << "tie " << a.node << ' ' << a.body << ' ' << a.release << '\n';
  for (const Joint& j : scene.joints) {
    text << "joint " << static_cast<int>(j.kind) << ' ' << j.collide << ' ' << j.ids[0] << ' ' << j.ids[1] << ' ' << j.compliance
         << ' ' << j.turning << ' ' << j.damping << ' ' << j.length << ' ' << j.lower << ' ' << j.upper << ' ' << j.swing << ' '
         << static_cast<int>(j.motor) << ' ' << j.target << ' ' << j.strength << ' ' << j.friction;
    for (std::size_t e = 0; e < 2; ++e) text << ' ' << j.anchor[e].transpose() << ' ' << j.frame[e].coeffs().transpose();
    text << '\n';
  }
  for (const ConstraintGroup& group : scene.constraint_groups)  // all of a group follow one law: two bodies show it
    for (const Id id : {group.first, group.first + group.count / 2}) {
      ConstraintSet constraints;
      group.touching(id, constraints);
      for_each_type(constraints, [&](auto, const auto& list) {
        for (const auto& c : list) {
          for (const Id i : c.ids) text << i << ' ';
          for (const double p : c.parameters) text << p << ' ';
          for (const double e : c.compliance) text << e << ' ';
          text << c.damping << '\n';
        }
      });
    }
  return text.str();
}

}  // namespace

std::string mark_of(const Scene& scene, bool with_settings) {
  return fingerprint(physics_of(scene)) + (with_settings ? fingerprint(settings_of(scene)) : "");
}

std::int64_t restore(MPI_Comm comm, const Scene& scene, const Options& options, Simulation& simulation) {
  const Checkpoint checkpoint(comm, options.restart, mark_of(scene, !options.other_settings));
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const Id begin = checkpoint.body_count() * rank / size, end = checkpoint.body_count() * (rank + 1) / size;
  std::vector<Body> homes, statics;
  for (const BodyGroup& group : scene.groups) {
    const Id first = group.is_static ? group.first : std::max(group.first, begin);
    const Id last = group.is_static ? group.first + group.count : std::min(group.first + group.count, end);
    if (first >= last) continue;
    auto& to = group.is_static ? statics : homes;
    const auto bodies = checkpoint.read_bodies(first, last);
    to.insert(to.end(), bodies.begin(), bodies.end());
  }
  simulation.world = make_world(homes, statics, scene.has_rotations());
  simulation.multipliers = checkpoint.read_multipliers(simulation.world);
  simulation.make_constraints();
  simulation.constraint_multipliers = checkpoint.read_constraint_multipliers(simulation.constraints);
  simulation.joint_impulses = checkpoint.read_joint_impulses(simulation.joints);
  return checkpoint.frame();
}

}  // namespace unibody
