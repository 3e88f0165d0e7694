#include "scene/generators.hpp"

#include <algorithm>
#include <cmath>

#include "scene/articulated.hpp"
#include "scene/mix.hpp"
#include "scene/random.hpp"
#include "scene/static_parts.hpp"

namespace unibody {

namespace {

constexpr Id most_bodies = 1'000'000'000'000;

Id read_count(const Value& map) { return map.need("count", "an integer >= 1").integer(1, most_bodies); }

std::uint64_t read_seed(const Value& map) {
  const Value* seed = map.find("seed");
  return seed ? static_cast<std::uint64_t>(seed->integer(0)) : 1;
}

double read_optional(const Value& map, const char* key, double otherwise, const Range& range, const std::string& unit) {
  const Value* value = map.find(key);
  return value ? value->number(range, unit) : otherwise;
}

// The place of body k in layers of nx x ny, x first.
struct Cells {
  Id nx = 1, ny = 1;
  Id x(Id k) const { return k % nx; }
  Id y(Id k) const { return k / nx % ny; }
  Id z(Id k) const { return k / (nx * ny); }
};

Cells read_columns(const Value& map, const Scene& scene) {
  const Value& columns = map.need("columns", "a list of 2 integers >= 1");
  if (columns.kind != Value::Kind::list || columns.entries.size() != 2) columns.fail_expected("a list of 2 integers >= 1");
  const Cells cells{columns.entries[0].integer(1, 1'000'000), columns.entries[1].integer(1, 1'000'000)};
  if (scene.planar && cells.ny != 1) columns.fail_expected("1 as the second of two integers (planar scene)");
  return cells;
}

double centred(Id i, Id n) { return static_cast<double>(i) - static_cast<double>(n - 1) / 2; }

Quat from_rotation_vector(const Vec3& v) {
  const double angle = v.norm();
  return angle > 0 ? Quat(Eigen::AngleAxisd(angle, v / angle)) : Quat::Identity();
}

struct Lattice {
  Cells cells;
  Vec3 spacing = Vec3::Zero();
  double height = 0, jitter = 0, turn = 0;
  std::uint64_t seed = 1;
  bool planar = false;
  BodyTemplate body;

  // Body k draws u0..u5, also where there is no jitter. The reference scenes have y up: their (x, y, z) is our (x, z, -y),
  // a turn about x, so that the scene is the same one.
  Body operator()(Id k) const {
    Lcg random{seed};
    random.jump(6 * static_cast<std::uint64_t>(k));
    double u[6];
    for (double& draw : u) draw = random.next();
    const double x = centred(cells.x(k), cells.nx) * spacing.x() + jitter * u[0];
    const double y = planar ? 0 : -(centred(cells.y(k), cells.ny) * spacing.y() + jitter * u[2]);
    const double z = height + static_cast<double>(cells.z(k)) * spacing.z() + jitter * u[1];
    const Vec3 rotation = planar ? Vec3(0, -turn * u[5], 0) : Vec3(turn * u[3], -turn * u[5], turn * u[4]);
    return make_body(body, body.properties.shape, {x, y, z}, from_rotation_vector(rotation));
  }
};

Generated read_lattice(const Value& value, const BodyTemplate& body, const Scene& scene) {
  value.map({"count", "columns", "spacing", "height", "jitter", "rotation_jitter", "seed"});
  Lattice lattice;
  lattice.cells = read_columns(value, scene);
  lattice.spacing = value.need("spacing", "a list of 3 numbers > 0 (m)").vector(positive, "m");
  lattice.height = read_optional(value, "height", 0, any_number, "m");
  lattice.jitter = read_optional(value, "jitter", 0, not_negative, "m");
  lattice.turn = read_optional(value, "rotation_jitter", 0, not_negative, "rad");
  lattice.seed = read_seed(value);
  lattice.planar = scene.planar;
  lattice.body = body;
  return {read_count(value), lattice};
}

struct Pile {
  Cells cells;
  double edge = 0;  // m, of a cell
  std::uint64_t seed = 1;
  bool planar = false;
  Mix mix;
  BodyTemplate body;

  // The bounding sphere stays within the middle of its cell, so that no two bodies overlap whatever their orientation.
  Body operator()(Id k) const {
    BodyRandom random(seed, k);
    const Shape shape = mix.draw(random);
    const double room = std::max(mix.largest_radius() - bounding_radius(shape), 0.0);
    const double x = centred(cells.x(k), cells.nx) * edge + random.between(-room, room);
    const double y = centred(cells.y(k), cells.ny) * edge + random.between(-room, room);
    const double z = (static_cast<double>(cells.z(k)) + 0.5) * edge + random.between(-room, room);
    if (!planar) return make_body(body, shape, {x, y, z}, random_orientation(random));
    return make_body(body, shape, {x, 0, z}, Quat(Eigen::AngleAxisd(random.between(-M_PI, M_PI), Vec3::UnitY())));
  }
};

Generated read_pile(const Value& value, const BodyTemplate& body, const Scene& scene) {
  value.map({"count", "columns", "mix", "gap", "seed"});
  Pile pile;
  pile.cells = read_columns(value, scene);
  pile.mix = Mix::read(value.need("mix", "a list of shapes with share and scale"), body, scene);
  pile.edge = 2 * pile.mix.largest_radius() + read_optional(value, "gap", 0, not_negative, "m");
  pile.seed = read_seed(value);
  pile.planar = scene.planar;
  pile.body = body;
  return {read_count(value), pile};
}

// Courses of n bricks, and of n - 1 bricks between two halves, in turn: joints don't run through, the ends are straight.
struct Wall {
  Id length = 1;
  double gap = 0, course_gap = 0;
  BodyTemplate brick, half;

