// The section `threads`: nodes along a polyline, linked one to the next.
#include <algorithm>
#include <cmath>

#include "scene/flexible.hpp"

namespace unibody {

namespace {

constexpr double pi = 3.14159265358979323846;

struct Thread {
  std::vector<Vec3> corners;   // m, of the polyline
  std::vector<double> arc{0};  // m, from the first corner to each
  Id segments = 1;
  Spring stretch;                 // of one segment (N/m)
  std::optional<Spring> bending;  // links to the second neighbour (N/m)

  double segment() const { return arc.back() / static_cast<double>(segments); }
  Vec3 place(Id k) const {
    const double s = arc.back() * static_cast<double>(k) / static_cast<double>(segments);
    const auto after = std::upper_bound(arc.begin() + 1, arc.end() - 1, s);
    const auto i = static_cast<std::size_t>(after - arc.begin());
    return corners[i - 1] + (s - arc[i - 1]) / (arc[i] - arc[i - 1]) * (corners[i] - corners[i - 1]);
  }
};

template <class Link>
void add_link(const Thread& thread, Id first, Id a, Id reach, const Spring& spring, ConstraintSet& out) {
  if (a < 0 || a + reach > thread.segments) return;
  Constraint<Link> c;
  c.ids = {first + a, first + a + reach};
  c.parameters = {reach == 1 ? thread.segment() : (thread.place(a + reach) - thread.place(a)).norm()};
  c.compliance = {spring.compliance()}, c.damping = spring.damping;
  c.colour = static_cast<std::int32_t>(a / reach % 2);
  std::get<ConstraintList<Link>>(out).push_back(c);
}

void read_line(const Value& points, Thread& thread, const Scene& scene) {
  for (const Value& point : points.list("points")) thread.corners.push_back(read_vector(point, scene, "m"));
  if (thread.corners.size() < 2) points.fail_expected("a list of at least 2 points");
  for (std::size_t k = 1; k < thread.corners.size(); ++k) {
    const double length = (thread.corners[k] - thread.corners[k - 1]).norm();
    if (!std::isfinite(length)) points.entries[k].fail("a point too far from the one before", "a finite distance");
    if (!(length > 0)) points.entries[k].fail("the point before it again", "a point at a distance");
    thread.arc.push_back(thread.arc.back() + length);
  }
}

const Keys& stretch_keys() {
  static const Keys table =
      Keys{"stretch", "The resistance of a thread to stretch.", spring_keys("N/m", "stiffness of a segment")}.with(
          {"",
           "",
           {keys::number("youngs_modulus", "Pa", positive, "a stiffness", "E: a segment has E pi radius^2 / its length")}});
  return table;
}

const Keys& thread_bending_keys() {
  static const Keys table{"thread_bending", "Links of a thread's nodes to their second neighbours.",
                          spring_keys("N/m", "stiffness of each link")};
  return table;
}

void read_stretch(const Value& value, double radius, Thread& thread) {
  const KeyedMap map(value, stretch_keys());
  thread.stretch = read_spring(map);
  map.only_one_of({"stiffness", "youngs_modulus"});
  if (const auto modulus = map.number_if("youngs_modulus"))
    thread.stretch.stiffness = *modulus * pi * radius * radius / thread.segment();
}

void read_thread(const Value& value, Scene& scene) {
  const KeyedMap entry(value, thread_keys());
  Thread thread;
  read_line(entry.need("points"), thread, scene);
  thread.segments = entry.integer("segments");
  check_room(entry.need("segments"), scene, thread.segments + 1);
  const double radius = entry.number("radius"), mass = entry.number("mass");
  if (const Value* stretch = entry.find("stretch")) read_stretch(*stretch, radius, thread);
  if (const Value* bending = entry.find("bending")) thread.bending = read_spring(KeyedMap(*bending, thread_bending_keys()));
  const Nodes nodes = read_nodes(entry, radius, scene);
  const Id first = add_flexible(
      scene, nodes, thread.segments + 1,
      [thread, nodes, mass](Id k) {  // half a segment's mass at each of its ends
        const bool end = k == 0 || k == thread.segments;
        return nodes.at(thread.place(k), mass / static_cast<double>(thread.segments) * (end ? 0.5 : 1));
      },
      [thread](Id start, Id node, ConstraintSet& out) {
        for (const Id a : {node - 1, node}) add_link<Distance>(thread, start, a, 1, thread.stretch, out);
        if (!thread.bending) return;
        for (const Id a : {node - 2, node}) add_link<BendingLink>(thread, start, a, 2, *thread.bending, out);
      });
  Surface& surface = scene.surfaces.emplace_back();
  surface.name = nodes.name, surface.corners = 2, surface.count = thread.segments;
  surface.cell = [first](Id k) { return std::array<Id, 3>{first + k, first + k + 1, 0}; };
  surface.first_node = first, surface.node_count = thread.segments + 1;
  surface.cells_of = [first, last = first + thread.segments](Id node, std::vector<std::array<Id, 3>>& out) {
    if (node > first) out.push_back({node - 1, node, node});
    if (node < last) out.push_back({node, node + 1, node + 1});
  };
  if (thread.stretch.stiffness > 0)
    surface.elasticity = [modulus = thread.stretch.stiffness * thread.segment() / (pi * radius * radius)](Id) {
      return std::array<double, 2>{modulus, 0};
    };
  surface.self_collision = entry.flag("self_collision");
  read_pins(entry, scene, first, thread.segments + 1, [&](const Value& node) { return node.integer(0, thread.segments); });
}

}  // namespace

const Keys& thread_keys() {
  static const Keys table =
      node_keys("thread", "A line of particles, linked one to the next.", "k, from 0")
          .with({"",
                 "",
                 {keys::list("points", "m", "a list of at least 2 points", needed, "points of the line, in the entry's frame",
                             [] { return keys::list_of(keys::of_type("number"), 3); }),
                  keys::integer("segments", 1, 1'000'000'000, needed, "segments of equal length; nodes less one"),
                  keys::number("radius", "m", positive, needed, "a node touches as a sphere of this radius"),
                  keys::number("mass", "kg", positive, needed, "mass of the whole; an end node has half of another's"),
                  keys::map("stretch", stretch_keys, "a map", "stiff", "resistance to stretch"),
                  keys::map("bending", thread_bending_keys, "a map", "none", "links to the second neighbour"),
                  self_collision_key()}});
  return table;
}

void read_threads(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("threads")) read_thread(entry, scene);
}

}  // namespace unibody
