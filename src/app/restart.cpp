#include "app/restart.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <sstream>

#include "changes/changes.hpp"
#include "checkpoint/checkpoint.hpp"
#include "core/agreement.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "scene/settings.hpp"
#include "step/build.hpp"

namespace unibody {

namespace {

// How the bodies are moved: steps and solver. With -start_from it may differ from that of the checkpoint's run.
std::string settings_of(const Scene& scene) {
  TimeSettings time = scene.time;
  time.frames = 0;  // a run may go on for longer
  return text_of(time_settings(), time) + text_of(solver_settings(), scene.solver);
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

// What changes the scene while it runs; nothing where nothing does.
void add_comings(const Scene& scene, std::ostringstream& text) {
  for (const BodyGroup& group : scene.groups) {
    if (group.start != Start::present) text << "start " << group.first << ' ' << static_cast<int>(group.start) << '\n';
    if (const Inlet* inlet = group.inlet.get()) {
      text << "inlet " << inlet->rate.text() << ' ' << inlet->by_mass << ' ' << inlet->from << ' ' << inlet->until << '\n';
      for (const Id k : {Id{0}, group.count - 1}) add_body(inlet->place(k, 1), text);
    }
  }
  for (const Outlet& o : scene.outlets)
    text << "outlet " << o.low.transpose() << ' ' << o.high.transpose() << ' ' << o.bodies.first << ' ' << o.bodies.end << ' '
         << o.bodies.material << '\n';
  for (const Event& event : scene.events) {
    text << "event " << static_cast<int>(event.action) << ' ' << event.time << ' ' << event.value.text();
    if (event.when)
      text << ' ' << event.when->column << ' ' << event.when->above << ' ' << event.when->value << ' ' << event.when->after;
    for (const std::vector<std::size_t>* numbers : {&event.groups, &event.joints})
      for (const std::size_t number : *numbers) text << ' ' << number;
    text << ' ' << event.materials[0] << ' ' << event.materials[1] << '\n';
  }
}

// Everything that a run moves, as text.
std::string physics_of(const Scene& scene) {
  std::ostringstream text;
  text.precision(17);
  text << scene.gravity.transpose() << ' ' << scene.planar << '\n';
  if (scene.period.any()) text << "periodic " << scene.period.lower.transpose() << ' ' << scene.period.length.transpose() << '\n';
  if (scene.gravity_in_time) text << "gravity " << scene.gravity_in_time->text() << '\n';
  for (const std::string& material : scene.materials) text << material << ' ';
  for (const double mu : scene.friction) text << mu << ' ';
  if (scene.friction_in_time) text << "friction " << scene.friction_in_time->text() << '\n';
  for (std::size_t k = 0; k < pair_value_types.size(); ++k)
    if (scene.pairs.any(static_cast<PairValue>(k)))
      for (const double value : scene.pairs.values[k]) text << pair_value_types[k].mark << ' ' << value << '\n';
  for (const BodyGroup& group : scene.groups) {
    text << group.name << ' ' << group.count << ' ' << group.is_static << '\n';
    for (const Id k : {Id{0}, group.count / 2, group.count - 1}) add_body(group.make(k), text);
    if (const MotionInTime* motion = group.motion.get())
      text << "moves " << (motion->path ? "along " + motion->path->text() : motion->velocity.text()) << " turns "
           << motion->angular_velocity.text() << '\n';
  }
  for (const BodyGroup& group : scene.groups)
    if (group.load) text << "load " << group.first << ' ' << group.load->force.text() << ' ' << group.load->torque.text() << '\n';
  for (const BodyGroup& group : scene.groups)
    if (const SurfaceMotionInTime* motion = group.surface_motion.get())
      text << "belt " << group.first << ' ' << motion->velocity.text() << ' ' << motion->angular_velocity.text() << '\n';
  for (const BodyGroup& group : scene.groups)
    if (group.friction)
      text << "anisotropic friction " << group.first << ' ' << group.friction->axis.transpose() << ' ' << group.friction->across
           << '\n';
  add_comings(scene, text);
  text << "air ";
  if (scene.wind.changes())
    text << scene.wind.text();
  else
    text << scene.wind.at(0).transpose();
  text << ' ' << scene.air_density << '\n';
  for (const PartLoad& load : scene.part_loads) {
    text << "part load " << load.force.text();
    for (const auto& [node, share] : load.shares) text << ' ' << node << ' ' << share;
    text << '\n';
  }
  for (const Surface& surface : scene.surfaces) {
    text << "drag " << surface.drag << ' ' << surface.self_collision << '\n';
    if (surface.pressure.largest() > 0) text << "pressure " << surface.pressure.text() << '\n';
  }
  for (const Pin& pin : scene.pins) text << "pin " << pin.id << ' ' << pin.release << ' ' << pin.body << '\n';
  for (const Attachment& a : scene.attachments) text << "tie " << a.node << ' ' << a.body << ' ' << a.release << '\n';
  if (scene.touch_rules.any())
    for (const TouchRules::Class& c : scene.touch_rules.classes())
      text << "touches " << c.first << ' ' << c.is << ' ' << c.touches << '\n';
  for (const Joint& j : scene.joints) {
    text << "joint " << static_cast<int>(j.kind) << ' ' << j.collide << ' ' << j.ids[0] << ' ' << j.ids[1] << ' ' << j.compliance
         << ' ' << j.turning << ' ' << j.damping << ' ' << j.length << ' ' << j.lower << ' ' << j.upper << ' ' << j.swing << ' '
         << static_cast<int>(j.motor) << ' ' << j.target.text() << ' ' << j.strength.text() << ' ' << j.friction;
    if (j.area)
      for (const PressedArea::Length& length : j.area->lengths) text << " presses on " << length.at_start << ' ' << length.slider;
    for (std::size_t e = 0; e < 2; ++e) text << ' ' << j.anchor[e].transpose() << ' ' << j.frame[e].coeffs().transpose();
    if (const Strength& s = j.bears; s.any())
      text << " bears " << s.force << ' ' << s.torque << ' ' << s.tension << ' ' << s.shear << ' ' << s.bending << ' '
           << s.twisting << ' ' << s.duration;
    if (j.is_sprung()) text << " spring " << j.stiffness << ' ' << j.viscosity << ' ' << j.rest;
    text << '\n';
  }
  for (const Coupling& c : scene.couplings) text << "coupling " << c.joints[0] << ' ' << c.joints[1] << ' ' << c.ratio << '\n';
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

// What a body is does not change in a run: the file must say what the scene does. Its reals may have come from another machine's
// sines and roots.
// may_be_held: by an event, or from the start until one.
void check_same_body(const std::string& path, const Body& body, const Body& of_scene, std::span<const Pin> pins,
                     bool may_be_held) {
  const BodyProperties &p = body.properties, &q = of_scene.properties;
  const auto near = [](const Vec3& a, const Vec3& b) { return (a - b).norm() <= 1e-9 * (a.norm() + b.norm()); };
  const char* other = nullptr;
  if (p.shape.kind != q.shape.kind || p.shape.data != q.shape.data || !near(p.shape.size, q.shape.size)) other = "shape";
  const auto pin = std::lower_bound(pins.begin(), pins.end(), body.id, [](const Pin& a, Id id) { return a.id < id; });
  const bool is_held = p.motion == Motion::pinned && q.is_dynamic() && pin != pins.end() && pin->id == body.id;  // for now
  const bool holds_or_not = may_be_held && !p.is_static() && !q.is_static();
  if (p.motion != q.motion && !is_held && !holds_or_not) other = "motion";
  if (p.material != q.material) other = "material";
  if (p.group != q.group) other = "group";
  if (!near(p.force, q.force) || !near(p.torque, q.torque)) other = "force or torque";
  if (!q.is_static() && (std::abs(p.mass - q.mass) > 1e-9 * q.mass || !near(p.inertia, q.inertia))) other = "mass or inertia";
  if (other != nullptr)
    throw InputError("'" + path + "' is damaged: body " + std::to_string(body.id) + " has another " + other +
                     " than in the scene");
}

bool is_fixed_by_event(const Scene& scene, const BodyGroup& group) {
  const auto fixes = [&](const Event& event) {
    return event.action == Event::Action::fix &&
           std::ranges::any_of(event.groups, [&](std::size_t g) { return &scene.groups[g] == &group; });
  };
  return std::ranges::any_of(scene.events, fixes);
}

}  // namespace

std::string mark_of(const Scene& scene, bool with_settings) {
  return fingerprint(physics_of(scene)) + (with_settings ? fingerprint(settings_of(scene)) : "");
}

std::int64_t restore(MPI_Comm comm, Scene& scene, const Options& options, Simulation& simulation) {
  const Checkpoint checkpoint(comm, options.restart, mark_of(scene, !options.other_settings));
  if (checkpoint.body_count() != scene.body_count())
    throw InputError("'" + options.restart + "' is damaged: found " + std::to_string(checkpoint.body_count()) +
                     " bodies, expected the scene's " + std::to_string(scene.body_count()));
  if (!scene.bodies_come_and_go() && !checkpoint.has_all_bodies()) {
    agree<InputError>(comm, "", [&] { scene.lacks_bodies = checkpoint.outline().lacks_bodies; });
    if (!scene.lacks_bodies)
      throw InputError("'" + options.restart + "' is damaged: found a table of some of the scene's bodies, expected all of them");
  }
  int rank = 0, size = 1;
  check_mpi(MPI_Comm_rank(comm, &rank));
  check_mpi(MPI_Comm_size(comm, &size));
  const Id begin = checkpoint.body_count() * rank / size, end = checkpoint.body_count() * (rank + 1) / size;
  std::vector<Body> homes, statics;
  agree<InputError>(comm, "", [&] {
    for (const BodyGroup& group : scene.groups) {
      const Id first = group.is_static ? group.first : std::max(group.first, begin);
      const Id last = group.is_static ? group.first + group.count : std::min(group.first + group.count, end);
      if (first >= last) continue;
      auto& to = group.is_static ? statics : homes;
      const bool may_be_held = group.start == Start::held || is_fixed_by_event(scene, group);
      for (const Body& body : checkpoint.read_bodies(first, last)) {
        check_same_body(options.restart, body, group.make(body.id - group.first), scene.pins, may_be_held);
        to.push_back(body);
      }
    }
  });
  simulation.world = make_world(homes, statics, scene.has_rotations(), scene.period);
  simulation.history.contacts() = checkpoint.read_multipliers(simulation.world);
  simulation.make_constraints();
  start_past(scene, simulation.history);
  agree<InputError>(comm, "", [&] { checkpoint.read_histories(simulation.elements(), simulation.history); });
  return checkpoint.frame();
}

}  // namespace unibody
