// The generator `inlet` of an entry of `bodies`.
#include <cmath>

#include "scene/generators.hpp"
#include "scene/in_time.hpp"
#include "scene/inlet.hpp"
#include "scene/mix.hpp"
#include "scene/outlets.hpp"

namespace unibody {

namespace {

constexpr Id most_bodies = 1'000'000'000'000;

// Where centres may be drawn, in the entry's frame: a box, or a disc about the origin square to z.
struct Mouth {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m
  double radius = 0;                             // m; 0: it is a box

  Vec3 draw(BodyRandom& random) const {
    const double u = random.next(), v = random.next(), w = random.next();
    if (radius == 0) return low + Vec3((high - low).array() * Vec3(u, v, w).array());
    const double r = radius * std::sqrt(u), angle = 2 * M_PI * v;
    return {r * std::cos(angle), r * std::sin(angle), 0};
  }
};

Mouth read_mouth(const Value& value, const Scene& scene) {
  const Value *box = value.find("box"), *disc = value.find("disc");
  if (box && disc) disc->fail("disc beside box", "only one of them");
  if (!box && !disc) value.fail_missing("box", "a map with low and high, or disc: one with radius");
  Mouth mouth;
  if (box) {
    std::tie(mouth.low, mouth.high) = read_corners(*box, scene.planar);
    if (scene.planar && (mouth.low.y() != 0 || mouth.high.y() != 0))
      box->fail("a box that leaves the plane", "0 as the second of three numbers (m; planar scene)");
    return mouth;
  }
  if (scene.planar) disc->fail_expected("a box (planar scene)");
  disc->map({"radius"});
  mouth.radius = disc->need("radius", "a number > 0 (m)").number(positive, "m");
  mouth.low = {-mouth.radius, -mouth.radius, 0}, mouth.high = -mouth.low;
  return mouth;
}

struct InletBodies {
  Mix mix;
  Mouth mouth;
  std::uint64_t seed = 1;
  bool planar = false;
  BodyTemplate body;

  Body at(Id k, const Vec3& centre, BodyRandom& turns) const {
    BodyRandom random(seed, k);
    const Shape shape = mix.draw(random);
    if (!planar) return make_body(body, shape, centre, random_orientation(turns));
    return make_body(body, shape, centre, Quat(Eigen::AngleAxisd(turns.between(-M_PI, M_PI), Vec3::UnitY())));
  }
  Body operator()(Id k) const {  // before it comes in
    BodyRandom turns(mixed(seed), k);
    return at(k, 0.5 * (mouth.low + mouth.high), turns);
  }
  Body place(Id k, std::uint64_t draw) const {
    BodyRandom random(mixed(seed + 1) ^ mixed(draw), k);
    const Vec3 centre = mouth.draw(random);
    return at(k, centre, random);
  }
};

}  // namespace

Generated read_inlet(const Value& value, const BodyTemplate& body, const Scene& scene) {
  value.map({"count", "box", "disc", "rate", "mass_rate", "from", "until", "mix", "seed"});
  InletBodies bodies;
  bodies.mouth = read_mouth(value, scene);
  bodies.mix = Mix::read(value.need("mix", "a list of shapes with share and scale"), body, scene);
  if (const Value* seed = value.find("seed")) bodies.seed = static_cast<std::uint64_t>(seed->integer(0));
  bodies.planar = scene.planar, bodies.body = body;

  auto inlet = std::make_shared<Inlet>();
  const Value *rate = value.find("rate"), *mass_rate = value.find("mass_rate");
  if (rate && mass_rate) mass_rate->fail("mass_rate beside rate", "only one of them");
  if (!rate && !mass_rate) value.fail_missing("rate", "bodies a second, or mass_rate (kg/s)");
  inlet->by_mass = mass_rate != nullptr;
  inlet->rate = rate ? read_in_time(*rate, not_negative, "1/s") : read_in_time(*mass_rate, not_negative, "kg/s");
  if (const Value* from = value.find("from")) inlet->from = from->number(not_negative, "s");
  if (const Value* until = value.find("until")) {
    inlet->until = until->number(positive, "s");
    if (!(inlet->until > inlet->from)) until->fail_expected("a time after `from` (s)");
  }
  inlet->low = bodies.mouth.low, inlet->high = bodies.mouth.high, inlet->largest_radius = bodies.mix.largest_radius();
  inlet->place = [bodies](Id k, std::uint64_t draw) { return bodies.place(k, draw); };
  Generated generated{value.need("count", "an integer >= 1").integer(1, most_bodies), bodies};
  generated.inlet = std::move(inlet);
  return generated;
}

}  // namespace unibody
