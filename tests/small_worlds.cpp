#include "small_worlds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/scene_text.hpp"
#include "shortest_turn.hpp"

namespace unibody::small_worlds {

namespace {

Body solid(ShapeKind kind, const Vec3& size, double mass, const Vec3& position) {
  Body b;
  b.properties.shape = {kind, size};
  b.properties.mass = mass;
  b.properties.inertia = inertia(b.properties.shape, mass);
  b.state.position = position;
  return b;
}

Vec3 spin_momentum(const BodyProperties& body, const BodyState& s) {
  const Mat3 R = s.orientation.toRotationMatrix();
  return R * body.inertia.cwiseProduct(R.transpose() * s.angular_velocity);
}

}  // namespace

Body ball(double mass, double radius, const Vec3& position) {
  return solid(ShapeKind::sphere, Vec3(radius, 0, 0), mass, position);
}
Body block(double mass, const Vec3& edges, const Vec3& position, const Quat& turn) {
  Body b = solid(ShapeKind::box, 0.5 * edges, mass, position);
  b.state.orientation = turn;
  return b;
}
Body disc(double mass, double radius, const Vec3& position) { return solid(ShapeKind::disc, Vec3(radius, 0, 0), mass, position); }
Body ground(const Vec3& position, const Vec3& up) {
  Body b = solid(ShapeKind::plane, Vec3::Zero(), 1, position);
  b.properties.motion = Motion::fixed;
  b.state.orientation = shortest_turn(Vec3::UnitZ(), up);
  return b;
}

Body without_turning(Body body) {
  body.properties.inertia = Vec3::Constant(1e14 * body.properties.mass);
  return body;
}

Id add(Scene& scene, const Body& body) {
  BodyGroup group;
  group.first = scene.body_count();
  group.count = 1;
  group.is_static = body.properties.motion != Motion::dynamic;
  group.make = [body](Id) { return body; };
  scene.groups.push_back(group);
  return group.first;
}

Scene scene_with(double friction) {
  Scene scene;
  scene.friction = {friction};
  return scene;
}

Scene scene_from_text(const std::string& text) { return scene_from(text); }

Experiment::Experiment(Scene s, MPI_Comm comm)
    : scene(std::make_unique<Scene>(std::move(s))), clock(std::make_unique<PhaseClock>()) {
  simulation = std::make_unique<Simulation>(comm, *scene, *clock, true);
  simulation->world = build_world(comm, *scene);
  simulation->resolve_automatic_settings();
}

std::size_t Experiment::slot(Id id) const {
  const auto& ids = simulation->world.id;
  const auto it = std::find(ids.begin(), ids.end(), id);
  if (it == ids.end()) ADD_FAILURE() << "body " << id << " is not here";
  return static_cast<std::size_t>(it - ids.begin());
}

double Experiment::penetration() {
  simulation->detect();
  double worst = 0;
  for (const ContactPoint& p : simulation->contacts.points) worst = std::max(worst, -p.gap);
  return worst;
}

double Experiment::gap(Id a, Id b) {
  simulation->detect();
  double smallest = HUGE_VAL;
  for (const Manifold& m : simulation->contacts.manifolds)
    if (m.id_a == std::min(a, b) && m.id_b == std::max(a, b))
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p)
        smallest = std::min(smallest, simulation->contacts.points[p].gap);
  return smallest;
}

double Experiment::normal_force(Id a, Id b) const {
  double force = 0;
  const Multipliers& all = simulation->history.contacts();
  for (std::size_t m = 0; m < all.manifolds.size(); ++m)
    if (all.manifolds[m].id_a == std::min(a, b) && all.manifolds[m].id_b == std::max(a, b))
      for (const RememberedPoint& p : all.points_of(m)) force += p.normal;
  return force;
}

double Experiment::kinetic_energy() const {
  const World& w = simulation->world;
  double sum = 0;
  for (std::size_t i = 0; i < w.homes; ++i)
    sum += 0.5 * w.properties[i].mass * w.velocity[i].squaredNorm() +
           0.5 * w.angular_velocity_of(i).dot(spin_momentum(w.properties[i], w.state(i)));
  return sum;
}

double Experiment::energy() const {
  const World& w = simulation->world;
  double sum = kinetic_energy();
  for (std::size_t i = 0; i < w.homes; ++i) sum -= w.properties[i].mass * scene->gravity.dot(w.position[i]);
  return sum;
}

Vec3 Experiment::momentum() const {
  const World& w = simulation->world;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < w.homes; ++i) sum += w.properties[i].mass * w.velocity[i];
  return sum;
}

Vec3 Experiment::angular_momentum() const {
  const World& w = simulation->world;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < w.homes; ++i)
    sum += w.properties[i].mass * w.position[i].cross(w.velocity[i]) + spin_momentum(w.properties[i], w.state(i));
  return sum;
}

bool Experiment::finite() const {
  const World& w = simulation->world;
  for (std::size_t i = 0; i < w.homes; ++i)
    if (!w.position[i].allFinite() || !w.velocity[i].allFinite() || !w.angular_velocity_of(i).allFinite() ||
        !w.orientation_of(i).coeffs().allFinite())
      return false;
  return true;
}

void Bench::predict() {
  const std::size_t n = world.size();
  system.homes = world.homes, system.first_static = world.first_static();
  system.bodies.assign(n + 1, SolverBody{});
  system.inertia.assign(n + 1, InverseInertia{});
  system.isotropic.assign(n + 1, 1);
  system.wrenches.assign(n + 1, Wrench{});
  for (std::size_t i = 0; i < n; ++i) {
    const FreeMotion motion = predict_motion(world.properties[i], world.state(i), gravity, step, planar);
    system.bodies[i] = motion.body, system.inertia[i] = motion.inverse_inertia, system.isotropic[i] = motion.isotropic;
  }
  system.step = step;
  exchange.start_step(world, contacts), exchange.finish_step();
}

BuildContext Bench::context() const {
  BuildContext context{{world}, world, system, settings, system.counts.empty()};
  context.contacts = &contacts, context.contact_batch = &system.contacts();
  context.exchange = [](std::span<std::int32_t>) {};
  context.any_over_ranks = [](bool here) { return here; };
  return context;
}

void Bench::build(std::span<const std::uint32_t> order, std::span<const std::uint32_t> groups) {
  BuildContext input = context();
  input.contact_order = order, input.contact_groups = groups;
  system.contacts().build(input);
}

std::vector<std::int32_t> Bench::counts() const {
  std::vector<std::int32_t> counts(world.size() + 1, 0);
  for (const Manifold& m : contacts.manifolds)
    ++counts[static_cast<std::size_t>(m.slot_a)], ++counts[static_cast<std::size_t>(m.slot_b)];
  return counts;
}

void Bench::build_for_jacobi() {
  predict();
  std::vector<std::uint32_t> order(contacts.manifolds.size());
  std::iota(order.begin(), order.end(), 0);
  const std::vector<std::uint32_t> groups{static_cast<std::uint32_t>(order.size())};
  const std::vector<std::int32_t> pairs = counts();
  system.counts.assign(pairs.begin(), pairs.end());
  build(order, groups);
}

void Bench::build_sequential(std::span<const std::uint32_t> order) {
  predict();
  std::vector<std::uint32_t> groups(order.size());
  std::iota(groups.begin(), groups.end(), 1);
  system.counts.clear();
  build(order, groups);
}

void Bench::start(const Stage& stage) {
  start_stage(system, stage);
  system.contacts().set_impulses({});
}

}  // namespace unibody::small_worlds
