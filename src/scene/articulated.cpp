#include "scene/articulated.hpp"

#include <cmath>

#include "scene/body_mass.hpp"
#include "scene/flexible.hpp"
#include "scene/joints.hpp"
#include "scene/random.hpp"

namespace unibody {

namespace {

constexpr Id most_links = 10'000'000;  // every rank knows all joints

// The turn that takes x to the unit vector d; about y where d lies in the x-z plane.
Quat turn_x_to(const Vec3& d) {
  if (d.x() < -1 + 1e-12) return Quat(0, 0, 1, 0);
  return Quat(1 + d.x(), 0, -d.z(), d.y()).normalized();
}

// Links along a line, joint k at the start of link k, and perhaps a ball after the last.
struct Chain {
  Id count = 1;
  Vec3 from = Vec3::Zero(), step = Vec3::Zero();
  Quat turn = Quat::Identity();
  BodyTemplate link, ball;
  bool has_ball = false;

  Id bodies() const { return count + (has_ball ? 1 : 0); }
  Vec3 joint(Id k) const { return from + static_cast<double>(k) * step; }
  Body operator()(Id k) const {
    Body body;
    if (k < count) {
      body = make_body(link, link.properties.shape, joint(k) + 0.5 * step, turn);
    } else {
      const Shape& shape = ball.properties.shape;
      body = make_body(ball, shape, joint(count) + shape.size.x() * step.normalized(), turn);
    }
    body.id = k;
    return body;
  }
};

const Keys& chain_ball_keys() {
  static const Keys table{"chain_ball",
                          "The ball at the end of a chain.",
                          {keys::number("radius", "m", positive, needed, "radius of the ball"),
                           keys::number("mass", "kg", positive, needed, "mass of the ball")}};
  return table;
}

void read_ball(const Value& value, const Scene& scene, Chain& chain) {
  const KeyedMap map(value, chain_ball_keys());
  chain.has_ball = true;
  chain.ball = chain.link;
  chain.ball.density.reset(), chain.ball.inertia.reset();
  chain.ball.properties.shape = {scene.planar ? ShapeKind::disc : ShapeKind::sphere, Vec3(map.number("radius"), 0, 0)};
  chain.ball.mass = map.number("mass");
  check_mass(value, chain.ball, chain.ball.properties.shape);
}

}  // namespace

std::int32_t group_without_contacts(Id first, Id i) {
  return static_cast<std::int32_t>((Id{1} << 30) + (first + i) % (Id{1} << 29));
}

namespace {

void need_density(const Value& value, const BodyTemplate& body, const char* what) {
  if (!body.properties.is_dynamic()) value.fail(std::string(what) + " that are not dynamic", "no motion");
  if (!body.density) value.fail("no density", std::string("density: a number > 0 (kg/m^3), since ") + what + " differ in size");
}

// Links that branch at their ends, each level shorter than the one above by a ratio. Body 0 is the root; the branches of body k
// are bodies b k + 1 to b k + b. A link's axis x runs from its start to its end.
struct Tree {
  Id branches = 2;
  double length = 1, ratio = 0.7, width = 0.1, spread = M_PI / 3;
  BodyTemplate link;

  struct Link {
    Vec3 start = Vec3::Zero();
    Quat turn = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));  // downwards
    double length = 1, width = 0.1;
  };
  Vec3 end(const Link& l) const { return l.start + l.turn * Vec3(l.length, 0, 0); }
  Link at(Id k) const {
    if (k == 0) return {Vec3::Zero(), Link{}.turn, length, width};
    const Link parent = at((k - 1) / branches);
    const double around = 2 * M_PI * static_cast<double>((k - 1) % branches) / static_cast<double>(branches);
    const Quat away = Quat(Eigen::AngleAxisd(around, Vec3::UnitX())) * Quat(Eigen::AngleAxisd(spread, Vec3::UnitZ())) *
                      Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
    return {end(parent), (parent.turn * away).normalized(), parent.length * ratio, parent.width * ratio};
  }
  Body operator()(Id k) const {
    const Link l = at(k);
    Body body = make_body(link, {ShapeKind::box, 0.5 * Vec3(l.length, l.width, l.width)}, 0.5 * (l.start + end(l)), l.turn);
    body.id = k;
    return body;
  }
};

