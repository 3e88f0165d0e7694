#include "scene/resolution.hpp"

#include <cmath>
#include <limits>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "scene/refuse_body.hpp"
#include "world/limits.hpp"

namespace unibody {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double resolved_size = 1e7;    // in units of the rounding of a coordinate
constexpr double resolved_speed = 1e-6;  // rounding of a coordinate in a step, over the scene's speed

// What the checks compare.
struct Extent {
  double size, place, speed, gained;  // m, m (largest coordinate), m/s, m/s gained from rest on the way of its size
};

// acceleration: m/s^2, the largest of all times, of a dynamic body.
Extent extent_of(const Body& body, double acceleration) {
  const BodyProperties& p = body.properties;
  const BodyState& s = body.state;
  const double size = smallest_size(p.shape), radius = bounding_radius(p.shape);
  Extent e{size, s.position.cwiseAbs().maxCoeff(), s.velocity.stableNorm(), 0};
  if (std::isfinite(radius)) e.speed = std::max(e.speed, s.angular_velocity.stableNorm() * radius);
  if (!p.is_static()) e.gained = std::sqrt(acceleration * size);
  return e;
}

double largest_acceleration(const Scene& scene, const BodyGroup& group, const BodyProperties& body) {
  if (!group.load && !scene.gravity_in_time) return (scene.gravity + body.force / body.mass).stableNorm();
  return scene.largest_gravity() + (group.load ? group.load->force.largest() : body.force.stableNorm()) / body.mass;
}

template <class F>
void for_each_body_looked_at(const Scene& scene, F&& f) {
  constexpr Id all = 100'000, ends = 1000;
  for (const BodyGroup& group : scene.groups)
    for (Id k = 0; k < group.count; ++k) {
      if (group.count > all && k == ends) k = group.count - ends;
      const Body body = group.make(k);
      f(group, k, extent_of(body, largest_acceleration(scene, group, body.properties)));
    }
}

void check_body(const Scene& scene, const BodyGroup& group, Id k, const Extent& e) {
  const auto refuse = [&](const std::string& found, const std::string& expected) {
    refuse_body(scene, group, k, found, expected);
  };
  if (std::isfinite(e.size) && !(e.size >= least_size && e.size <= largest_size))  // a plane has no size
    refuse("a size of " + number_text(e.size) + " m", "1e-15 to 1e15 m");
  if (!(e.place <= farthest)) refuse("a coordinate of " + number_text(e.place) + " m", "at most 1e15 m");
  if (!(e.speed < fastest)) refuse("a speed of " + number_text(e.speed) + " m/s", "less than that of light, 299792458 m/s");
  const double rounding = epsilon * e.place;
  if (!group.is_static && !(e.size >= resolved_size * rounding))
    refuse("a size of " + number_text(e.size) + " m where coordinates of " + number_text(e.place) + " m are rounded by " +
               number_text(rounding) + " m",
           "a size of at least " + number_text(resolved_size * rounding) + " m, or a place nearer to the origin");
}

void check_step(const Scene& scene, const BodyGroup& group, Id k, const Extent& e, double speed) {
  const double step = scene.time.frame / scene.time.substeps, rounding = epsilon * std::max(e.place, e.size);
  if (group.is_static || !(rounding / step > resolved_speed * speed)) return;
  refuse_body(scene, group, k,
              "steps of " + number_text(step) + " s (time.frame / time.substeps), in which coordinates of " +
                  number_text(std::max(e.place, e.size)) + " m are rounded by more than 1e-6 of what bodies move at " +
                  number_text(speed) + " m/s",
              "steps of at least " + number_text(rounding / (resolved_speed * speed)) + " s");
}

// What gravity adds to a speed in a step is taken off again where a body rests, to its rounding.
void check_gravity(const Scene& scene, double speed) {
  const double step = scene.time.frame / scene.time.substeps, added = scene.largest_gravity() * step;
  if (!(epsilon * added > resolved_speed * speed)) return;
  throw InputError(scene.path + ": found steps of " + number_text(step) + " s (time.frame / time.substeps) in a gravity of " +
                   number_text(scene.largest_gravity()) + " m/s^2, which add speeds that are rounded by more than 1e-6 of " +
                   number_text(speed) + " m/s, expected shorter steps or less gravity");
}

}  // namespace

void check_resolution(const Scene& scene) {
  double speed = 0;
  for_each_body_looked_at(scene, [&](const BodyGroup& group, Id k, const Extent& e) {
    check_body(scene, group, k, e);
    speed = std::max({speed, e.speed, std::isfinite(e.gained) ? e.gained : 0});
  });
  if (!(speed > 0)) return;  // nothing that would be lost
  check_gravity(scene, speed);
  for_each_body_looked_at(scene, [&](const BodyGroup& group, Id k, const Extent& e) { check_step(scene, group, k, e, speed); });
}

}  // namespace unibody
