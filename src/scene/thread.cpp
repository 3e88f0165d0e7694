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

void read_stretch(const Value& value, double radius, Thread& thread) {
  value.map({"stiffness", "youngs_modulus", "damping"});
  thread.stretch = read_spring(value, "N/m");
  const Value *modulus = value.find("youngs_modulus"), *stiffness = value.find("stiffness");
  if (modulus && stiffness) modulus->fail("a youngs_modulus beside stiffness", "only one of them");
  if (modulus) thread.stretch.stiffness = modulus->number(positive, "Pa") * pi * radius * radius / thread.segment();
}

void read_thread(const Value& entry, Scene& scene) {
  entry.map(thread_keys());
  Thread thread;
  read_line(entry.need("points", "a list of at least 2 points"), thread, scene);
  const Value& segments = entry.need("segments", "an integer >= 1");
  thread.segments = segments.integer(1, 1'000'000'000);
  check_room(segments, scene, thread.segments + 1);
  const double radius = entry.need("radius", "a number > 0 (m)").number(positive, "m");
  const double mass = entry.need("mass", "a number > 0 (kg)").number(positive, "kg");
  if (const Value* stretch = entry.find("stretch")) read_stretch(*stretch, radius, thread);
  if (const Value* bending = entry.find("bending")) {
    bending->map({"stiffness", "damping"});
    thread.bending = read_spring(*bending, "N/m");
  }
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
  if (const Value* self = entry.find("self_collision")) surface.self_collision = self->boolean();
  read_pins(entry, scene, first, thread.segments + 1, [&](const Value& node) { return node.integer(0, thread.segments); });
}

}  // namespace

std::vector<std::string> thread_keys() {
  std::vector<std::string> keys = node_keys;
  for (const char* key : {"points", "segments", "radius", "mass", "stretch", "bending", "self_collision"}) keys.emplace_back(key);
  return keys;
}

void read_threads(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("threads")) read_thread(entry, scene);
}

}  // namespace unibody
