#include "scene/bonds.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "collide/collide.hpp"
#include "scene/entry_name.hpp"
#include "scene/joints.hpp"
#include "scene/strength.hpp"
#include "world/shapes.hpp"

namespace unibody {

namespace {

constexpr double usual_gap = 1e-2;  // of the smaller body's size
constexpr const char* entry_words = "the name of an entry of bodies, or a list of names";

const Keys& beam_keys() {
  static const Keys table{
      "beam",
      "What a bond is made of: a round beam from centre to centre, of which the bond has the stiffness and the strength.",
      {keys::number("radius", "m", positive, "half of the smaller body's size", "radius of the beam"),
       keys::number("youngs_modulus", "Pa", positive, "rigid", "its Young's modulus"),
       keys::number("tensile_strength", "Pa", positive, "infinite", "the most that tension and bending together may pull it by"),
       keys::number("shear_strength", "Pa", positive, "infinite", "the most that shear and twisting together may load it by"),
       duration_key()}};
  return table;
}

// What the bonds of an entry have in common.
struct BondLaw {
  Joint joint;
  const Value* beam = nullptr;  // of which each bond has its own stiffness and strength; null: `joint` has them
  double gap = -1;              // m; below 0: a share of the smaller body's size
};

// Two bodies that lie next to each other, in the order of their ids.
struct Neighbours {
  Id a, b;
  Vec3 point, normal;  // m, half way between them; unit, from b to a
};

const BodyGroup& read_entry_name(const Value& value, const Scene& scene) {
  const std::string name = value.string(entry_words);
  const BodyGroup* group = &entry_named(value, name, scene, Entries::bodies, entry_words);
  if (group->inlet) value.fail(name + ", whose bodies come in by an inlet", "bodies that are there at the start");
  const Shape& shape = group->make(0).properties.shape;
  if (shape.kind == ShapeKind::plane) value.fail(name + ", a plane", "bodies that are no planes");
  check_turns(value, JointKind::fixed, shape);
  return *group;
}

// The bodies of the entries at rest, as a world of their own.
World world_of(const std::vector<const BodyGroup*>& groups, const Scene& scene) {
  std::vector<Body> homes, statics;
  for (const BodyGroup* group : groups)
    for (Id k = 0; k < group->count; ++k) {
      Body body = group->make(k);
      body.id = group->first + k;
      body.state.velocity.setZero(), body.state.angular_velocity.setZero();
      (group->is_static ? statics : homes).push_back(body);
    }
  std::ranges::sort(homes, {}, &Body::id), std::ranges::sort(statics, {}, &Body::id);
  return make_world(homes, statics, true, scene.period);
}

double smaller_size(const World& world, const Manifold& m) {
  const auto size = [&](Slot s) { return smallest_size(world.properties[static_cast<std::size_t>(s)].shape); };
  return std::min(size(m.slot_a), size(m.slot_b));
}

// Pairs of bodies no farther apart than the gap. A pair that touches across a border of a periodic scene is none: its joint would
// have to reach through the cell.
std::vector<Neighbours> neighbours_of(const World& world, double gap, bool planar) {
  CollideSettings settings;
  settings.step = 1e-6, settings.planar = planar, settings.margin = gap;
  if (gap < 0) {
    settings.margin = 0;
    for (std::size_t i = 0; i < world.size(); ++i)
      if (const double size = smallest_size(world.properties[i].shape); std::isfinite(size))
        settings.margin = std::max(settings.margin, usual_gap * size);
  }
  Contacts contacts;
  collide(world, settings, contacts);
  std::vector<Neighbours> pairs;
  for (std::size_t i = 0; i < contacts.manifolds.size();) {
    const Manifold& first = contacts.manifolds[i];
    const double reach = gap < 0 ? usual_gap * smaller_size(world, first) : gap;
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    int points = 0;
    bool inside = true;
    for (; i < contacts.manifolds.size() && contacts.manifolds[i].id_a == first.id_a && contacts.manifolds[i].id_b == first.id_b;
         ++i) {
      const Manifold& m = contacts.manifolds[i];
      inside = inside && m.image == Image{};
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p)
        if (contacts.points[p].gap <= reach) sum += contacts.points[p].position, normal += m.normal, ++points;
    }
    if (inside && points > 0 && normal.norm() > 1e-6)
      pairs.push_back({first.id_a, first.id_b, sum / points, normal.normalized()});
  }
  return pairs;
}

// Stiffness and strength of a beam (m long) of this radius (m).
void take_beam(const KeyedMap& beam, double radius, double length, Joint& joint) {
  joint.bears.duration = beam.number("duration");
  const double area = M_PI * radius * radius, second_moment = area * radius * radius / 4;
  if (const auto modulus = beam.number_if("youngs_modulus"))
    joint.compliance = length / (*modulus * area), joint.turning = length / (*modulus * second_moment);
  if (const auto pull = beam.number_if("tensile_strength"))
    joint.bears.tension = *pull * area, joint.bears.bending = *pull * second_moment / radius;
  if (const auto shear = beam.number_if("shear_strength"))
    joint.bears.shear = *shear * area, joint.bears.twisting = *shear * 2 * second_moment / radius;
}

BondLaw read_law(const KeyedMap& entry, const Scene& scene) {
  BondLaw law;
  law.joint.kind = JointKind::fixed;
  read_joint_behaviour(entry, scene, law.joint);
  if ((law.beam = entry.find("beam")) != nullptr) {
    for (const char* key : {"compliance", "turning_compliance", "strength"})
      if (const Value* other = entry.find(key)) other->fail(std::string(key) + " beside beam", "one of the two");
    const KeyedMap beam(*law.beam, beam_keys());
    take_beam(beam, beam.number_if("radius").value_or(1), 1, law.joint);  // numbers that are refused are so without a bond, too
  }
  law.gap = entry.number_if("gap").value_or(-1);
  return law;
}

Joint bond_of(const BondLaw& law, const World& world, const Neighbours& pair) {
  const Body a = world.body(static_cast<std::size_t>(world.find(pair.a))),
             b = world.body(static_cast<std::size_t>(world.find(pair.b)));
  Joint bond = law.joint;
  const Joint placed = joint_between(JointKind::fixed, a, &b, pair.point, joint_axes(-pair.normal));
  bond.ids = placed.ids, bond.anchor = placed.anchor, bond.frame = placed.frame, bond.lever = placed.lever;
  if (law.beam == nullptr) return bond;
  const KeyedMap beam(*law.beam, beam_keys());
  const double smaller = std::min(smallest_size(a.properties.shape), smallest_size(b.properties.shape));
  take_beam(beam, beam.number_if("radius").value_or(smaller / 2), (a.state.position - b.state.position).norm(), bond);
  return bond;
}

void read_bond(const Value& value, Scene& scene) {
  const KeyedMap entry(value, bond_keys());
  const Value& bodies = entry.need("bodies");
  std::vector<const BodyGroup*> groups;
  const auto add = [&](const Value& name) {
    const BodyGroup& group = read_entry_name(name, scene);
    if (std::ranges::find(groups, &group) != groups.end()) name.fail(name.found() + " twice", "each name once");
    groups.push_back(&group);
  };
  if (bodies.kind == Value::Kind::list)
    for (const Value& name : bodies.list("names of entries")) add(name);
  else
    add(bodies);
  const BondLaw law = read_law(entry, scene);
  const World world = world_of(groups, scene);
  const std::vector<Neighbours> pairs = neighbours_of(world, law.gap, scene.planar);
  if (pairs.empty()) bodies.fail("bodies of which no two are next to each other", "bodies nearer than gap");
  const Value* name = entry.find("name");
  auto* named = name ? &scene.joints_named[name->string("a name")] : nullptr;
  for (const Neighbours& pair : pairs) {
    if (named) named->push_back(scene.joints.size());
    scene.joints.push_back(bond_of(law, world, pair));
  }
  scene.notes.push_back(value.key + ": " + std::to_string(pairs.size()) + (pairs.size() == 1 ? " bond" : " bonds"));
}

}  // namespace