// A figure of boxes and a ball, of 1.73 m: part by part where it is when it stands, looking along +x. Of a hinge about y: its
// limits. Of a ball: the axis of its cone, in the parent; how far the part, along which its own axis lies, may swing from it, and
// how far it may twist to either side of where it stands.
struct FigurePart {
  ShapeKind shape;
  double size[3];  // m, edges; of the head its radius
  double centre[3];
  int parent;
  double joint[3];
  double limits[2];  // degrees: of a hinge lower and upper; of a ball swing and twist
  double cone[3];    // 0: a hinge
};
constexpr FigurePart figure[] = {
    {ShapeKind::box, {0.20, 0.30, 0.18}, {0, 0, 0.95}, -1, {}, {}, {}},                                      // pelvis
    {ShapeKind::box, {0.22, 0.36, 0.40}, {0, 0, 1.28}, 0, {0, 0, 1.06}, {40, 30}, {0.26, 0, 0.97}},          // chest
    {ShapeKind::sphere, {0.11, 0, 0}, {0, 0, 1.62}, 1, {0, 0, 1.50}, {50, 70}, {0, 0, 1}},                   // head
    {ShapeKind::box, {0.09, 0.09, 0.30}, {0, 0.24, 1.30}, 1, {0, 0.24, 1.45}, {90, 80}, {0.6, 0.6, -0.53}},  // upper arms
    {ShapeKind::box, {0.09, 0.09, 0.30}, {0, -0.24, 1.30}, 1, {0, -0.24, 1.45}, {90, 80}, {0.6, -0.6, -0.53}},
    {ShapeKind::box, {0.07, 0.07, 0.27}, {0, 0.24, 1.01}, 3, {0, 0.24, 1.15}, {-140, 0}, {}},  // lower arms
    {ShapeKind::box, {0.07, 0.07, 0.27}, {0, -0.24, 1.01}, 4, {0, -0.24, 1.15}, {-140, 0}, {}},
    {ShapeKind::box, {0.13, 0.13, 0.42}, {0, 0.09, 0.66}, 0, {0, 0.09, 0.87}, {65, 40}, {0.6, 0.25, -0.76}},  // thighs
    {ShapeKind::box, {0.13, 0.13, 0.42}, {0, -0.09, 0.66}, 0, {0, -0.09, 0.87}, {65, 40}, {0.6, -0.25, -0.76}},
    {ShapeKind::box, {0.10, 0.10, 0.42}, {0, 0.09, 0.23}, 7, {0, 0.09, 0.45}, {0, 130}, {}},  // shins
    {ShapeKind::box, {0.10, 0.10, 0.42}, {0, -0.09, 0.23}, 8, {0, -0.09, 0.45}, {0, 130}, {}},
};
constexpr Id parts_of_a_figure = std::size(figure);

