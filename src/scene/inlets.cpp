// The generator `inlet` of an entry of `bodies`.
#include <cmath>

#include "scene/generators.hpp"
#include "scene/in_time.hpp"
#include "scene/inlet.hpp"
#include "scene/inlet_mouth.hpp"
#include "scene/mix.hpp"

namespace unibody {

namespace {

struct InletBodies {
  Mix mix;
  InletMouth mouth;
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

const Keys& inlet_keys() {
  static const Keys table =
      Keys{"inlet",
           "Bodies that come in while the scene runs, at places where they touch nothing.",
           {keys::count("the most bodies that ever come in"),
            keys::number_in_time("rate", "1/s", not_negative, "a mass_rate", "bodies that become due in a second"),
            keys::number_in_time("mass_rate", "kg/s", not_negative, "a rate", "mass that becomes due in a second"),
            keys::number("from", "s", not_negative, 0, "time at which bodies begin to become due"),
            keys::number("until", "s", positive, "the end", "time from which no more become due; after `from`"), mix_key(),
            keys::seed("number that gives the random numbers")}}
          .with({"", "", inlet_mouth_keys()});
  return table;
}

Generated read_inlet(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, inlet_keys());
  InletBodies bodies;
  bodies.mouth = read_inlet_mouth(map, scene);
  bodies.mix = Mix::read(map.need("mix"), body, scene);
  bodies.seed = static_cast<std::uint64_t>(map.integer("seed"));
  bodies.planar = scene.planar, bodies.body = body;

  auto inlet = std::make_shared<Inlet>();
  map.only_one_of({"rate", "mass_rate"});
  inlet->by_mass = map.has("mass_rate");
  if (!inlet->by_mass && !map.has("rate")) value.fail_missing("rate", "bodies a second, or mass_rate (kg/s)");
  inlet->rate = read_in_time(map, inlet->by_mass ? "mass_rate" : "rate", scene);
  inlet->from = map.number("from");
  if (const auto until = map.number_if("until")) {
    inlet->until = *until;
    if (!(inlet->until > inlet->from)) map.find("until")->fail_expected("a time after `from` (s)");
  }
  inlet->low = bodies.mouth.low, inlet->high = bodies.mouth.high, inlet->largest_radius = bodies.mix.largest_radius();
  inlet->place = [bodies](Id k, std::uint64_t draw) { return bodies.place(k, draw); };
  Generated generated{map.integer("count"), bodies};
  generated.inlet = std::move(inlet);
  return generated;
}

}  // namespace unibody