const Keys& bond_keys() {
  static const Keys table{
      "bond",
      "Fixed joints that may break, between all bodies of some entries that lie next to each other at the start.",
      {keys::other("bodies", "", entry_words, needed, "the entries whose bodies are bonded, with each other and within each",
                   [] {
                     return keys::any_of({keys::of_type("string"), keys::list_of(keys::of_type("string"))});
                   }),
       keys::text("name", "a name", "none", "by which events and files call these bonds"),
       keys::number("gap", "m", not_negative, "a hundredth of the smaller body's size",
                    "bodies whose surfaces are no farther apart than this are bonded"),
       keys::number("compliance", "m/N", not_negative, 0, "of its resistance to pulling, pressing and shear: 1 / stiffness"),
       keys::number("turning_compliance", "rad/(N m)", not_negative, 0,
                    "of its resistance to bending and twisting: 1 / stiffness"),
       keys::number("damping", "s", not_negative, 0, "rho: its rows see c + rho dc/dt"), strength_key(bond_strength_keys),
       keys::map("beam", beam_keys, "a map", "compliance and strength", "what a bond is made of"),
       keys::flag("collide", false, "bonded bodies may touch each other; those whose bond has broken do in any case")}};
  return table;
}

void read_bonds(const Value& list, Scene& scene) {
  for (const Value& entry : list.list("bonds")) read_bond(entry, scene);
}

}  // namespace unibody