Vec3 vector(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

// Figures in layers of nx x ny, x first, each turned at random about its middle.
struct Ragdolls {
  Id nx = 1, ny = 1, first = 0;
  Vec3 spacing = Vec3::Ones();
  std::uint64_t seed = 1;
  bool self_collision = false;
  BodyTemplate part;

  Body operator()(Id k) const {
    const Id r = k / parts_of_a_figure;
    const FigurePart& f = figure[k % parts_of_a_figure];
    BodyRandom random(seed, r);
    const Quat turn = random_orientation(random);
    const auto n = [](Id i) { return static_cast<double>(i); };
    const Vec3 middle(0, 0, 0.87), cell(n(r % nx) - n(nx - 1) / 2, n(r / nx % ny) - n(ny - 1) / 2, n(r / nx / ny));
    const Vec3 size = f.shape == ShapeKind::sphere ? vector(f.size) : Vec3(0.5 * vector(f.size));
    Body body = make_body(part, {f.shape, size}, spacing.cwiseProduct(cell) + turn * (vector(f.centre) - middle), turn);
    body.id = k;
    if (!self_collision) body.properties.group = group_without_contacts(first, r);
    return body;
  }

  // The joint at the upper end of a part.
  Joint joint(Id k) const {
    const FigurePart& f = figure[k % parts_of_a_figure];
    const Body body = (*this)(k), parent = (*this)(k - k % parts_of_a_figure + f.parent);
    const Quat& turn = body.state.orientation;
    const Vec3 point = body.state.position + turn * (vector(f.joint) - vector(f.centre));
    const Vec3 cone = vector(f.cone);
    const bool hinge = cone.isZero();
    Joint joint =
        joint_between(hinge ? JointKind::hinge : JointKind::ball, body, &parent, point, turn * joint_axes(Vec3::UnitY()));
    const double degree = M_PI / 180;
    if (hinge) {
      joint.lower = degree * f.limits[0], joint.upper = degree * f.limits[1];
    } else {  // no twist where it stands: its axes are the cone's, turned the shortest way to the part
      const Vec3 along = (vector(f.centre) - vector(f.joint)).normalized();
      const Quat of_cone = joint_axes(cone.normalized(), Vec3::UnitX());
      joint.frame = {Quat(Quat::FromTwoVectors(cone, along) * of_cone).normalized(), of_cone};
      joint.swing = degree * f.limits[0], joint.upper = degree * f.limits[1], joint.lower = -joint.upper;
    }
    return joint;
  }
};

const std::vector<JointKind> joints_of_links{JointKind::ball, JointKind::hinge, JointKind::universal, JointKind::fixed};

Key joint_key() { return keys::map("joint", joint_template_keys, "a map with type", needed, "the joints between its bodies"); }

}  // namespace

const Keys& chain_keys() {
  static const Keys table{
      "chain",
      "Links in a line, each jointed to the one before.",
      {keys::count("links", most_links), keys::vector("from", "m", needed, "where the chain starts"),
       keys::vector("to", "m", needed, "where the chain ends"), joint_key(),
       keys::choice("held", {"none", "start", "end", "both"}, "none", "the ends that are jointed to the world"),
       keys::map("ball", chain_ball_keys, "a map with radius and mass", "none", "one body more, jointed to the chain's end")}};
  return table;
}

const Keys& tree_keys() {
  static const Keys table{"tree",
                          "Links that branch at their ends.",
                          {keys::integer("levels", 1, 24, needed, "levels of links, the root's included"),
                           keys::integer("branches", 1, 16, 2, "branches of each link"),
                           keys::number("length", "m", positive, needed, "length of the root"),
                           keys::number("ratio", "", {0, 1, true}, 0.7, "of a link's size to that of the link above"),
                           keys::number("width", "m", positive, "length / 8", "edge of the square cross-section of the root"),
                           keys::number("spread", "degrees", {0, 180}, 60, "angle between a branch and the link that it leaves"),
                           joint_key(), keys::flag("held", false, "the root's start is jointed to the world"),
                           keys::flag("self_collision", false, "links may touch each other")}};
  return table;
}

const Keys& ragdolls_keys() {
  static const Keys table{"ragdolls",
                          "Figures of eleven parts, of 1.73 m, in layers of columns, each turned at random.",
                          {keys::count("figures", most_links / parts_of_a_figure), keys::columns("[1, 1]"),
                           keys::numbers("spacing", 3, "m", positive, needed, "from a figure to the next along x, y and z"),
                           keys::seed("number that gives the random numbers"),
                           keys::flag("self_collision", false, "parts of a figure may touch each other")}};
  return table;
}