  Body operator()(Id k) const {
    const Id two_courses = 2 * length + 1, in_two = k % two_courses;
    const bool offset = in_two >= length;
    const Id course = 2 * (k / two_courses) + (offset ? 1 : 0), i = offset ? in_two - length : in_two;
    const Vec3 edges = 2 * brick.properties.shape.size;
    const double pitch = edges.x() + gap,
                 z = (static_cast<double>(course) + 0.5) * edges.z() + static_cast<double>(course) * course_gap;
    if (!offset) return make_body(brick, brick.properties.shape, {centred(i, length) * pitch, 0, z});
    if (i != 0 && i != length) return make_body(brick, brick.properties.shape, {centred(i, length + 1) * pitch, 0, z});
    const double end = 0.5 * (static_cast<double>(length) * pitch - gap) - half.properties.shape.size.x();
    return make_body(half, half.properties.shape, {i == 0 ? -end : end, 0, z});
  }
};

Generated read_wall(const Value& value, const BodyTemplate& body, const Scene&) {
  value.map({"bricks", "courses", "gap", "course_gap"});
  Wall wall;
  if (body.properties.shape.kind != ShapeKind::box) value.fail("bricks that aren't boxes", "shape: {box: ...}");
  if (body.inertia) value.fail("an inertia", "none, since a wall has half bricks too");
  const double brick_length = 2 * body.properties.shape.size.x();
  wall.length = value.need("bricks", "an integer >= 1").integer(1, 1'000'000);
  wall.gap = read_optional(value, "gap", 0, {0, brick_length, false, true}, "m");
  wall.course_gap = read_optional(value, "course_gap", 0, not_negative, "m");
  wall.brick = wall.half = body;
  wall.half.properties.shape.size.x() = 0.25 * (brick_length - wall.gap);
  if (body.mass) wall.half.mass = *body.mass * 2 * wall.half.properties.shape.size.x() / brick_length;
  const Id courses = value.need("courses", "an integer >= 1").integer(1, 1'000'000);
  return {courses / 2 * (2 * wall.length + 1) + courses % 2 * wall.length, wall};
}

struct Stack {
  double height = 0, gap = 0;
  std::vector<double> offsets;  // m, along x; none: 0
  BodyTemplate body;

  Body operator()(Id k) const {
    const double x = offsets.empty() ? 0 : offsets[static_cast<std::size_t>(k)];
    return make_body(body, body.properties.shape, {x, 0, (static_cast<double>(k) + 0.5) * height + static_cast<double>(k) * gap});
  }
};

Generated read_stack(const Value& value, const BodyTemplate& body, const Scene&) {
  value.map({"count", "gap", "offsets"});
  const Shape& shape = body.properties.shape;
  const Id count = read_count(value);
  Stack stack;
  stack.height = 2 * (is_round(shape) ? shape.size.x() : shape.size.z());
  stack.gap = read_optional(value, "gap", 0, not_negative, "m");
  if (const Value* offsets = value.find("offsets"))
    stack.offsets = offsets->numbers(static_cast<std::size_t>(count), any_number, "m, along x");
  stack.body = body;
  return {count, stack};
}

Generated read_points(const Value& value, const BodyTemplate& body, const Scene& scene) {
  std::vector<Vec3> points;
  for (const Value& point : value.list("points")) points.push_back(read_vector(point, scene, "m"));
  const Id count = static_cast<Id>(points.size());
  return {count, [body, points = std::move(points)](Id k) {
            return make_body(body, body.properties.shape, points[static_cast<std::size_t>(k)]);
          }};
}

}  // namespace

const std::vector<GeneratorType>& generator_types() {
  static const std::vector<GeneratorType> types{
      {"points", Takes::shape, read_points},   {"stack", Takes::shape, read_stack},
      {"wall", Takes::shape, read_wall},       {"lattice", Takes::shape, read_lattice},
      {"pile", Takes::no_shape, read_pile},    {"container", Takes::nothing, read_container},
      {"hopper", Takes::nothing, read_hopper}, {"chain", Takes::shape, read_chain},
      {"tree", Takes::no_shape, read_tree},    {"ragdolls", Takes::no_shape, read_ragdolls},
      {"inlet", Takes::no_shape, read_inlet},
  };
  return types;
}

}  // namespace unibody
