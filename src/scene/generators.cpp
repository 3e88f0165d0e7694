#include "scene/generators.hpp"

#include <algorithm>
#include <cmath>

#include "scene/articulated.hpp"
#include "scene/mix.hpp"
#include "scene/random.hpp"
#include "scene/robot.hpp"
#include "scene/static_parts.hpp"
#include "scene/triaxial.hpp"

namespace unibody {

namespace {

// The place of body k in layers of nx x ny, x first.
struct Cells {
  Id nx = 1, ny = 1;
  Id x(Id k) const { return k % nx; }
  Id y(Id k) const { return k / nx % ny; }
  Id z(Id k) const { return k / (nx * ny); }
};

Cells read_columns(const KeyedMap& map, const Scene& scene) {
  const auto [nx, ny] = map.integers<2>("columns");
  if (scene.planar && ny != 1) map.need("columns").fail_expected("1 as the second of two integers (planar scene)");
  return {nx, ny};
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

const Keys& lattice_keys() {
  static const Keys table{
      "lattice",
      "Bodies in layers of columns, which may stand and lie at random by a little.",
      {keys::count("bodies"), keys::columns(needed),
       keys::numbers("spacing", 3, "m", positive, needed, "from a body to the next along x, y and z"),
       keys::number("height", "m", any_number, 0, "height of the centres of the lowest layer"),
       keys::number("jitter", "m", not_negative, 0, "the most by which a body is off its place along each axis"),
       keys::number("rotation_jitter", "rad", not_negative, 0, "the most by which a body is turned about each axis"),
       keys::seed("state of the random numbers before the first of them")}};
  return table;
}

Generated read_lattice(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, lattice_keys());
  Lattice lattice;
  lattice.cells = read_columns(map, scene);
  lattice.spacing = map.vector("spacing");
  lattice.height = map.number("height"), lattice.jitter = map.number("jitter"), lattice.turn = map.number("rotation_jitter");
  lattice.seed = static_cast<std::uint64_t>(map.integer("seed"));
  lattice.planar = scene.planar;
  lattice.body = body;
  return {map.integer("count"), lattice};
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

const Keys& pile_keys() {
  static const Keys table{
      "pile",
      "Bodies of many shapes and sizes in layers of cubic cells, none of which overlap, each turned at random.",
      {keys::count("bodies"), keys::columns(needed), mix_key(),
       keys::number("gap", "m", not_negative, 0, "least distance of two bodies"),
       keys::seed("number that gives the random numbers")}};
  return table;
}

Generated read_pile(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, pile_keys());
  Pile pile;
  pile.cells = read_columns(map, scene);
  pile.mix = Mix::read(map.need("mix"), body, scene);
  pile.edge = 2 * pile.mix.largest_radius() + map.number("gap");
  pile.seed = static_cast<std::uint64_t>(map.integer("seed"));
  pile.planar = scene.planar;
  pile.body = body;
  return {map.integer("count"), pile};
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

const Keys& wall_keys() {
  static const Keys table{
      "wall",
      "Bricks, which are boxes, in courses, every second one off by half a brick between two half bricks.",
      {keys::integer("bricks", 1, 1'000'000, needed, "bricks of the first course, and of every second one after it"),
       keys::integer("courses", 1, 1'000'000, needed, "layers of bricks"),
       keys::number("gap", "m", not_negative, 0, "between the bricks of a course; less than a brick's length"),
       keys::number("course_gap", "m", not_negative, 0, "between two courses")}};
  return table;
}

Generated read_wall(const Value& value, const BodyTemplate& body, const Scene&) {
  const KeyedMap map(value, wall_keys());
  Wall wall;
  if (body.properties.shape.kind != ShapeKind::box) value.fail("bricks that aren't boxes", "shape: {box: ...}");
  if (body.inertia) value.fail("an inertia", "none, since a wall has half bricks too");
  const double brick_length = 2 * body.properties.shape.size.x();
  wall.length = map.integer("bricks");
  wall.gap = map.has("gap") ? map.need("gap").number({0, brick_length, false, true}, "m") : 0;
  wall.course_gap = map.number("course_gap");
  wall.brick = wall.half = body;
  wall.half.properties.shape.size.x() = 0.25 * (brick_length - wall.gap);
  if (body.mass) wall.half.mass = *body.mass * 2 * wall.half.properties.shape.size.x() / brick_length;
  const Id courses = map.integer("courses");
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

const Keys& stack_keys() {
  static const Keys table{"stack",
                          "Bodies above each other, the lowest on the height of the entry's position.",
                          {keys::count("bodies"), keys::number("gap", "m", not_negative, 0, "between two bodies"),
                           keys::list("offsets", "m", "a list of a number for each body", "all 0", "of each body along x",
                                      [] { return keys::of_type("number"); })}};
  return table;
}

Generated read_stack(const Value& value, const BodyTemplate& body, const Scene&) {
  const KeyedMap map(value, stack_keys());
  const Shape& shape = body.properties.shape;
  const Id count = map.integer("count");
  Stack stack;
  stack.height = 2 * (is_round(shape) ? shape.size.x() : shape.size.z());
  stack.gap = map.number("gap");
  if (const Value* offsets = map.find("offsets"))
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

namespace keys {

Key count(const char* what, Id most) { return integer("count", 1, most, needed, what); }
Key columns(const Without& without) {
  return integers("columns", 2, 1, 1'000'000, without, "columns along x and along y, of which a layer is made");
}
Key seed(const char* about) { return integer("seed", 0, std::int64_t{1} << 53, 1, about); }

}  // namespace keys

const std::vector<GeneratorType>& generator_types() {
  const auto key = [](const char* name, KeysOf table, const char* about) {
    return keys::map(name, table, "a map", "none", about);
  };
  static const std::vector<GeneratorType> types{
      {keys::list("points", "m", "a list of points", "none", "generates a body at each of these points",
                  [] { return keys::list_of(keys::of_type("number"), 3); }),
       Takes::shape, read_points},
      {key("stack", stack_keys, "generates bodies above each other"), Takes::shape, read_stack},
      {key("wall", wall_keys, "generates courses of bricks"), Takes::shape, read_wall},
      {key("lattice", lattice_keys, "generates layers of columns"), Takes::shape, read_lattice},
      {key("pile", pile_keys, "generates bodies of many shapes and sizes"), Takes::no_shape, read_pile},
      {key("container", container_keys, "generates walls, and a floor"), Takes::nothing, read_container},
      {key("hopper", hopper_keys, "generates inclined boards with an opening below"), Takes::nothing, read_hopper},
      {key("triaxial", triaxial_keys, "generates the plates of a triaxial cell"), Takes::material, read_triaxial},
      {key("chain", chain_keys, "generates links in a line, jointed one to the next"), Takes::shape, read_chain},
      {key("tree", tree_keys, "generates links that branch at their ends"), Takes::no_shape, read_tree},
      {key("ragdolls", ragdolls_keys, "generates figures of eleven parts"), Takes::no_shape, read_ragdolls},
      {key("urdf", urdf_keys, "generates a robot from a URDF file"), Takes::material, read_urdf_robot},
      {key("mjcf", mjcf_keys, "generates robots and other bodies from an MJCF file"), Takes::material, read_mjcf_robot},
      {key("inlet", inlet_keys, "generates bodies that come in while the scene runs"), Takes::no_shape, read_inlet},
  };
  return types;
}

}  // namespace unibody