Generated read_chain(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, chain_keys());
  if (!body.properties.is_dynamic()) value.fail("a chain that is not dynamic", "no motion: its ends may be held");
  Chain chain;
  chain.count = map.integer("count");
  chain.from = read_vector(map, "from", scene);
  const Vec3 way = read_vector(map, "to", scene) - chain.from;
  if (!(way.norm() > 0)) map.need("to").fail_expected("another point than from (m)");
  chain.step = way / static_cast<double>(chain.count);
  chain.turn = turn_x_to(way.normalized());
  chain.link = body;
  if (const Value* ball = map.find("ball")) read_ball(*ball, scene, chain);
  const Value& of_joint = map.need("joint");
  const JointTemplate joint = read_joint_template(of_joint, scene, joints_of_links);
  check_turns(of_joint, joint.joint.kind, body.properties.shape);
  const std::size_t holds = map.choice("held");

  Generated result{chain.bodies(), chain, {}};
  const auto at = [&](Id k) { return chain(k); };
  if (holds == 1 || holds == 3) result.joints.push_back(joint.between(at(0), nullptr, chain.joint(0)));
  for (Id k = 1; k < chain.bodies(); ++k) {
    const Body before = at(k - 1), next = at(k);
    result.joints.push_back(joint.between(next, &before, chain.joint(k)));
  }
  if (holds == 2 || holds == 3) result.joints.push_back(joint.between(at(chain.count - 1), nullptr, chain.joint(chain.count)));
  return result;
}

Generated read_tree(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, tree_keys());
  if (scene.planar) value.fail("a tree in a planar scene", "planar: false");
  need_density(value, body, "links");
  Tree tree;
  const std::int64_t depth = map.integer("levels");
  tree.branches = map.integer("branches");
  tree.length = map.number("length"), tree.width = map.number_if("width").value_or(tree.length / 8);
  tree.ratio = map.number("ratio"), tree.spread = M_PI / 180 * map.number("spread");
  Id count = 0, on_level = 1;
  for (std::int64_t level = 0; level < depth; ++level, on_level *= tree.branches) count += on_level;
  if (count > most_links)
    map.need("levels").fail("a tree of " + std::to_string(count) + " links", "at most " + std::to_string(most_links));
  tree.link = body;
  if (!map.flag("self_collision")) tree.link.properties.group = group_without_contacts(scene.body_count(), 0);
  check_mass(value, tree.link, tree(count - 1).properties.shape);
  const JointTemplate joint = read_joint_template(map.need("joint"), scene, joints_of_links);
  Generated result{count, tree, {}};
  if (map.flag("held")) result.joints.push_back(joint.between(tree(0), nullptr, Vec3::Zero()));
  for (Id k = 1; k < count; ++k) {
    const Body link = tree(k), parent = tree((k - 1) / tree.branches);
    result.joints.push_back(joint.between(link, &parent, tree.at(k).start));
  }
  return result;
}

Generated read_ragdolls(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, ragdolls_keys());
  if (scene.planar) value.fail("ragdolls in a planar scene", "planar: false");
  need_density(value, body, "parts");
  Ragdolls dolls;
  const Id count = map.integer("count");
  if (map.has("columns")) std::tie(dolls.nx, dolls.ny) = std::tuple_cat(map.integers<2>("columns"));
  dolls.spacing = map.vector("spacing");
  dolls.seed = static_cast<std::uint64_t>(map.integer("seed"));
  dolls.self_collision = map.flag("self_collision");
  dolls.first = scene.body_count();
  dolls.part = body;
  Generated result{count * parts_of_a_figure, dolls, {}};
  for (Id k = 0; k < result.count; ++k)
    if (figure[k % parts_of_a_figure].parent >= 0) result.joints.push_back(dolls.joint(k));
  return result;
}

}  // namespace unibody
